"""A limb as the Cartesian controller uses it: joints by part, tips, and what goes together."""

import math
from collections.abc import Iterable
from dataclasses import dataclass

from dforc.ik.problem import IkProblem
from services.reaching.limb import find_limb, limb_joints, limb_problem
from services.robotfile.robot_tables import RobotFile

SPEED_SHARE = 0.9  # of the HAL's own limit; where that clamps, a joint trails and bends the path
TIED = 3  # joints of one row: fewer can still keep it when one of them is blocked


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class LimbShape:
    """What of a limb never changes."""

    name: str
    parts: dict[str, tuple[str, ...]]  # part and its joints, base to tip
    joints: tuple[str, ...]  # the order of every vector
    tips: tuple[str, ...]
    sensors: tuple[str, ...]  # FT sensors on the way to the tips
    problem: IkProblem  # as the robot file has it
    together: tuple[tuple[str, ...], ...]  # joints that may only be freed and blocked together
    following_s: float  # trajectory time where a stream of points is followed
    speed_limits_rad_s: tuple[float, ...]  # of the plan: within what the HAL lets the joints have

    @property
    def n(self) -> int:
        """Joints."""
        return len(self.joints)


def limb_shape(robot: RobotFile, name: str) -> LimbShape:
    """Build the model of a limb.

    Raises:
        ConfigError: there is no such limb among the parts in use.
    """
    limb = find_limb(robot, name)
    joints = limb_joints(robot, name)
    rows = [tuple(row.coefficients) for row in robot.rows if len(row.coefficients) >= TIED]
    return LimbShape(
        name=limb.name,
        parts={part: robot.parts[part] for part in limb.parts},
        joints=joints,
        tips=tuple(tip.limb for tip in limb.tips),
        sensors=tuple(tip.sensor for tip in limb.tips),
        problem=limb_problem(robot, name),
        together=joined_groups(row for row in rows if set(row) <= set(joints)),
        following_s=limb.trajectory_time_s,
        speed_limits_rad_s=tuple(
            math.radians(SPEED_SHARE * robot.joints[joint].max_velocity_deg_s) for joint in joints
        ),
    )


def joined_groups(rows: Iterable[tuple[str, ...]]) -> tuple[tuple[str, ...], ...]:
    """Rows that share a joint become one group."""
    groups: list[dict[str, None]] = []
    for row in rows:
        group = dict.fromkeys(row)
        for other in [other for other in groups if other.keys() & group.keys()]:
            groups.remove(other)
            group = other | group
        groups.append(group)
    return tuple(tuple(group) for group in groups)
