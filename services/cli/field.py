"""`ulna field`: where the hand is drawn, around what, and by which law."""

from typing import Literal

from rich.console import Console, Group
from rich.live import Live

from services.cli.complaint import complain
from services.cli.field_tables import (
    field_remarks,
    fields_table,
    gains_table,
    objects_table,
    progress_line,
    status_lines,
)
from services.core.errors import ConfigError, ServiceError
from services.fields.client_blocking import BlockingFieldControl
from services.fields.client_goals import make_goal
from services.fields.messages import FieldRequest, FieldStatus
from services.messages import Goal
from services.reaching.client_types import RequestRefusedError, WaitTimeoutError

REFUSED = 1
FAILED = 2
INTERRUPTED = 130
NO_WAY_S = 3.0  # unreachable for so long: the command ends, the goal stays
LOOK_S = 0.2
VARIANTS = {"A": 0.0, "B": 1.0}  # of pmp

Triple = tuple[float, float, float]
ModeName = Literal["", "ulna", "dforc", "pmp"]


def field_status(*, once: bool = False, stack: str = "icub") -> int:
    """What the field does, live on a terminal until Ctrl-C: state, reason, every field.

    Example: ulna field status --once

    Args:
        once: one look, also on a terminal.
        stack: name of the running stack.

    Returns:
        Exit status: 0, 2 without an answer.
    """
    console = Console()
    try:
        with BlockingFieldControl(stack) as control:
            if once or not console.is_terminal:
                console.print(_shown(control.status()))
                return 0
            with Live(console=console, auto_refresh=False) as live:
                while True:
                    live.update(_shown(control.next_status()), refresh=True)
    except KeyboardInterrupt:
        return 0
    except ServiceError as error:
        return _complain(error)


def field_mode(mode: ModeName = "", /, *, paper: bool = False, stack: str = "icub") -> int:
    """Show the mode and its gains, or change it; a point in motion goes on where it is.

    Example: ulna field mode dforc --paper

    Args:
        mode: ulna: the whole arm touches nothing. dforc: the paper's force field. pmp: passive
            motion. Without one: the mode in use.
        paper: with the gains of the papers.
        stack: name of the running stack.

    Returns:
        Exit status: 0, 1 when refused, 2 without an answer.
    """
    return _set(stack, mode, "paper" if paper else "", ())


def field_set(
    *gains: str,
    mode: ModeName = "",
    paper: bool = False,
    default: bool = False,
    stack: str = "icub",
) -> int:
    """Change gains, at once and without a jump of the point.

    Example: ulna field set K=9 margin=0.03

    Args:
        gains: NAME=VALUE; `ulna field info` lists them with units and bounds.
        mode: change to that mode, too.
        paper: first take all gains of the papers.
        default: first take all gains back to where they were at the start.
        stack: name of the running stack.

    Returns:
        Exit status: 0, 1 when refused, 2 without an answer or for no gain.
    """
    if paper and default:
        complain("give --paper or --default, not both")
        return FAILED
    if not (gains or paper or default or mode):
        complain("nothing to set: NAME=VALUE, --paper or --default; see `ulna field info`")
        return FAILED
    return _set(stack, mode, "paper" if paper else "default" if default else "", gains)


def field_info(*, stack: str = "icub") -> int:
    """Modes with gains, limbs, and the objects that the sources have sent.

    Example: ulna field info

    Args:
        stack: name of the running stack.

    Returns:
        Exit status: 0, 2 without an answer.
    """
    try:
        with BlockingFieldControl(stack) as control:
            info = control.info()
    except ServiceError as error:
        return _complain(error)
    console = Console()
    print(f"mode {info.mode}; limbs: {', '.join(info.limbs)} (the first choice: {info.limb})")
    for mode in info.modes:
        console.print(gains_table(mode))
        print(f"{mode.name}: {mode.promises}\n")
    console.print(objects_table(info))
    return 0


