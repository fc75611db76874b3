"""The limb that reaches, as the numerics want it.

Model, limits and rows of the robot file's chain.
"""

import numpy as np

from dforc.limits import JointLimits
from dforc.robot_model import RobotModel
from services.messages import Floats, JointState
from services.robotfile.model_file import urdf_path
from services.robotfile.robot_tables import RobotFile
from services.robotfile.wiring import chain_limits_rad, chain_rows_rad

PLANNER_MARGIN_DEG = 0.5  # beyond the HAL's own margin, so that a plan is never clamped


def limb_model(robot: RobotFile) -> RobotModel:
    """Model of the chain, with the limb's FT sensor. Every process makes its own."""
    sensor = robot.reach.sensor
    return RobotModel(
        str(urdf_path(robot.robot.urdf)),
        robot.chain,
        robot.reach.tip_frame,
        {sensor: robot.sensors[sensor].frame},
    )


def limb_limits(robot: RobotFile) -> JointLimits:
    """Limits and rows of the chain as planners keep them: inside the HAL's set-point limits."""
    lower, upper = chain_limits_rad(robot)
    margin = np.radians(
        [robot.joints[name].limit_margin_deg + PLANNER_MARGIN_DEG for name in robot.chain]
    )
    matrix, row_lower, row_upper = chain_rows_rad(robot)
    row_margin = np.abs(matrix) @ margin / np.abs(matrix).sum(axis=1)
    return JointLimits.make(
        lower + margin, upper - margin, matrix, row_lower + row_margin, row_upper - row_margin
    )


def joined(states: tuple[JointState | None, ...]) -> tuple[Floats, Floats] | None:
    """Angles and speeds of the whole chain from its parts' states.

    None unless every part's is valid.
    """
    q: list[float] = []
    dq: list[float] = []
    for state in states:
        if state is None or not state.valid:
            return None
        q.extend(state.q_rad)
        dq.extend(state.dq_rad_s)
    return tuple(q), tuple(dq)


def split(robot: RobotFile, values: Floats) -> dict[str, Floats]:
    """A chain vector by part."""
    parts = {}
    start = 0
    for part in robot.reach.parts:
        end = start + len(robot.parts[part])
        parts[part] = values[start:end]
        start = end
    return parts
