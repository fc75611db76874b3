"""How the virtual arm gets to a goal: straight as long as that leads on, else by a planned path.

Each attempt has a margin from obstacles. It looks for postures that have the hand at the goal and
keep the margin; when the arm is stuck it plans a path to one of them. An attempt that fails is
followed by one with half the margin, down to the least; then the goal counts as out of reach, and
after a while all begins again: obstacles may have moved. The arm itself keeps the whole margin
until there is a path that needs less, and keeps it again once the goal has gone on into the open.
"""

import math
from collections.abc import Sequence
from enum import Enum, auto

from dforc.arrays import Vector
from dforc.collision.body import Body
from dforc.limits import JointLimits
from dforc.poses import is_beyond
from dforc.virtual_arm.goal_postures import GoalSearch
from dforc.virtual_arm.goals import ArmState
from dforc.virtual_arm.motion import Indices
from dforc.virtual_arm.params import ArmParams
from dforc.virtual_arm.planner import PlanState, PosturePlanner
from dforc.virtual_arm.progress import Progress
from dforc.virtual_arm.situation import Goals, Situation
from dforc.virtual_arm.way import Way

MOVED_M, TURNED_RAD = 0.03, math.radians(15.0)  # a goal that has moved more: other postures
JUMPED_M, JUMPED_RAD = 0.10, math.radians(45.0)  # between two steps: another goal
LOOK_EVERY = 10  # steps, along the path
LOOKS = 150  # postures, then
ALONG_SHARE = 0.5  # of the margin, that has to be left along a path that is followed
PLANNED_BESIDE_M = 0.002  # a path keeps so much more than the margin, so that it can be followed
STAYS_SHARE = 2.0  # of the tolerances that an arm keeps which has arrived
LEAST_TRIES = 40  # searches of a posture at a margin that may be lowered yet


class Gait(Enum):
    """What the arm does in this step."""

    REACH = auto()  # hands go straight
    STAND = auto()
    FOLLOW = auto()  # the posture goes along a path


