"""What it costs to encode and to decode one frame, beside cantools on the same frames.

The frames are those that a busy arm bus carries in 20 ms, in their shares. Each round measures the
codec, cantools and an empty loop one after the other, so that what disturbs the machine disturbs
all of them.
"""

from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path
from statistics import median

from cantools.database import Database, load_string

from hal.wire import analog, inertial, motor, motor_periodic, skin
from hal.wire.analog import FORCE, TORQUE
from hal.wire.can import Frame
from hal.wire.catalogue import Direction, decode
from hal.wire.dbc import Node, dbc_text
from hal.wire.message import PolledMessage
from services.core.clock import RealClock
from services.experiments.rows import Row, at_least, at_most, publish

FRAME_BAR_US = 1.5
RATIO_BAR = 8.0
ROUNDS = 30
PASSES = 20  # over the mix, in one measurement of the codec
PEER_PASSES = 1

Values = tuple[int, ...]
Encode = Callable[..., Frame]
Parse = Callable[[bytes], Values | None]

# encode, its arguments, how often in 20 ms
_MIX: Sequence[tuple[Encode, Values, int]] = (
    (motor_periodic.POSITION.frame, (1, 2104, 3526), 10),
    (motor_periodic.PID_VAL.frame, (1, 120, -45, 118, -44), 10),
    (motor_periodic.VELOCITY.frame, (2, 350, -120, 0, 0), 10),
    (motor_periodic.STATUS.frame, (2, 0, 0, 0, 1, 0, 0, 0, 0), 1),
    (motor_periodic.CURRENT.frame, (1, 350, -120), 5),
    (FORCE.frame, (13, 0x8000, 0x7F3A, 0x8341), 20),
    (TORQUE.frame, (13, 0x83C4, 0x7E2C, 0x812A), 20),
    (FORCE.frame, (12, 0xBFFF, 0x6001, 0x8000), 5),
    (TORQUE.frame, (12, 0x87FF, 0x8000, 0x8000), 5),
    (motor.SET_COMMAND_POSITION.request, (2, 1, 1376), 8),
    (motor.POSITION_MOVE.request, (1, 0, 2104, 11), 2),
    (motor.SET_IMPEDANCE_OFFSET.request, (1, 0, -1200), 4),
    (motor.GET_ENCODER_POSITION.reply, (1, 0, 2104, 12), 2),
    (analog.GET_FULL_SCALES.reply, (13, 0, 1521), 1),
    (inertial.ACCELEROMETER.frame, (14, 12, -7, 16384), 2),
    (skin.HEAD.frame, (14, 3, 240, 239, 238, 237, 236, 235, 234), 8),
    (skin.TAIL.frame, (14, 3, 240, 239, 238, 237, 236, 0, 0), 8),
)
_NODES = (
    *(Node(address, "bll_ie", f"board{address}") for address in (1, 2)),
    Node(12, "virtual", "virtual"),
    Node(13, "strain", "strain"),
    Node(14, "mtb", "mtb"),
)


def codec_rows(rounds: int = ROUNDS) -> list[Row]:
    """Encode and decode: median time of one frame, ratio to cantools, and the empty loop."""
    now_ns = RealClock().now_ns
    frames, works = _works()
    times_us: list[list[float]] = [[] for _ in works]
    for _ in range(rounds):
        for (work, passes), taken_us in zip(works, times_us, strict=True):
            begin_ns = now_ns()
            for _ in range(passes):
                work()
            taken_us.append((now_ns() - begin_ns) / 1e3 / passes / frames)
    encode_us, decode_us, empty_us, peer_encode_us, peer_decode_us = map(median, times_us)
    return [
        Row("codec: frames in the mix", float(frames)),
        at_most("codec: encode one frame, median", encode_us, "us", FRAME_BAR_US),
        at_most("codec: decode one frame, median", decode_us, "us", FRAME_BAR_US),
        Row("codec: empty loop with one call, median", empty_us, "us"),
        Row("codec: cantools encodes one frame, median", peer_encode_us, "us"),
        Row("codec: cantools decodes one frame, median", peer_decode_us, "us"),
        at_least("codec: cantools / ours, encode", peer_encode_us / encode_us, "", RATIO_BAR),
        at_least("codec: cantools / ours, decode", peer_decode_us / decode_us, "", RATIO_BAR),
    ]