def field_goal(
    position: Triple | None = None,
    /,
    *,
    rotation: Triple | None = None,
    follow: str = "",
    second_position: Triple | None = None,
    second_rotation: Triple | None = None,
    limb: str = "",
    timeout: float = 30.0,
    wait: bool = True,
    stack: str = "icub",
) -> int:
    """Send a hand to a place around everything in the way, and show how it goes.

    Its joints have to be calibrated (`ulna joints calibrate`) and to take set-points (`ulna joints
    direct`).

    Example: ulna field goal -0.4 0.1 0.1 --rotation -0.4 -2.4 1.8

    Args:
        position: X Y Z of the hand, m, base frame; of the left one of both arms.
        rotation: its orientation as a rotation vector, rad. None: any.
        follow: name of an object, instead of a position: its centre, wherever it goes.
        second_position: of both arms' right hand.
        second_rotation: of both arms' right hand.
        limb: right_arm, left_arm or both_arms. Default: the main job's.
        timeout: how long to wait, s.
        wait: until it has arrived.
        stack: name of the running stack.

    Returns:
        Exit status: 0 arrived, or begun, 1 refused, no way or no time left, 2 without an answer.
    """
    try:
        goal = _goal(position, rotation, follow, second_position, second_rotation, limb)
        with BlockingFieldControl(stack) as control:
            reply = control.ask(FieldRequest(action="goal", goal=goal))
            if not wait:
                print(f"goal {reply.goal} is taken up{reply.reason and ': ' + reply.reason}")
                return 0
            return _watch(control, reply.goal, timeout)
    except KeyboardInterrupt:
        complain("the goal stays in the running stack; `ulna field stop` withdraws it")
        return INTERRUPTED
    except ServiceError as error:
        return _complain(error)


def field_stop(*, stack: str = "icub") -> int:
    """Withdraw the goal; the hand comes to rest.

    Example: ulna field stop

    Args:
        stack: name of the running stack.

    Returns:
        Exit status: 0, 2 without an answer.
    """
    try:
        with BlockingFieldControl(stack) as control:
            control.stop()
    except ServiceError as error:
        return _complain(error)
    print("stopping")
    return 0


def _goal(
    position: Triple | None,
    rotation: Triple | None,
    follow: str,
    second_position: Triple | None,
    second_rotation: Triple | None,
    limb: str,
) -> Goal:
    if (position is None) == (not follow):
        raise ConfigError("a goal is a position X Y Z, or --follow an object; one of the two")
    return make_goal(
        position or (0.0, 0.0, 0.0),
        rotation,
        limb=limb,
        second_position_m=second_position,
        second_rotation=second_rotation,
        follow=follow,
    )


def _watch(control: BlockingFieldControl, goal: int, timeout_s: float) -> int:
    """Show progress until it has arrived, cannot, or the time is up."""
    console = Console()
    left_s, hopeless_s = timeout_s, 0.0
    with console.status("taken up") as shown:
        while left_s > 0.0:
            try:
                status = control.wait_for("arrived", goal=goal, timeout_s=min(LOOK_S, left_s))
            except WaitTimeoutError:
                status = control.status()
                shown.update(progress_line(status))
            if status.last_goal > goal:
                complain(f"goal {status.last_goal} has taken the place of goal {goal}")
                return REFUSED
            if status.last_goal == goal and not status.goal:
                complain(f"goal {goal} was withdrawn")
                return REFUSED
            if status.goal == goal and status.state == "arrived":
                print(progress_line(status))
                return 0
            hopeless_s = hopeless_s + LOOK_S if status.state == "unreachable" else 0.0
            left_s -= LOOK_S
            if hopeless_s >= NO_WAY_S:
                break
    complain(progress_line(control.status()))
    complain("the goal stays in use; `ulna field stop` withdraws it")
    return REFUSED


def _set(stack: str, mode: str, preset: str, words: tuple[str, ...]) -> int:
    try:
        pairs = dict(_pair(word) for word in words)
        with BlockingFieldControl(stack) as control:
            if mode or preset or pairs:
                control.set(mode, preset=preset, gains=pairs)
            info = control.info()
    except ServiceError as error:
        return _complain(error)
    (used,) = (one for one in info.modes if one.name == info.mode)
    Console().print(gains_table(used))
    print(f"{used.name}: {used.promises}")
    return 0


def _pair(word: str) -> tuple[str, float]:
    name, _, number = word.partition("=")
    try:
        return name, VARIANTS[number] if number in VARIANTS else float(number)
    except ValueError as error:
        raise ConfigError(f"{word!r} is no gain: NAME=VALUE, such as K=9") from error


def _shown(status: FieldStatus) -> Group:
    return Group(
        "\n".join(status_lines(status)),
        fields_table(status.fields),
        *field_remarks(status.fields),
    )


def _complain(error: ServiceError) -> int:
    complain(error)
    refused = (RequestRefusedError, WaitTimeoutError)
    return REFUSED if isinstance(error, refused) else FAILED
