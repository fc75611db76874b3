"""`ulna can send`: one frame by name and values, or as identifier and bytes."""

import sys
from collections.abc import Callable, Sequence

from hal.wire import analog, skin
from hal.wire.can import EVERYBODY, Frame, low_of, source_of
from hal.wire.catalogue import POLLED_CLASSES, Direction, Form, decode, named
from hal.wire.layout import Field, Layout, WireError
from hal.wire.message import AxisCommand, Command, PeriodicMessage
from services.cli.can_buses import Tap, arrivals, opened, robot_in_use
from services.cli.can_danger import danger
from services.cli.can_dump import line
from services.cli.can_names import BusNames
from services.core.clock import NS_PER_S, Clock, RealClock
from services.core.errors import ConfigError, ServiceError

MOST_BYTES = 8
HIGHEST_ID = 0x7FF


def raw_frame(text: str) -> Frame:
    """The frame of `001#1B380800000B00`; dots and blanks between bytes are allowed.

    Raises:
        ConfigError: no such frame can be sent.
    """
    head, _, tail = text.partition("#")
    try:
        can_id = int(head, 16)
        data = bytes.fromhex(tail.replace(".", " "))
    except ValueError as error:
        raise ConfigError(
            f"{text!r} is no frame: {error}; write it as 001#1B380800000B00"
        ) from error
    if not 0 <= can_id <= HIGHEST_ID or len(data) > MOST_BYTES:
        raise ConfigError(f"{text!r} is no frame: identifier up to 7FF, up to 8 bytes")
    return can_id, data


def named_frame(
    name: str, values: Sequence[str], names: BusNames, *, to: str, joint: str, axis: int
) -> Frame:
    """The frame of a message of the frame tables.

    `to` is a board, an address or "everybody": who receives a request, or who sends a broadcast.
    `joint` says board and axis at once.

    Raises:
        ConfigError: no such message, board, joint or value; the text says what there is.
    """
    address = None
    if joint:
        place = names.place(joint)
        if place is None:
            raise ConfigError(f"bus {names.bus!r} has no joint {joint!r}")
        address, axis = place
    elif to:
        address = _address(to, names)
    form = _form(name, len(values))
    if address is None:
        raise ConfigError(f"{name}: say which board with --to or --joint")
    if axis not in (0, 1):
        raise ConfigError(f"--axis {axis}: an address has the axes 0 and 1")
    given = _values(form, values)
    try:
        return _encoded(form, address, axis, given)
    except WireError as error:
        raise ConfigError(str(error)) from error


def _address(text: str, names: BusNames) -> int:
    if text == "everybody":
        return EVERYBODY
    known = names.address(text)
    if known is not None:
        return known
    try:
        address = int(text, 0)
    except ValueError:
        address = -1
    if not 0 <= address <= EVERYBODY:
        raise ConfigError(f"bus {names.bus!r} has no board {text!r}")
    return address


def _form(name: str, count: int) -> Form:
    """The request or broadcast of a name; of several lengths the one that so many values fit."""
    forms = [form for form in named(name) if form.direction != Direction.REPLY]
    if not forms:
        raise ConfigError(f"no message {name!r}; docs/protocol.md (ulna can docs) lists them")
    classes = {form.can_class for form in forms}
    if len(classes) > 1:
        choices = ", ".join(f"{can_class}:{forms[0].name}" for can_class in sorted(classes))
        raise ConfigError(f"{name} is a message of several classes; write one of {choices}")
    return next((form for form in forms if len(form.layout.fields) == count), forms[-1])


def _values(form: Form, texts: Sequence[str]) -> tuple[int, ...]:
    """Numbers in the order of the fields, from `5`, `0x20`, `POSITION` or `mode=POSITION`."""
    fields = form.layout.fields
    if not any("=" in text for text in texts):
        pairs = list(zip(fields, texts, strict=False))
        if len(texts) > len(fields):
            raise ConfigError(f"{form.name} carries {_names(form.layout)}; got {len(texts)} values")
        return tuple(_number(form, field, text) for field, text in pairs)
    by_name = dict(text.partition("=")[::2] for text in texts)
    unknown = set(by_name) - {field.name for field in fields}
    if unknown or len(by_name) != len(fields):
        raise ConfigError(f"{form.name} carries {_names(form.layout)}; got {', '.join(by_name)}")
    return tuple(_number(form, field, by_name[field.name]) for field in fields)


def _names(layout: Layout) -> str:
    return ", ".join(field.name for field in layout.fields) or "nothing"


