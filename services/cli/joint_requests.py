"""A request to the robot service of a running stack, followed until it has been carried out."""

from rich.console import Console
from rich.progress import Progress, SpinnerColumn, TextColumn, TimeElapsedColumn

from services.cli.stack_client import StackClient
from services.core.clock import NS_PER_S
from services.core.errors import ServiceError
from services.messages import Reply
from services.robot_messages import RobotRequest, RobotStatus
from services.streams import ROBOT_CALL, ROBOT_STATUS

STARTING = ("opening", "handshake", "configuring")
STARTING_PATIENCE_S = 30.0  # boards are looked for and get their settings
PATIENCE_S = {"calibrate": 180.0}
SHORT_PATIENCE_S = 30.0


class RefusedError(ServiceError):
    """The robot service refused a request, or could not carry it out; the text says why."""


def carry_out(client: StackClient, word: str, request: RobotRequest) -> None:
    """Ask for it, and return when it is done; `word` is what the user calls it.

    Raises:
        RefusedError: refused, or failed on the way.
        ServiceError: no answer, or no end.
    """
    columns = (SpinnerColumn(), TextColumn("{task.description}"), TimeElapsedColumn())
    console = Console(stderr=True)
    silent = not console.is_terminal
    with Progress(*columns, console=console, transient=True, disable=silent) as progress:
        line = progress.add_task(word, total=None)
        end_ns = client.clock.now_ns() + round(STARTING_PATIENCE_S * NS_PER_S)
        while (status := client.wait_for(ROBOT_STATUS)).phase in STARTING:
            progress.update(line, description=f"{word}: waits, the robot is {status.phase}")
            if client.clock.now_ns() >= end_ns:
                raise RefusedError(
                    f"{word}: the robot is still in phase {status.phase} after "
                    f"{STARTING_PATIENCE_S:g} s; are the boards powered and found "
                    f"(`ulna can scan`)?"
                )
        reply = client.call(ROBOT_CALL, request)
        if not reply.ok:
            raise RefusedError(f"{word} refused: {reply.reason}{advice(request, reply)}")
        patience_s = PATIENCE_S.get(request.action, SHORT_PATIENCE_S)
        end_ns = client.clock.now_ns() + round(patience_s * NS_PER_S)
        while not is_done(word, status := client.wait_for(ROBOT_STATUS), reply.task):
            progress.update(line, description=progress_line(word, request, status))
            if client.clock.now_ns() >= end_ns:
                raise ServiceError(
                    f"{word} is not done after {patience_s:g} s and goes on in the running stack; "
                    f"`ulna joints park` ends it"
                )


def is_done(word: str, status: RobotStatus, task: int) -> bool:
    """Whether a task has ended well.

    Raises:
        RefusedError: it has failed.
    """
    failed = dict(status.failed_tasks).get(task)
    if failed is not None:
        raise RefusedError(f"{word} failed: {failed.partition(': ')[2]}")  # behind the action
    return status.finished_task >= task


def progress_line(word: str, request: RobotRequest, status: RobotStatus) -> str:
    """What is under way, and of a calibration how far it has come."""
    if request.action != "calibrate":
        return f"{word}: {status.phase}"
    states = dict(status.calibration)
    done = sum(states.get(joint) == "done" for joint in request.joints)
    return f"{word}: {done} of {len(request.joints)} joints calibrated"


def advice(request: RobotRequest, reply: Reply) -> str:
    """Which verb mends what a request was refused for; empty where none does."""
    if request.action != "calibrate" and (
        "is not calibrated" in reply.reason or "request mode position first" in reply.reason
    ):
        return " (`ulna joints calibrate` calibrates joints and switches them on)"
    if "no fresh joint torques" in reply.reason:
        return " (`ulna dynamics calibrate` makes them known)"
    return ""
