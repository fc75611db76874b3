"""Moves a limb slowly through postures, so that a sensor in it feels its weight from all sides."""

import math
from collections.abc import Mapping

from services.cli.dynamics_client import DynamicsClient
from services.cli.joint_requests import advice
from services.core.clock import NS_PER_S
from services.core.errors import ServiceError
from services.robot_messages import RobotRequest
from services.robotfile.robot_tables import RobotFile
from services.robotfile.wiring import joint_limits_deg
from services.streams import JOINT_STATE, ROBOT_CALL, ROBOT_STATUS

MOVES = 16
MOST_MOVES = 200
SLOW_DEG_S = 12.0  # so that accelerations weigh less than the sensor's noise
LEAST_MOVE_S = 2.0
MARGIN_DEG = 3.0  # from every limit, beyond the HAL's own margin
PATIENCE_S = 15.0


def sweep_limb(client: DynamicsClient, sensor: str, moves: int, degrees: float) -> None:
    """Go through the postures and back to the first.

    Raises:
        ServiceError: the sensor or its limb's joints are not there, or a move is refused or fails.
    """
    if not 1 <= moves <= MOST_MOVES or not 0.0 < degrees <= 90.0:
        raise ServiceError(f"moves must be 1..{MOST_MOVES} and degrees up to 90")
    robot = client.robot
    if sensor not in robot.sensors:
        known = ", ".join(robot.sensors)
        raise ServiceError(f"no sensor {sensor!r} here; there is {known}")
    part = robot.boards[robot.sensors[sensor].board].part
    joints = [j for j in robot.parts[part] if robot.joints[j].mechanism == "body"]
    state = client.wait_for(JOINT_STATE[part])
    now_rad = dict(zip(robot.parts[part], state.q_rad, strict=True))
    start = {joint: math.degrees(now_rad[joint]) for joint in joints}
    last = start
    postures = [posture(robot, start, degrees, number) for number in range(1, moves + 1)]
    for number, target in enumerate([*postures, start], start=1):
        print(f"posture {number} of {moves + 1}", flush=True)
        _move(client, last, target)
        last = target


def posture(
    robot: RobotFile, about_deg: Mapping[str, float], degrees: float, number: int
) -> dict[str, float]:
    """The posture of that number, about another one, inside all limits: each joint by its own step.

    Steps are multiples of irrational numbers: no two joints move together for long.
    """
    target = {}
    for i, (joint, middle) in enumerate(about_deg.items()):
        low, high = joint_limits_deg(robot, joint)
        margin = robot.joints[joint].limit_margin_deg + MARGIN_DEG
        share = math.sin(2.0 * math.pi * number * math.sqrt(i + 2.0) % (2.0 * math.pi))
        wanted = middle + degrees * share
        target[joint] = min(max(wanted, low + margin), high - margin)
    return target


def _move(client: DynamicsClient, last: Mapping[str, float], target: Mapping[str, float]) -> None:
    longest_deg = max(abs(target[joint] - last[joint]) for joint in target)
    duration_s = max(LEAST_MOVE_S, longest_deg / SLOW_DEG_S)
    request = RobotRequest(
        action="move",
        joints=tuple(target),
        q_rad=tuple(math.radians(angle) for angle in target.values()),
        duration_s=duration_s,
    )
    reply = client.call(ROBOT_CALL, request)
    if not reply.ok:
        raise ServiceError(f"the limb cannot be moved: {reply.reason}{advice(request, reply)}")
    end_ns = client.clock.now_ns() + round((duration_s + PATIENCE_S) * NS_PER_S)
    while True:
        status = client.wait_for(ROBOT_STATUS)
        failed = dict(status.failed_tasks).get(reply.task)
        if failed is not None:
            raise ServiceError(f"the limb cannot be moved: {failed}")
        if status.finished_task >= reply.task:
            return
        if client.clock.now_ns() >= end_ns:
            raise ServiceError(f"the limb does not arrive within {duration_s + PATIENCE_S:.0f} s")
