"""The better field for a bare point: reaches wherever there is a way, and touches nothing.

Far from obstacles it is the paper's spring and damper (eq. 3) in the target's frame, so it does not
lag behind a target whose velocity is known. Around obstacles it follows the shortest way that keeps
a clearance (dforc.field.guide), so it has no traps; a barrier on acceleration and velocity, in each
obstacle's own frame, keeps it off all of them. A goal that is enclosed is said to be unreachable,
and the point waits; when the cage opens it goes on.

Every step costs a bounded number of cells of the search. Until that has found a way the last
velocity is held, as far as the barrier lets it.
"""

import math
from dataclasses import dataclass
from enum import StrEnum

import numpy as np

from dforc.arrays import ArrayLike, Vector, finite_vector
from dforc.collision.obstacles import World
from dforc.errors import DforcError, NotFiniteError
from dforc.field import point_kernel as kernel
from dforc.field.barrier_kernel import new_barrier
from dforc.field.course_kernel import LEVEL, MARGIN, MARKS, USED, Course
from dforc.field.guide import MOST_NODES, MOST_PLACES, new_search
from dforc.field.guide_kernel import IDLE, STATE

FIRST_ROOM = 16  # obstacles; more make it grow

# Margin of the barrier as a share of the law's, cell of the grid, and how far that goes beyond the
# point and the goal [m]. Sight and clearance are shares of the margin.
# Sight is what lines of the way keep, more than the margin so that the barrier does not push the
# point off them; clearance is what the nodes keep, so that they see each other past a corner.
LEVELS = ((1.0, 0.02, 0.6), (0.5, 0.01, 0.3), (0.0, 0.0075, 0.2))
SIGHT_SHARE, CLEARANCE_SHARE = 1.2, 1.5


class PointError(DforcError, ValueError):
    """Constants or a period that make no field."""


class PointStatus(StrEnum):
    """What the point is doing; the order is that of dforc.field.point_kernel."""

    REACHING = "reaching"
    SEARCHING = "searching a way"
    UNREACHABLE = "unreachable"
    NEAREST = "goal inside an obstacle: nearest safe place"
    LEAVING = "inside an obstacle: leaving"
    ARRIVED = "arrived"


STATUSES = tuple(PointStatus)


@dataclass(frozen=True, slots=True, kw_only=True)
class PointParams:
    """Constants of the field."""

    stiffness_n_m: float = 9.0  # K
    damping_ns_m: float = 6.0  # D; K / D is the rate of approach, 1.5 1/s
    margin_m: float = 0.01  # that is kept from obstacles wherever there is room
    tightest_m: float = 0.003  # and that is always kept, where a way or a goal is narrow
    speed_m_s: float = 0.3  # towards a goal
    escape_m_s: float = 0.6  # before an obstacle that comes
    acceleration_m_s2: float = 3.0
    hard_acceleration_m_s2: float = 15.0  # before an obstacle
    jerk_m_s3: float = 20.0
    smoothing_s: float = 0.06
    arrived_m: float = 0.002
    cells: int = 100  # of the search per step among few obstacles: about 0.7 ms

    def __post_init__(self) -> None:
        """Refuse constants that are no positive numbers."""
        for name in self.__slots__:
            value = getattr(self, name)
            if not (math.isfinite(value) and value > 0.0):
                raise PointError(f"{name} must be a positive number, not {value}")
        if self.tightest_m > self.margin_m:
            raise PointError(f"tightest_m {self.tightest_m} is more than margin_m {self.margin_m}")


@dataclass(frozen=True, slots=True, kw_only=True)
class PointOutput:
    """The point after a step."""

    position_m: Vector
    velocity_m_s: Vector
    status: PointStatus
    aim_m: Vector  # the goal, or the nearest safe place if that is in an obstacle
    clearance_m: float  # from the nearest obstacle's margin, before the step; inf if there is none
    way_m: float  # to the aim; inf if none is known


def law_of(params: PointParams) -> kernel.Law:
    """The constants as the compiled step wants them."""
    return kernel.Law(
        stiffness=params.stiffness_n_m,
        damping=params.damping_ns_m,
        speed=params.speed_m_s,
        escape=params.escape_m_s,
        acceleration=params.acceleration_m_s2,
        hard_acceleration=params.hard_acceleration_m_s2,
        jerk=params.jerk_m_s3,
        wanted_s=params.smoothing_s,
        given_s=0.5 * params.smoothing_s,
        tightest=params.tightest_m,
        arrived=params.arrived_m,
        cells=params.cells,
    )