class Pursuit:
    """The attempts at one goal after another."""

    def __init__(
        self,
        body: Body,
        columns: Indices,
        limits: JointLimits,
        tips: tuple[int, ...],
        rest_rad: Vector,
        speeds: Vector,
        params: ArmParams,
        seed: int,
    ) -> None:
        """Build search and planner."""
        self._params = params
        self._speeds = speeds
        self._seed = seed
        self._search = GoalSearch(body, columns, limits, tips, rest_rad, seed)
        self._planner = PosturePlanner(body, columns, limits, seed)
        self.progress = Progress(params.stuck_s)
        self.margin_m = self._level_m = params.margin_m
        self._tries = self._found = self._planned = self._attempts = 0
        self.drop()

    def drop(self) -> None:
        """No goal any more. The margin stays: nothing moves for it."""
        self.gait = Gait.STAND
        self.state = ArmState.IDLE
        self.reason = ""
        self.way: Way | None = None
        self.posture: Vector | None = None  # that has the hands at the goal
        self.iterations = 0
        self._goals: Goals | None = None  # of the step before
        self._led_to: Goals | None = None  # by the path
        self._searched: Goals | None = None  # that postures are looked for
        self._searching = False
        self._planning = False
        self._retry_s = 0.0
        self._steps = 0
        self.progress.restart()

    def new_goal(self) -> None:
        """Whatever goals come next are taken up afresh."""
        self._goals = None

    def change(self, params: ArmParams, speeds: Vector) -> None:
        """Other constants."""
        if params.margin_m != self._params.margin_m:
            self.margin_m = self._level_m = params.margin_m
        self._params, self._speeds = params, speeds

    @property
    def nodes(self) -> int:
        """Of the planner's trees."""
        return self._planner.nodes if self._planning else 0

    def advance(
        self,
        now: Situation,
        errors: Sequence[tuple[float, float]],
        period_s: float,
    ) -> None:
        """Decide what this step does; `errors` (m, rad) are of the hands that have a goal."""
        self.iterations = 0
        self._take_goals(now)
        if self._searching:
            self._go_on_searching()
        self._leave_an_old_way(now)
        if self._planning:
            self._go_on_planning(now)
            return
        if self.gait is Gait.FOLLOW:
            self._look_along_the_way(now)
        if self._is_there(errors, now):
            self.state = ArmState.ARRIVED
            if self.gait is not Gait.REACH:
                self.gait, self.way = Gait.REACH, None
                self.progress.restart()
            return
        stood = self.state in (ArmState.UNREACHABLE, ArmState.PLANNING)
        if self.state is ArmState.ARRIVED or (stood and self.progress.is_advancing):
            self.state, self.reason = ArmState.REACHING, ""
        if self._retry_s > 0.0:
            self._retry_s -= period_s
        elif self.progress.is_stuck or self.gait is Gait.STAND:
            self._find_a_way(now)

    def _take_goals(self, now: Situation) -> None:
        """Another goal, or one that has moved on."""
        if self._goals is None or is_beyond(self._goals, now.goals, JUMPED_M, JUMPED_RAD):
            self._take_up(now)
        elif self._searched and is_beyond(self._searched, now.goals, MOVED_M, TURNED_RAD):
            if now.left_m >= self._params.margin_m - self.margin_m:  # out in the open again
                self.margin_m = self._params.margin_m
                if self._found:
                    self._level_m = self.margin_m
            spent = 0 if self._found else self._tries  # a goal that goes on may be out of reach
            self._begin_search(now)
            self._tries = spent
        self._goals = now.goals

    def _take_up(self, now: Situation) -> None:
        """Another goal."""
        self.drop()
        self.margin_m = self._level_m = self._params.margin_m
        self.gait, self.state = Gait.REACH, ArmState.REACHING
        self._begin_search(now)

    def _begin_search(self, now: Situation) -> None:
        margin, own = self._level_m + PLANNED_BESIDE_M, self._params.self_margin_m
        self._search.begin(
            now.goals,
            now.world,
            now.q,
            now.others_q,
            margin,
            own + PLANNED_BESIDE_M,
            seed=self._seed + self._attempts,
        )
        self._searched = now.goals
        self._searching, self._tries, self._found = True, 0, 0

    def _go_on_searching(self) -> None:
        params = self._params
        found = self._found = self._search.advance(params.goal_tries)
        self._tries += params.goal_tries
        self.iterations += params.goal_tries
        if found:
            self.posture = self._search.postures[0]
        least = self._level_m <= params.least_margin_m
        most = params.most_goal_tries if least else LEAST_TRIES
        if found >= params.enough_postures or self._tries >= most:
            self._searching = False

    def _leave_an_old_way(self, now: Situation) -> None:
        """The goal has gone on, and postures for where it is now are known."""
        if self._searching or self.gait is not Gait.FOLLOW or self._led_to is None:
            return
        if len(self._search.postures) and is_beyond(self._led_to, now.goals, JUMPED_M, JUMPED_RAD):
            self._find_a_way(now)

    def _find_a_way(self, now: Situation) -> None:
        """The arm is stuck."""
        if self.state is not ArmState.UNREACHABLE:
            self.state = ArmState.PLANNING
        if self.gait is Gait.FOLLOW:
            self.gait, self.way = Gait.STAND, None
        if self._searching:  # meanwhile the hands draw nearer as far as they can
            return
        self.gait = Gait.STAND
        if not len(self._search.postures):
            kept = "without contact" if len(now.world.kinds) else "within the limits"
            self._fail(f"no posture has the hand there {kept}", now)
            return
        margin, own = self._level_m + PLANNED_BESIDE_M, self._params.self_margin_m
        self._planner.begin(
            now.q,
            self._search.postures,
            now.world,
            now.others_q,
            margin,
            own + PLANNED_BESIDE_M,
            seed=self._seed + self._attempts,
        )
        self._planning, self._planned = True, 0
        self._led_to = now.goals

    def _go_on_planning(self, now: Situation) -> None:
        states = self._params.planner_states
        state = self._planner.advance(states)
        self._planned += states
        self.iterations += states
        if state is PlanState.FOUND:
            self._planning = False
            self.margin_m = self._level_m
            self.way = Way(self._planner.path, self._speeds)
            self.gait, self.state, self.reason = Gait.FOLLOW, ArmState.REACHING, ""
            self.progress.restart()
        elif state is PlanState.FAILED or self._planned >= self._params.most_planner_states:
            self._planning = False
            self._fail("no way there without contact was found", now)

    def _fail(self, reason: str, now: Situation) -> None:
        """This attempt has come to nothing."""
        self.gait = Gait.REACH
        self._attempts += 1
        self.progress.restart()
        if self._level_m > self._params.least_margin_m:
            self._lower_level()
        else:
            self._level_m = self._params.margin_m
            self.state, self.reason = ArmState.UNREACHABLE, reason
            self._retry_s = self._params.retry_s
        self._begin_search(now)

    def _look_along_the_way(self, now: Situation) -> None:
        way = self.way
        if way is None:
            return
        if way.is_at_end(now.q):
            self.posture = way.end
            self.way, self.gait = None, Gait.REACH
            self.progress.restart()
            return
        self._steps += 1
        if self._steps % LOOK_EVERY == 0:
            margin, own = ALONG_SHARE * self.margin_m, ALONG_SHARE * self._params.self_margin_m
            if not self._planner.is_path_free(
                way.path, way.at, now.world, now.others_q, margin, own, LOOKS
            ):
                self._find_a_way(now)

    def _is_there(self, errors: Sequence[tuple[float, float]], now: Situation) -> bool:
        """Whether the hands are at the goal, as far as any posture found has them there."""
        params = self._params
        off_m = max((error[0] for error in errors), default=0.0)
        off_rad = max((error[1] for error in errors), default=0.0)
        slack = STAYS_SHARE if self.state is ArmState.ARRIVED else 1.0
        turned_rad = slack * params.orientation_tolerance_rad
        if off_m > slack * params.position_tolerance_m:
            return False
        if off_rad <= turned_rad:
            self.reason = ""
            return True
        if self._searching:
            return False
        found = len(self._search.postures) > 0
        best_rad = self._search.orientation_error_rad if found else math.inf
        if off_rad > best_rad + turned_rad:
            return False
        if self._level_m > params.least_margin_m and len(now.world.kinds):
            self._lower_level()
            self._begin_search(now)
            return False
        self.reason = f"no posture has this orientation: {math.degrees(off_rad):.1f} deg away"
        return True

    def _lower_level(self) -> None:
        self._level_m = max(self._params.least_margin_m, 0.5 * self._level_m)
