"""The stream of virtual points and their postures, as a target of the controller.

A point waits for its solution. What is not finite, has no point or comes out of order is refused
and counted, and the last target holds; without good solutions the target is gone after a while, and
the plan stops. While a request commands, points are ignored and counted until they have paused.
"""

import math

import numpy as np

from dforc.cartesian.targets import PoseTarget, ReachTarget
from dforc.ik.problem import Tip, TipTarget
from services.core.service import Inputs
from services.messages import IkSolution, Vector3, VirtualPoint
from services.reaching.ik_targets import point_targets
from services.reaching.tip_poses import reached_poses
from services.streams import IK_SOLUTION, VIRTUAL_POINT

POINTS_KEPT = 32
SOLUTION_AGE_NS = 100_000_000  # ten periods without a good solution: stop and hold
PAUSE_NS = 100_000_000  # of the points, after which a new stream begins
AT_REST_M_S = 0.005


class PointFollowing:
    """What the stream wants."""

    def __init__(self) -> None:
        self.refused = 0
        self.ignored = 0
        self.solution: IkSolution | None = None
        self.followed: VirtualPoint | None = None
        self.target: ReachTarget | None = None  # of the newest good solution
        self._points: dict[int, VirtualPoint] = {}  # that wait for their solution
        self._sequence = -1
        self._solved_ns = 0
        self._heard_ns = -PAUSE_NS
        self._barred = False

    def bar(self, now_ns: int) -> None:
        """A request commands: points do nothing until they have paused."""
        self._barred = now_ns - self._heard_ns < PAUSE_NS
        self.target = None

    def new_points(self, now_ns: int, inputs: Inputs) -> VirtualPoint | None:
        """Take in new points; the newest of them, unless they are to be ignored."""
        points = inputs.all_new(VIRTUAL_POINT)
        if not points:
            return None
        if self._barred and now_ns - self._heard_ns >= PAUSE_NS:
            self._barred = False
        self._heard_ns = now_ns
        if self._barred:
            self.ignored += len(points)
            return None
        for point in points:
            self._points[point.sequence] = point
        while len(self._points) > POINTS_KEPT:
            del self._points[next(iter(self._points))]
        return points[-1]

    def take_solution(self, now_ns: int, inputs: Inputs, tips: tuple[Tip, ...], limb: str) -> None:
        """A new solution for the limb becomes the target."""
        solution = inputs.new(IK_SOLUTION)
        if solution is None or self._barred:
            return
        point = self._points.get(solution.sequence)
        if (
            point is None
            or solution.limb not in ("", limb)
            or not _is_good(solution, point, tips)
            or solution.sequence <= self._sequence < solution.sequence + POINTS_KEPT
        ):
            self.refused += 1
            return
        self._sequence = solution.sequence
        self._solved_ns = now_ns
        self.solution = solution
        self.followed = point
        self.target = _target(solution, point, tips)

    def is_silent(self, now_ns: int) -> bool:
        """Whether good solutions have stayed away for too long."""
        return now_ns - self._solved_ns > SOLUTION_AGE_NS

    @property
    def is_at_rest(self) -> bool:
        """Whether the point that is followed stands."""
        point = self.followed
        return point is not None and math.hypot(*point.velocity_m_s) < AT_REST_M_S


def _is_good(solution: IkSolution, point: VirtualPoint, tips: tuple[Tip, ...]) -> bool:
    numbers = (*solution.q_rad, *point.position_m, *point.velocity_m_s, *point.rotation_rad)
    numbers += (*(point.second_position_m or ()), *(point.second_rotation_rad or ()))
    # A sum of squares is finite only if every term is, and no term is beyond squaring.
    squares = sum(x * x for x in (*numbers, *point.second_velocity_m_s))
    return len(solution.q_rad) == tips[0].n and math.isfinite(squares)


def _target(solution: IkSolution, point: VirtualPoint, tips: tuple[Tip, ...]) -> ReachTarget:
    """Of a point out of reach, the nearest posture is the target, not the point beyond it."""
    q = np.array(solution.q_rad)
    asked = point_targets(point, len(tips))
    poses = reached_poses(tips, asked, q)
    if solution.status == "converged":
        velocities = (point.velocity_m_s, point.second_velocity_m_s)[: len(tips)]
        triples = zip(poses, asked, velocities, strict=True)
        poses = tuple(_as_asked(*triple) for triple in triples)
    return ReachTarget(tips=poses, q_rad=q)


def _as_asked(
    pose: PoseTarget | None, asked: TipTarget | None, velocity_m_s: Vector3
) -> PoseTarget | None:
    if pose is None or asked is None:
        return None
    return PoseTarget(
        position_m=pose.position_m if asked.position_m is None else asked.position_m,
        rotation=asked.rotation,
        velocity_m_s=velocity_m_s,
    )