def new_point(params: PointParams, most: int, most_nodes: int = MOST_NODES) -> kernel.Point:
    """Room for a point among so many obstacles."""
    levels = np.zeros((len(LEVELS), 5))
    for level, (share, cell, beyond) in zip(levels, LEVELS, strict=True):
        margin = max(share * params.margin_m, params.tightest_m)
        level[:] = margin, SIGHT_SHARE * margin, CLEARANCE_SHARE * margin, cell, beyond
    room = 2 * most
    course = Course(
        search=new_search(most_nodes),
        back=new_search(most_nodes),
        path=np.zeros((MOST_PLACES, 4)),
        marks=np.zeros(MARKS, dtype=np.int64),
        goal=np.full(3, np.inf),
        basis=World(
            kinds=np.zeros(room, dtype=np.int64),
            sizes=np.zeros((room, 3)),
            rotations=np.zeros((room, 9)),
            centres=np.zeros((room, 3)),
            velocities=np.zeros((room, 3)),
            margins=np.zeros(room),
            reaches=np.zeros(room),
        ),
        levels=levels,
    )
    return kernel.Point(
        x=np.zeros(3),
        v=np.zeros(3),
        wanted=np.zeros(3),
        given=np.zeros(3),
        nominal=np.zeros(3),
        aim=np.zeros(3),
        way_out=np.zeros(3),
        figures=np.full(2, np.inf),
        status=np.zeros(1, dtype=np.int64),
        course=course,
        barrier=new_barrier(most),
    )


def put(point: kernel.Point, position_m: Vector, velocity_m_s: Vector) -> None:
    """Put a point somewhere; it knows no way yet."""
    for values in (point.wanted, point.given, point.way_out):
        values[:] = 0.0
    point.x[:], point.v[:], point.nominal[:] = position_m, velocity_m_s, velocity_m_s
    point.aim[:] = position_m
    point.course.marks[:] = 0
    point.course.goal[:] = np.inf
    point.course.search.counts[STATE] = IDLE


class PointField:
    """A point that is drawn to a goal among obstacles, one step at a time."""

    def __init__(self, params: PointParams | None = None, most_nodes: int = MOST_NODES) -> None:
        self.params = params or PointParams()
        self._law = law_of(self.params)
        self._most_nodes = most_nodes
        self._point = new_point(self.params, FIRST_ROOM, most_nodes)

    def begin(self, position_m: ArrayLike, velocity_m_s: ArrayLike = (0.0, 0.0, 0.0)) -> None:
        """Put the point somewhere.

        Raises:
            NotFiniteError, ShapeError: of what is given; the point stays where it is.
        """
        position = finite_vector("position_m", position_m, 3)
        put(self._point, position, finite_vector("velocity_m_s", velocity_m_s, 3))

    def step(
        self,
        goal_m: ArrayLike,
        world: World,
        dt_s: float,
        goal_velocity_m_s: ArrayLike = (0.0, 0.0, 0.0),
    ) -> PointOutput:
        """Move by one period towards a goal that moves with some velocity.

        Raises:
            NotFiniteError, ShapeError: of what is given; the point stays where it is.
            PointError: a period that is not positive.
        """
        goal = finite_vector("goal_m", goal_m, 3)
        velocity = finite_vector("goal_velocity_m_s", goal_velocity_m_s, 3)
        if not 0.0 < dt_s < math.inf:
            raise PointError(f"period must be positive, not {dt_s} s")
        if not all(np.isfinite(values).all() for values in world):
            raise NotFiniteError("an obstacle is not finite")
        self._make_room(len(world.kinds))
        status = kernel.step(self._point, goal, velocity, world, self._law, dt_s)
        point = self._point
        return PointOutput(
            position_m=point.x.copy(),
            velocity_m_s=point.v.copy(),
            status=STATUSES[status],
            aim_m=point.aim.copy(),
            clearance_m=float(point.figures[0]),
            way_m=float(point.figures[1]),
        )

    @property
    def margin_m(self) -> float:
        """What the way that is followed keeps from obstacles."""
        course = self._point.course
        return float(course.levels[course.marks[LEVEL], MARGIN])

    @property
    def way_m(self) -> Vector:
        """Places (p, 3) of the way that is followed, the goal last."""
        course = self._point.course
        return course.path[: course.marks[USED], :3].copy()

    def _make_room(self, count: int) -> None:
        if count <= len(self._point.barrier.distances):
            return
        old = self._point
        self._point = new_point(self.params, 2 * count, self._most_nodes)
        put(self._point, old.x, old.v)
        self._point.wanted[:], self._point.given[:] = old.wanted, old.given
