"""One scene, one law: the motion is executed tick by tick and judged by the referee."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

import numpy as np

from dforc.field.rollout import PERIOD_S
from dforc.rotation import angle_between
from services.core.clock import thread_cpu_ns
from services.experiments.whole_arm.draw import ArmScene
from services.experiments.whole_arm.laws import ENDED, ArmLaw, Seen
from services.experiments.whole_arm.referee import Array, Standing, Verdict
from services.experiments.whole_arm.setting import ArmSetting

REACHED_M = 0.005
TURNED_RAD = np.radians(3.0)
LONGEST_S = 20.0
SETTLE_S = 0.5  # within 5 mm for so long is reached
TURN_S = 4.0  # after that the hand may still turn
KEPT_RAD = 1e-6  # by which a limit may be missed
NEARER_M = 1e-5  # in a tick: it moves towards the goal
SAYINGS = ("planning", "waiting", "unreachable")


@dataclass(frozen=True, eq=False)
class Moment:
    """One tick of a scene that changes: what the law is told, and how it truly is."""

    seen: Seen
    centres_m: Array | None = None  # (m, 3) of the scene's obstacles; None: where they were
    body_rad: Array | None = None  # (N,) joints that are not the limb's; None: at home
    is_waiting: bool = False  # the scene's goal is not given yet, or nobody can reach it


Course = Callable[[int], Moment]  # by the tick's number; called once for each


@dataclass
class Outcome:
    """What came of it."""

    law: str
    family: str
    number: int
    reached_s: float | None = None  # since when all hands stayed within 5 mm
    error_m: float = np.inf  # of the worst hand at the end
    angle_rad: float = np.inf
    verdict: Verdict = field(default_factory=Verdict)
    path_m: float = 0.0  # of the first hand
    outside_rad: float = -np.inf  # largest, of a limit or row
    goal_s: float = 0.0  # when the goal was given or could be reached
    moved_s: float | None = None  # after that: the hands drew nearer to it
    said_s: float | None = None  # the same, or word of planning, waiting, or out of reach
    states: tuple[str, ...] = ()  # in their order
    reason: str = ""  # the last one
    ticks_us: list[float] = field(default_factory=list)

    @property
    def reached(self) -> bool:
        """All hands within 5 mm."""
        return self.reached_s is not None

    @property
    def turned(self) -> bool:
        """And turned as they should be."""
        return self.reached and self.angle_rad <= TURNED_RAD

    @property
    def keeps_limits(self) -> bool:
        """Inside all limits and rows."""
        return self.outside_rad <= KEPT_RAD

    @property
    def is_clean(self) -> bool:
        """No contact, limits kept."""
        return self.verdict.is_clean and self.keeps_limits

    def cause(self) -> str:
        """What is wrong with it, in words; empty if nothing is."""
        found = []
        v = self.verdict
        for near, at_s in ((v.obstacle, v.obstacle_s), (v.itself, v.itself_s)):
            if near.distance_m <= 0.0:
                depth = -1e3 * near.distance_m
                found.append(f"{near.pair[0]} in {near.pair[1]}, {depth:.1f} mm, at {at_s:.2f} s")
        if not self.keeps_limits:
            found.append(f"limit missed by {np.degrees(self.outside_rad):.2g} deg")
        if not self.reached:
            states = " > ".join(self.states[-4:])
            found.append(f"{1e3 * self.error_m:.0f} mm away ({states}; {self.reason})")
        elif not self.turned:
            found.append(f"turned {np.degrees(self.angle_rad):.0f} deg wrong ({self.reason})")
        return "; ".join(found)


@dataclass(frozen=True, eq=False)
class Trace:
    """A run tick by tick, to look at."""

    q_rad: Array  # (k, n)
    states: tuple[str, ...]  # (k,)


def run(
    setting: ArmSetting,
    law: ArmLaw,
    scene: ArmScene,
    longest_s: float = LONGEST_S,
    course: Course | None = None,
) -> tuple[Outcome, Trace]:
    """Execute and judge. Without a course everything stands still."""
    outcome = Outcome(law.name, scene.family, scene.number)
    referee = setting.referee
    referee.face(scene.obstacles)
    still = Moment(Seen(scene.goals, scene.obstacles))
    law.begin(scene.start_rad)
    before = Standing(setting.whole(scene.start_rad))
    within, away = 0, _away(setting, scene, before)
    postures, states = [scene.start_rad], [""]
    for tick in range(round(longest_s / PERIOD_S)):
        moment = still if course is None else course(tick)
        begun = thread_cpu_ns()
        answer = law.step(moment.seen)
        outcome.ticks_us.append((thread_cpu_ns() - begun) / 1e3)
        q, at_s = answer.q_rad, tick * PERIOD_S
        after = Standing(setting.whole(q, moment.body_rad), moment.centres_m)
        referee.judge(outcome.verdict, before, after, at_s, PERIOD_S)
        outcome.outside_rad = max(outcome.outside_rad, setting.limits.violation(q))
        gone = _away(setting, scene, after)
        if moment.is_waiting:
            outcome.goal_s = at_s + PERIOD_S
        else:
            _note(outcome, answer.state, gone, away, at_s + PERIOD_S)
        away = gone
        outcome.reason = answer.reason or outcome.reason
        before = after
        postures.append(q)
        states.append(answer.state)
        there = not moment.is_waiting and float(gone.max()) <= REACHED_M
        within = within + 1 if there else 0
        outcome.reached_s = _since(within, at_s)
        if outcome.reached_s is not None and (
            within * PERIOD_S >= TURN_S or _turn(setting, scene, after) <= TURNED_RAD
        ):
            break
        if answer.state == ENDED and not within:
            break
    _measure(outcome, setting, scene, postures, before)
    outcome.states = _without_repeats(states)
    return outcome, Trace(np.array(postures), tuple(states))


def _note(outcome: Outcome, state: str, away: Array, before: Array, at_s: float) -> None:
    """When the goal was answered: distances of the hands now and a tick before."""
    moves = float((before - away).sum()) > NEARER_M
    if moves and outcome.moved_s is None:
        outcome.moved_s = at_s - outcome.goal_s
    if (moves or state in SAYINGS) and outcome.said_s is None:
        outcome.said_s = at_s - outcome.goal_s


def _since(within: int, at_s: float) -> float | None:
    """Since when the hands have been at their goals, where that counts as reached."""
    lasts_s = within * PERIOD_S
    return at_s + PERIOD_S - lasts_s if lasts_s >= SETTLE_S - 1e-9 else None


def _turn(setting: ArmSetting, scene: ArmScene, standing: Standing) -> float:
    """Of the worst hand from its goal [rad]."""
    pairs = zip(setting.hands_of(standing.body_rad), scene.goals, strict=True)
    return max(angle_between(R, goal.rotation) for (R, _), goal in pairs)


def _away(setting: ArmSetting, scene: ArmScene, standing: Standing) -> Array:
    """Distance of each hand from its goal."""
    hands = setting.hands_of(standing.body_rad)
    pairs = zip(hands, scene.goals, strict=True)
    return np.array([float(np.linalg.norm(p - goal.position_m)) for (_, p), goal in pairs])


def _measure(
    outcome: Outcome,
    setting: ArmSetting,
    scene: ArmScene,
    postures: Sequence[Array],
    last: Standing,
) -> None:
    outcome.error_m = float(_away(setting, scene, last).max())
    outcome.angle_rad = _turn(setting, scene, last)
    hands = np.array([setting.hands(q)[0][1] for q in postures])
    outcome.path_m = float(np.linalg.norm(np.diff(hands, axis=0), axis=1).sum())


def _without_repeats(states: Sequence[str]) -> tuple[str, ...]:
    kept = [a for a, b in zip(states, ["", *states[:-1]], strict=True) if a != b]
    return tuple(kept)
