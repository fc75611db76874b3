"""Joints that are to take set-points, as the Python client asks for it."""

from services.core.client import Client
from services.core.clock import NS_PER_MS, NS_PER_S, Clock
from services.reaching.client_types import RequestRefusedError, WaitTimeoutError
from services.robot_messages import RobotRequest
from services.streams import ROBOT_CALL, ROBOT_STATUS

LOOK_NS = 20 * NS_PER_MS


def switch_to_direct(bus: Client, clock: Clock, joints: tuple[str, ...], timeout_s: float) -> None:
    """Have joints take set-points as they come: position-direct mode.

    Raises:
        RequestRefusedError: they cannot, for instance because they are not calibrated.
        WaitTimeoutError: it takes too long.
    """
    bus.watch(ROBOT_STATUS)
    request = RobotRequest(action="mode", joints=joints, value="direct")
    reply = bus.call(ROBOT_CALL, request)
    if not reply.ok:
        raise RequestRefusedError(
            f"{reply.reason}; `ulna joints calibrate` calibrates joints and switches them on"
        )
    end_ns = clock.now_ns() + round(timeout_s * NS_PER_S)
    while clock.now_ns() < end_ns:
        for status in bus.new(ROBOT_STATUS):
            failed = dict(status.failed_tasks).get(reply.task)
            if failed is not None:
                raise RequestRefusedError(failed)
            if status.finished_task >= reply.task:
                return
        clock.sleep_until(clock.now_ns() + LOOK_NS)
    raise WaitTimeoutError(f"joints are not in position-direct mode after {timeout_s:g} s")