def _number(form: Form, field: Field, text: str) -> int:
    if field.choices is not None:
        for choice in field.choices:
            if choice.name == text.upper():
                return int(choice)
    try:
        return int(text, 0)
    except ValueError as error:
        known = (
            "" if field.choices is None else f": {', '.join(str(c.name) for c in field.choices)}"
        )
        raise ConfigError(f"{form.name}: {field.name}={text} is no number{known}") from error


def _encoded(form: Form, address: int, axis: int, values: tuple[int, ...]) -> Frame:
    row = form.row
    if isinstance(row, AxisCommand):
        return row.request(address, axis, *values)
    if isinstance(row, Command):
        return row.request(address, *values)
    if isinstance(row, PeriodicMessage):
        return row.frame(address, *values)
    if isinstance(row, analog.TripleMessage) and len(values) in (3, 4):
        return row.frame(address, *values)
    if isinstance(row, skin.TriangleMessage):
        raise ConfigError(f"{form.name}: send skin frames as identifier#bytes")
    raise WireError(f"{form.name} carries {_names(form.layout)}; got {len(values)} values")


def is_answer(question: Frame, can_id: int, data: bytes) -> bool:
    """Whether a frame answers a request: from its receiver, in its class, with its code."""
    asked_id, asked = question
    polled = asked_id >> 8 in POLLED_CLASSES and can_id >> 8 == asked_id >> 8
    from_receiver = low_of(asked_id) in (source_of(can_id), EVERYBODY)
    from_board = low_of(can_id) == source_of(asked_id) and source_of(can_id) != low_of(can_id)
    return polled and from_receiver and from_board and (not data or data[:1] == asked[:1])


def send(tap: Tap, frame: Frame, clock: Clock, wait_s: float, say: Callable[[str], None]) -> int:
    """Send a frame, say what it was, and what answers for a while; returns how many did."""
    begin_ns, lost = clock.now_ns(), tap.bus.frames_lost
    tap.bus.send_frames((frame,))
    if tap.bus.frames_lost > lost:
        raise ServiceError(f"bus {tap.name} did not take the frame: it is off, or full")
    said = tap.names.name(*frame)
    say(line(tap.names, (*frame, begin_ns), 0, said))
    answers = 0
    until_ns = begin_ns + round(wait_s * NS_PER_S)
    for frames in arrivals((tap,), clock, until_ns):
        for _, (can_id, data, stamp_ns) in frames:
            if is_answer(frame, can_id, data):
                answers += 1
                named_answer = tap.names.name(can_id, data)
                say(line(tap.names, (can_id, data, stamp_ns), stamp_ns - begin_ns, named_answer))
    return answers


def expects_answer(frame: Frame) -> bool:
    """Whether the frame tables know an answer to it."""
    decoded = decode(*frame)
    if decoded.form is None or decoded.form.direction != Direction.REQUEST:
        return False
    forms = named(f"{decoded.form.can_class}:{decoded.form.name}")
    return any(form.direction == Direction.REPLY for form in forms)


def can_send(
    bus: str,
    message: str,
    *values: str,
    to: str = "",
    joint: str = "",
    axis: int = 0,
    robot: str = "",
    stack: str = "",
    wait: float = 0.1,
    yes: bool = False,
) -> int:
    """Send one frame past the HAL, and show what answers.

    Dangerous ones (discovery, what moves a joint, addresses, firmware) need --yes.

    Examples: ulna can send right_arm GET_POS_PID --joint r_elbow;
    ulna can send vcan2 002#5302

    Args:
        bus: bus of the robot, its number, an interface, or interface:channel of python-can.
        message: name in the frame tables (7:GET_ADDITIONAL_INFO names the class), or id#bytes.
        values: in the order of the fields, or name=value; codes by name or number.
        to: board or address that receives a request or sends a broadcast; everybody.
        joint: instead of --to and --axis.
        axis: 0 or 1 of the address.
        robot: whose buses and boards they are [the running stack's, else icub].
        stack: name of a running stack [the robot's].
        wait: seconds to wait for answers.
        yes: send it although it is dangerous.

    Returns:
        Exit status: 0 sent, 1 it should have been answered and was not.
    """
    clock = RealClock()
    with opened(robot_in_use(robot, stack), (bus,), stack=stack, clock=clock) as (tap,):
        if "#" in message:
            frame = raw_frame(message)
        else:
            frame = named_frame(message, values, tap.names, to=to, joint=joint, axis=axis)
        reason = danger(*frame)
        if reason and not yes:
            text = tap.names.text(tap.names.name(*frame))
            raise ConfigError(f"not sent: {text}: {reason}; --yes sends it")
        answers = send(tap, frame, clock, wait, print)
    if expects_answer(frame) and not answers:
        print("no answer", file=sys.stderr)
        return 1
    return 0
