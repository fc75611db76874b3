"""What the hand is asked to do: the pose pair and the lemniscate of the 2010 experiments.

Poses of the right hand in the root frame, from the public material of those experiments
(pattacini/iros2010: conf/P2P.txt; conf/lemniscate.txt with conf/txLemniscate.ini). A course holds,
for every control period, the pose that inverse kinematics finds next to the one asked for and the
posture that takes the hand there: controllers are given this pose, and are judged by it.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from dforc.arrays import Matrix, Vector
from dforc.rotation import matrix, rotation_error
from services.experiments.cartesian.arm import Arm, Pose, Reached

PERIOD_S = 0.01
DWELL_S = 9.0  # from one goal of the pair to the next
PAIR_TIME_S = 2.5  # T between the pair: no joint needs more than the speed the HAL lets it have
LOOP_S = 30.0  # of the lemniscate: 23 mm/s
CURVE_TIME_S = 0.6
CENTRE_M = np.array([-0.25, 0.15, 0.09])
GAIN_M = 0.13
FINE = 20000  # points of the curve from which equal steps are taken


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class Course:
    """Targets of a run, one per control period."""

    name: str
    trajectory_time_s: float  # T, of the controllers that are told one
    q_start_rad: Vector  # (n,) where it begins at rest
    position_m: Matrix  # (k, 3)
    rotation: Matrix  # (k, 3, 3)
    q_rad: Matrix  # (k, n)
    velocity_m_s: Matrix  # (k, 3)
    angular_velocity_rad_s: Matrix  # (k, 3)
    moves: tuple[int, ...]  # periods at which the target jumps; empty for a curve
    given_up_m: float  # farthest that a pose of it is from the one asked for
    given_up_rad: float

    @property
    def periods(self) -> int:
        """How many control periods it takes."""
        return len(self.q_rad)


def axis_angle(x: float, y: float, z: float, angle_rad: float) -> Matrix:
    """Rotation (3, 3) about an axis of (nearly) unit length."""
    axis = np.array([x, y, z])
    return matrix(axis / np.linalg.norm(axis) * angle_rad)


PAIR = (
    Pose(np.array([-0.232, 0.258, 0.021]), axis_angle(-0.1477, -0.7912, 0.5933, 3.0637)),
    Pose(np.array([-0.264, 0.032, 0.034]), axis_angle(-0.112, 0.9935, 0.01514, 3.1355)),
)
FACING = axis_angle(0.0, -1.0, 1.0, np.pi)  # orientation along the lemniscate


def point_to_point(arm: Arm, moves: int, dwell_s: float = DWELL_S) -> Course:
    """From the second pose of the pair to the first, back, and so on."""
    far = arm.reached(PAIR[0], arm.rest_rad)
    near = arm.reached(PAIR[1], far.q_rad)
    goals = [near, *(far if move % 2 == 0 else near for move in range(moves))]
    return to_goals("point to point", goals, PAIR_TIME_S, dwell_s)


def to_goals(
    name: str, goals: Sequence[Reached], trajectory_time_s: float, dwell_s: float
) -> Course:
    """From the first pose to the second, the third, and so on; the target jumps."""
    each, moves = round(dwell_s / PERIOD_S), len(goals) - 1
    zero = np.zeros((moves * each, 3))
    return Course(
        name=name,
        trajectory_time_s=trajectory_time_s,
        q_start_rad=goals[0].q_rad,
        position_m=np.repeat([goal.pose.position_m for goal in goals[1:]], each, axis=0),
        rotation=np.repeat([goal.pose.rotation for goal in goals[1:]], each, axis=0),
        q_rad=np.repeat([goal.q_rad for goal in goals[1:]], each, axis=0),
        velocity_m_s=zero,
        angular_velocity_rad_s=zero,
        moves=tuple(range(0, moves * each, each)),
        given_up_m=max(goal.off_m for goal in goals),
        given_up_rad=max(goal.off_rad for goal in goals),
    )


def lemniscate(arm: Arm, loops: int = 1, loop_s: float = LOOP_S) -> Course:
    """Round Bernoulli's curve at constant speed, the hand facing one way."""
    each = round(loop_s / PERIOD_S)
    curve = lemniscate_points(each)
    found = arm.followed([Pose(point, FACING) for point in np.vstack([curve[-2:], curve])])[2:]
    position = np.array([goal.pose.position_m for goal in found])
    rotation = np.array([goal.pose.rotation for goal in found])
    turned = [rotation_error(rotation[k - 1], rotation[k]) / PERIOD_S for k in range(each)]
    return Course(
        name="lemniscate",
        trajectory_time_s=CURVE_TIME_S,
        q_start_rad=found[0].q_rad,
        position_m=np.tile(position, (loops, 1)),
        rotation=np.tile(rotation, (loops, 1, 1)),
        q_rad=np.tile([goal.q_rad for goal in found], (loops, 1)),
        velocity_m_s=np.tile((np.roll(curve, -1, axis=0) - curve) / PERIOD_S, (loops, 1)),
        angular_velocity_rad_s=np.tile(turned, (loops, 1)),
        moves=(),
        given_up_m=max(goal.off_m for goal in found),
        given_up_rad=max(goal.off_rad for goal in found),
    )


def lemniscate_points(count: int) -> Matrix:
    """Points (count, 3) at equal distances along the closed curve, from its middle on.

    In the y-z plane: r^2 = cos(2 angle), each lobe from -45 to 45 degrees.
    """
    angle = np.linspace(-0.25 * np.pi, 0.25 * np.pi, FINE)
    radius = np.sqrt(np.maximum(np.cos(2.0 * angle), 0.0))
    lobe = np.column_stack([np.zeros(FINE), radius * np.cos(angle), radius * np.sin(angle)])
    mirrored = lobe * [1.0, -1.0, 1.0]
    whole = np.vstack([lobe, mirrored[1:]])
    gone = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(whole, axis=0), axis=1))])
    wanted = np.arange(count) / count * gone[-1]
    points = np.column_stack([np.interp(wanted, gone, whole[:, i]) for i in range(3)])
    curve: Matrix = CENTRE_M + GAIN_M * points
    return curve
