"""The limb that reaches, as the numerics want it.

Model, limits and rows of the robot file's chain.
"""

import numpy as np

from dforc.limits import JointLimits
from dforc.robot_model import RobotModel
from services.messages import Floats, JointState
from services.robot_tables import RobotFile
from services.wiring import chain_limits_rad, chain_rows_rad, urdf_path

LIMIT_MARGIN_RAD = np.radians(
    1.0
)  # kept by every planner, so that control errors do not pass a limit


def limb_model(robot: RobotFile) -> RobotModel:
    """Model of the chain, with the limb's FT sensor. Every process makes its own."""
    sensor = robot.reach.sensor
    return RobotModel(
        str(urdf_path(robot.robot.urdf)),
        robot.chain,
        robot.reach.tip_frame,
        {sensor: robot.sensors[sensor].frame},
    )


def limb_limits(robot: RobotFile, margin_rad: float = LIMIT_MARGIN_RAD) -> JointLimits:
    """Limits and rows of the chain, drawn in by a margin."""
    lower, upper = chain_limits_rad(robot)
    matrix, row_lower, row_upper = chain_rows_rad(robot)
    return JointLimits.make(
        lower + margin_rad,
        upper - margin_rad,
        matrix,
        row_lower + margin_rad,
        row_upper - margin_rad,
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