def _works() -> tuple[int, list[tuple[Callable[[], None], int]]]:
    """How many frames the mix has, and what to time with how often to repeat it."""
    jobs = [(encode, values) for encode, values, count in _MIX for _ in range(count)]
    frames = [encode(*values) for encode, values in jobs]
    parsers = [(_parser(can_id, data), data) for can_id, data in frames]
    database = load_string(dbc_text(_NODES), "dbc", strict=True)
    assert isinstance(database, Database)
    check_agreement(frames, [_peer_values(database, can_id, data) for can_id, data in frames])
    whole = [(can_id, _whole_message(database, can_id, data)) for can_id, data in frames]

    ours = [partial(_encode, jobs), partial(_decode, parsers), partial(_idle, jobs)]
    theirs = [partial(_peer_encode, database, whole), partial(_peer_decode, database, frames)]
    return len(frames), [
        *((work, PASSES) for work in ours),
        *((work, PEER_PASSES) for work in theirs),
    ]


def _encode(jobs: list[tuple[Encode, Values]]) -> None:
    for encode, values in jobs:
        encode(*values)


def _decode(parsers: list[tuple[Parse, bytes]]) -> None:
    for parse, data in parsers:
        parse(data)


def _idle(jobs: list[tuple[Encode, Values]]) -> None:
    for _, values in jobs:
        _do_nothing(*values)


def _peer_encode(database: Database, messages: list[tuple[int, dict[str, int]]]) -> None:
    for can_id, values in messages:
        database.encode_message(can_id, values, padding=True, strict=False)


def _peer_decode(database: Database, frames: list[Frame]) -> None:
    for can_id, data in frames:
        database.decode_message(can_id, data, decode_choices=False, allow_truncated=True)


def check_agreement(frames: Sequence[Frame], readings: Sequence[dict[str, int]]) -> None:
    """Both must have read the same values, or the comparison is of different work."""
    for (can_id, data), reading in zip(frames, readings, strict=True):
        ours = decode(can_id, data).values
        assert sorted(ours) == sorted(
            value for name, value in reading.items() if name not in ("command", "axis", "half")
        ), f"{can_id:03X} {data.hex()}: {ours} and {reading}"


def _parser(can_id: int, data: bytes) -> Parse:
    """What a board or the HAL calls with such a payload once it knows the message."""
    form = decode(can_id, data).form
    assert form is not None
    assert form.row is not None
    if not isinstance(form.row, PolledMessage):
        return form.row.parse
    is_reply = form.direction == Direction.REPLY
    return form.row.parse_reply if is_reply else form.row.parse_request


def _peer_values(database: Database, can_id: int, data: bytes) -> dict[str, int]:
    values = database.decode_message(can_id, data, decode_choices=False, allow_truncated=True)
    assert isinstance(values, dict)
    return {name: value for name, value in values.items() if isinstance(value, int)}


def _whole_message(database: Database, can_id: int, data: bytes) -> dict[str, int]:
    """Every value that cantools wants in order to encode: the saturation byte, too, as zero."""
    length = database.get_message_by_frame_id(can_id).length
    return _peer_values(database, can_id, data.ljust(length, b"\0"))


def _do_nothing(*values: int) -> None:
    """As many arguments as the codec gets."""


def main(json_file: Path | None = None) -> int:
    """Print the table."""
    return publish("CAN codec", codec_rows(), json_file)


if __name__ == "__main__":
    raise SystemExit(main())
