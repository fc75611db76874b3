"""`ulna learner`: what the learner of a running stack has learned, and requests to it."""

from pathlib import Path

from rich.console import Console
from rich.table import Table

from services.cli.complaint import complain
from services.cli.dynamics_client import DynamicsClient
from services.core.errors import ServiceError
from services.streams import LEARNER_CALL, LEARNER_STATUS
from services.wholebody.dynamics_messages import LearnerRequest, LearnerStatus

FAILED = 2
REFUSED = 1


def learner_status(*, stack: str = "icub") -> int:
    """How well FT readings are predicted: by the model alone, and with what was learned.

    Example: ulna learner status

    Args:
        stack: name of the running stack.

    Returns:
        Exit status: 0, 2 without an answer.
    """
    try:
        with DynamicsClient(stack) as client:
            status = client.newest(LEARNER_STATUS)
            if status is None:
                raise ServiceError(_silence(client, stack))
    except ServiceError as error:
        complain(error)
        return FAILED
    Console().print(learner_table(status))
    if status.snapshot:
        print(f"state: {status.snapshot}")
    if status.reason:
        print(status.reason)
    return 0


def learner_save(file: Path, /, *, stack: str = "icub") -> int:
    """Write what was learned into a file.

    Example: ulna learner save arms.state

    Args:
        file: where to.
        stack: name of the running stack.

    Returns:
        Exit status: 0, 1 when refused, 2 without an answer.
    """
    return _request(LearnerRequest(action="save", value=str(file.absolute())), stack)


def learner_restore(file: Path, /, *, stack: str = "icub") -> int:
    """Go on with what a file holds; what was learned since is lost.

    Example: ulna learner restore arms.state

    Args:
        file: written by `ulna learner save`.
        stack: name of the running stack.

    Returns:
        Exit status: 0, 1 when refused, 2 without an answer.
    """
    return _request(LearnerRequest(action="restore", value=str(file.absolute())), stack)


def learner_reset(*sensors: str, stack: str = "icub") -> int:
    """Forget what was learned of FT sensors, all or those named.

    Example: ulna learner reset r_arm_ft

    Args:
        sensors: names of sensors. Default: all.
        stack: name of the running stack.

    Returns:
        Exit status: 0, 1 when refused, 2 without an answer.
    """
    return _request(LearnerRequest(action="reset", sensors=sensors), stack)


def learner_freeze(*, stack: str = "icub") -> int:
    """Stop learning and go on predicting.

    Example: ulna learner freeze

    Args:
        stack: name of the running stack.

    Returns:
        Exit status: 0, 1 when refused, 2 without an answer.
    """
    return _request(LearnerRequest(action="freeze"), stack)


def learner_resume(*, stack: str = "icub") -> int:
    """Learn again after a freeze, or where a long contact has left learning held back.

    Example: ulna learner resume

    Args:
        stack: name of the running stack.

    Returns:
        Exit status: 0, 1 when refused, 2 without an answer.
    """
    return _request(LearnerRequest(action="resume"), stack)


def learner_table(status: LearnerStatus) -> Table:
    """A row for each FT sensor."""
    table = Table(
        "sensor",
        "updates",
        "error N",
        "model alone N",
        "held back",
        "remark",
        title=f"learner: {status.state}, {status.features} random features",
    )
    for sensor in status.sensors:
        table.add_row(
            sensor.name,
            str(sensor.updates),
            f"{sensor.error_n:.3f}",
            f"{sensor.model_error_n:.3f}",
            "yes" if sensor.gated else "",
            sensor.reason,
        )
    return table


def _request(request: LearnerRequest, stack: str) -> int:
    try:
        with DynamicsClient(stack) as client:
            if "learner" not in client.bus.alive():
                raise ServiceError(_silence(client, stack))
            reply = client.call(LEARNER_CALL, request)
    except ServiceError as error:
        complain(error)
        return FAILED
    if not reply.ok:
        complain(reply.reason)
        return REFUSED
    print(f"{request.action}: done")
    return 0


def _silence(client: DynamicsClient, stack: str) -> str:
    client.check_up()
    if "learner" not in client.bus.alive():
        return (
            f"no learner process in stack {stack!r}: its parts have no force/torque sensor, "
            f"or it has ended; see `ulna up`'s log"
        )
    return "the learner is silent: dynamics sends no samples; see `ulna dynamics status`"
