"""A path looked at in advance, a few periods at a time, so that the running field is never late.

Objects go on as they move now. The path ends where it arrives, or where nothing goes on any more.
"""

import math
from dataclasses import replace

from dforc.errors import DforcError
from services.core.errors import ConfigError
from services.fields.around import around_limb
from services.fields.goals import ActiveGoal, out_of_reach
from services.fields.limbs import FieldLimb
from services.fields.messages import PathPoint, Preview
from services.fields.mode import PERIOD_S, FieldMode, Goals, Motion, Surroundings
from services.fields.seen import SeenObject, Sighting
from services.reaching.tip_poses import vector3

USUAL_S = 15.0
LONGEST_S = 60.0
POINT_EVERY = 5  # periods
BUSY_SHARE = 4  # of the periods are left where a point is in motion
MOST_TURNS = 4000  # steps of the service for one path: who asks gives up some time, too
PATIENCE_S = 3.0  # with a state in which nothing goes on
ENDING = ("waiting", "unreachable", "idle")


class PreviewJob:
    """One path."""

    def __init__(
        self,
        law: FieldMode,
        limb: FieldLimb,
        goal: ActiveGoal,
        seen: tuple[SeenObject, ...],
        around: Surroundings,
        duration_s: float,
    ) -> None:
        """`law` has begun where the path is to begin.

        Raises:
            ConfigError: no such duration.
        """
        if not 0.0 <= duration_s <= LONGEST_S:
            raise ConfigError(f"a preview lasts up to {LONGEST_S:g} s, not {duration_s:g} s")
        self.law = law
        self._limb = limb
        self._goal = goal
        self._seen = seen
        self._body = (around.body_rad, around.body_rad_s)
        self._still = around if not any(any(one.velocity_m_s) for one in seen) else None
        self._steps = round((duration_s or USUAL_S) / PERIOD_S)
        self._step = 0
        self._path: list[PathPoint] = []
        self._last: Motion | None = None
        self._away_m = math.nan
        self._closest = (math.inf, "", 0.0)
        self._ended_s = math.nan
        self._idle_steps = 0
        self._failure = ""
        self._beyond = ""  # reach, at the end
        self._turns = 0

    def advance(self, *, busy: bool) -> bool:
        """Go on for as many periods as one step of the service has time for; whether it is over."""
        self._turns += 1
        if self._turns > MOST_TURNS:
            self._failure = f"looked no further than {self._step * PERIOD_S:.1f} s along it"
            return True
        share = BUSY_SHARE if busy else 1
        for _ in range(max(1, self.law.preview_steps // share)):
            if self._step >= self._steps or self._is_over():
                return True
            try:
                self._roll()
            except DforcError as error:
                self._failure = str(error)
                return True
        return False

    def result(self) -> Preview:
        """What has been found."""
        last = self._last
        state = "idle" if last is None else "unreachable" if self._beyond else last.state
        arrives = state == "arrived"
        closest_m, closest_to, closest_s = self._closest
        reason = self._failure or self._beyond or ("" if last is None else last.reason)
        if not arrives and not reason:
            reason = f"it takes longer than {self._steps * PERIOD_S:g} s"
        return Preview(
            mode=self.law.name,
            limb=self._limb.name,
            arrives=arrives,
            arrival_s=self._step * PERIOD_S if arrives else math.nan,
            state=state,
            reason=reason,
            closest_m=closest_m,
            closest_to=closest_to,
            closest_s=closest_s,
            final_distance_m=self._away_m,
            path=tuple(self._path),
        )

    def _is_over(self) -> bool:
        if self._last is None:
            return False
        return self._last.state == "arrived" or self._idle_steps * PERIOD_S >= PATIENCE_S

    def _roll(self) -> None:
        t_s = self._step * PERIOD_S
        seen = self._seen if self._still is not None else moved_on(self._seen, t_s)
        around = self._still or around_limb(seen, self._goal, self._body)
        goals, reason = self._goal.hands(self._limb, seen)
        if goals is None:
            raise ConfigError(reason)
        self._beyond = out_of_reach(self._limb, goals)
        motion = self.law.step(goals, around, 0.0)
        self._step += 1
        self._last = motion
        self._away_m = goal_distance_m(motion, goals)
        self._idle_steps = self._idle_steps + 1 if motion.state in ENDING else 0
        if motion.clearance_m < self._closest[0]:
            self._closest = (motion.clearance_m, " - ".join(motion.nearest), t_s + PERIOD_S)
        if self._step % POINT_EVERY == 0 or self._is_over() or self._step == self._steps:
            self._path.append(self._point(motion))

    def _point(self, motion: Motion) -> PathPoint:
        first, *others = motion.hands
        return PathPoint(
            t_s=round(self._step * PERIOD_S, 9),
            position_m=vector3(first.position_m),
            clearance_m=motion.clearance_m,
            goal_distance_m=self._away_m,
            q_rad=() if motion.q_rad is None else tuple(motion.q_rad.tolist()),
            second_position_m=vector3(others[0].position_m) if others else None,
        )


def moved_on(seen: tuple[SeenObject, ...], t_s: float) -> tuple[SeenObject, ...]:
    """Objects where they will be if they go on as they move now, by their smooth estimate.

    What is quick to be believed for the next tenth of a second shakes, and would carry far.
    """
    moved = []
    for one in seen:
        place = Sighting(one.place_m, one.velocity_m_s, one.sigma_m).after(t_s)
        avoided = None
        if one.avoided is not None:
            avoided = one.avoided._replace(velocity_m_s=one.velocity_m_s).after(t_s)
        solid = replace(one.solid, position_m=place.position_m)
        moved.append(replace(one, solid=solid, avoided=avoided))
    return tuple(moved)


def goal_distance_m(motion: Motion, goals: Goals) -> float:
    """Of the worst hand from its goal."""
    pairs = zip(motion.hands, goals, strict=True)
    return max(
        (math.dist(hand.position_m, goal.position_m) for hand, goal in pairs if goal is not None),
        default=math.nan,
    )
