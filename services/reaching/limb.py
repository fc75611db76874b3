"""The limbs, as the numerics want them: models, limits and rows, the problem of inverse kinematics.

A limb goes by its name in the robot file, or is the main job's where none is given. Its vectors
hold the joints of its parts, base to tip.
"""

import numpy as np

from dforc.ik.problem import IkProblem, Tip
from dforc.limits import JointLimits
from dforc.robot_model import RobotModel
from services.core.errors import ConfigError
from services.messages import Floats, JointState
from services.robotfile.limbs import Limb
from services.robotfile.model_file import urdf_path
from services.robotfile.robot_tables import RobotFile
from services.robotfile.wiring import chain_limits_rad, chain_rows_rad

PLANNER_MARGIN_DEG = 0.5  # beyond the HAL's own margin, so that a plan is never clamped


def find_limb(robot: RobotFile, limb: str = "") -> Limb:
    """A limb by its name; without one the main job's, or the first where that is not in use.

    Raises:
        ConfigError: there is no such limb among the parts in use; those there are, are listed.
    """
    limbs = robot.limbs
    if not limb:
        limb = next((n for n in (robot.main_job.limb, *limbs) if n in limbs), "")
    if limb not in limbs:
        known = ", ".join(limbs) or "none"
        raise ConfigError(f"unknown limb {limb!r}; among the parts in use: {known}")
    return limbs[limb]


def limb_joints(robot: RobotFile, limb: str = "") -> tuple[str, ...]:
    """Joints of a limb: the order of all its vectors."""
    return tuple(joint for part in find_limb(robot, limb).parts for joint in robot.parts[part])


def limb_models(robot: RobotFile, limb: str = "") -> tuple[RobotModel, ...]:
    """A model for each tip, over all joints of the limb, with the FT sensor on the way to the tip.

    Every process makes its own.
    """
    urdf, joints = str(urdf_path(robot.robot.urdf)), limb_joints(robot, limb)
    return tuple(
        RobotModel(urdf, joints, tip.frame, {tip.sensor: robot.sensors[tip.sensor].frame})
        for tip in find_limb(robot, limb).tips
    )


def limb_model(robot: RobotFile, limb: str = "") -> RobotModel:
    """Model of a limb's first tip."""
    return limb_models(robot, limb)[0]


def limb_limits(robot: RobotFile, limb: str = "") -> JointLimits:
    """Limits and rows of a limb as planners keep them: inside the HAL's set-point limits."""
    joints = limb_joints(robot, limb)
    lower, upper = chain_limits_rad(robot, joints)
    margin = np.radians([robot.joints[name].limit_margin_deg for name in joints])
    margin += np.radians(PLANNER_MARGIN_DEG)
    matrix, row_lower, row_upper = chain_rows_rad(robot, joints)
    row_margin = np.abs(matrix) @ margin / np.abs(matrix).sum(axis=1)
    return JointLimits.make(
        lower + margin, upper - margin, matrix, row_lower + row_margin, row_upper - row_margin
    )


def limb_problem(robot: RobotFile, limb: str = "") -> IkProblem:
    """Inverse kinematics of a limb as the robot file has it: every joint free, eq. 1 of DForC."""
    chosen = find_limb(robot, limb)
    tips = zip(chosen.tips, limb_models(robot, limb), strict=True)
    return IkProblem.make(
        tips=[Tip(tip.limb, model) for tip, model in tips],
        limits=limb_limits(robot, limb),
        rest_rad=np.radians(chosen.rest_deg),
        rest_weights=np.array(chosen.rest_weights),
    ).changed(beta=chosen.rest_beta)


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


def split(robot: RobotFile, values: Floats, limb: str = "") -> dict[str, Floats]:
    """A limb's vector by part."""
    parts = {}
    start = 0
    for part in find_limb(robot, limb).parts:
        end = start + len(robot.parts[part])
        parts[part] = values[start:end]
        start = end
    return parts
