"""Joint states and virtual points that several tests start from."""

import numpy as np
from numpy.typing import NDArray

from dforc import rotation
from services.messages import JointState, VirtualPoint
from services.reaching.limb import limb_model
from services.robotfile.robot_tables import RobotFile

POSITION_DIRECT = 0x08


def part_state(q_rad: NDArray[np.float64]) -> JointState:
    """A part at rest, valid, in position-direct mode."""
    count = len(q_rad)
    return JointState(
        stamp_ns=0,
        q_rad=tuple(q_rad.tolist()),
        dq_rad_s=(0.0,) * count,
        tau_nm=(0.0,) * count,
        control_mode=(POSITION_DIRECT,) * count,
        compliant=(False,) * count,
        valid=True,
    )


def posture(robot: RobotFile, q_rad: NDArray[np.float64]) -> dict[str, JointState]:
    """States of all parts of the main job's limb."""
    states, start = {}, 0
    for part in robot.reach.parts:
        count = len(robot.parts[part])
        states[part] = part_state(q_rad[start : start + count])
        start += count
    return states


def arms_at(
    robot: RobotFile, torso_deg: tuple[float, float, float] = (0.0, 0.0, 0.0)
) -> dict[str, JointState]:
    """States of torso and arms as far as they are in use: the arms at home."""
    arm = part_state(np.radians(robot.reach.home_deg[3:]))
    states = {"torso": part_state(np.radians(torso_deg)), "left_arm": arm, "right_arm": arm}
    return {part: state for part, state in states.items() if part in robot.parts}


def point(
    robot: RobotFile, offset_m: tuple[float, float, float], sequence: int = 1
) -> VirtualPoint:
    """A point at a distance from the hand at home, with the hand's orientation there."""
    turned, position = limb_model(robot).tip_pose(np.radians(robot.reach.home_deg))
    x, y, z = (position + np.array(offset_m)).tolist()
    a, b, c = rotation.rotation_vector(turned).tolist()
    return VirtualPoint(
        stamp_ns=0,
        sequence=sequence,
        position_m=(x, y, z),
        velocity_m_s=(0.0, 0.0, 0.0),
        rotation_rad=(a, b, c),
    )
