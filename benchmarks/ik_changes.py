"""Another problem from one answer to the next: honoured at once, and nothing is built for it."""

import copy
from collections.abc import Callable
from dataclasses import dataclass, field
from functools import partial

import numpy as np

from benchmarks.ik_setting import Setting
from dforc.ik.inverse_kinematics import InverseKinematics
from dforc.ik.problem import IkProblem, TipTarget
from dforc.limits import JointLimits
from dforc.rotation import matrix
from services.core.clock import NS_PER_MS, thread_cpu_ns
from services.experiments.ik.arm import TOLERANCE_M, Arm, Array
from services.experiments.ik.contenders import problem_of
from services.experiments.ik.measure import KEPT_RAD, OPTIMAL, OPTIMAL_SHARE, ROUNDING, percent
from services.experiments.ik.nlp import Form, PlainNlp
from services.experiments.rows import Row, at_least, at_most

MASK_TARGETS, TARGETS, STARTS = 200, 40, 6
TORSO_RAD = np.radians([10.0, 0.0, -10.0])
TICK_MS = 10.0
BLOCKED_RAD = 1e-9
FINE_M = 1e-4
OFFSET_M, TURN_RAD = np.array([0.03, 0.0, 0.08]), (0.3, -0.2, 0.5)


@dataclass(frozen=True, eq=False)
class Change:
    """One change, the arm that judges the answers, and what else is asked of them."""

    name: str
    problem: IkProblem
    judge: Arm
    q0: Array
    tolerance_m: float = TOLERANCE_M
    offset: tuple[Array, Array] = field(default_factory=lambda: (np.eye(3), np.zeros(3)))
    is_best: bool = False  # the objective, too, is compared
    targets: int = TARGETS

    def pose(self, q: Array) -> tuple[Array, Array]:
        """Of the tip as it is now."""
        R, p = self.judge.pose(q)
        return R @ self.offset[0], p + R @ self.offset[1]


def rows(setting: Setting) -> list[Row]:
    """Every change, and back again."""
    arm = setting.arm
    plain = problem_of(arm)
    ik = InverseKinematics(plain)
    found: list[Row] = []
    for change in _changes(arm, plain):
        setting.say(f"{change.name} ...")
        found += _rows_of(setting, ik, plain, change)
    return found


def _changes(arm: Arm, plain: IkProblem) -> list[Change]:
    def like(**values: Array) -> Arm:
        other = copy.copy(arm)
        for name, value in values.items():
            setattr(other, name, value)
        return other

    torso = arm.rest.copy()
    torso[:3] = TORSO_RAD
    free = np.arange(arm.n) >= len(TORSO_RAD)
    lower, upper = arm.lower.copy(), arm.upper.copy()
    held = like(lower=np.where(free, lower, torso), upper=np.where(free, upper, torso))
    lower[:3], upper[:3] = -0.1, 0.15
    upper[6] = np.radians(70.0)
    narrow = like(lower=lower, upper=upper)
    limits = JointLimits.make(lower, upper, arm.A, arm.row_lower, arm.row_upper)
    rest = np.radians([5.0, -5.0, 10.0, -50.0, 50.0, 20.0, 80.0, 10.0, -10.0, 5.0])
    weights = np.where(free, 0.5, 2.0)
    turn = matrix(TURN_RAD)
    tip = plain.tips[0].attached(turn, OFFSET_M)
    return [
        Change("torso blocked", plain.changed(free=free), held, torso, targets=MASK_TARGETS),
        Change("limits", plain.changed(limits=limits), narrow, arm.rest, is_best=True),
        Change("tip frame", plain.changed(tips=(tip,)), arm, arm.rest, offset=(turn, OFFSET_M)),
        Change(
            "rest posture", plain.changed(rest_rad=rest), like(rest=rest), arm.rest, is_best=True
        ),
        Change(
            "weights",
            plain.changed(rest_weights=weights),
            like(weights=weights),
            arm.rest,
            is_best=True,
        ),
        Change("eps", plain.changed(position_tolerance_m=FINE_M), arm, arm.rest, FINE_M),
    ]


def _rows_of(
    setting: Setting, ik: InverseKinematics, plain: IkProblem, change: Change
) -> list[Row]:
    judge = change.judge
    rng = np.random.default_rng([setting.seed, 6])
    count = change.targets // 5 if setting.short else change.targets
    good, usual_ms, changed_ms, moved = [], [], [], 0.0
    best = _best_of(judge, rng) if change.is_best else None
    for q in judge.postures(rng, count):
        R, p = change.pose(q)
        target = [TipTarget.checked(p, R)]
        ik.change(plain)
        usual_ms.append(_ms(partial(ik.solve, target, judge.rest)))
        changed_ms.append(_ms(partial(_changed, ik, change, target)))
        answer = np.array(ik.solve(target, change.q0).q_rad)
        off_m = float(np.linalg.norm(change.pose(answer)[1] - p))
        kept = judge.violation(answer) <= KEPT_RAD
        cheap = best is None or _is_cheap(judge, answer, R, best(p, R, q))
        good.append(off_m <= ROUNDING * change.tolerance_m and kept and cheap)
        moved = max(moved, float(np.abs((answer - change.q0)[~change.problem.free]).max(initial=0)))
    what = f"change of {change.name}"
    extra_ms = float(np.median(changed_ms) - np.median(usual_ms))
    found = [
        at_least(
            f"{what}: honoured by the next answer ({count})", percent(np.array(good)), "%", 100.0
        ),
        Row(f"{what}: usual answer, median", float(np.median(usual_ms)), "ms"),
        Row(f"{what}: change and next answer, median", float(np.median(changed_ms)), "ms"),
        at_most(f"{what}: so much longer", extra_ms, "ms", TICK_MS),
    ]
    if not change.problem.free.all():
        found.append(at_most(f"{what}: blocked joints moved", moved, "rad", BLOCKED_RAD))
    return found


def _changed(ik: InverseKinematics, change: Change, target: list[TipTarget]) -> object:
    ik.change(change.problem)
    return ik.solve(target, change.q0)


def _ms(call: Callable[[], object]) -> float:
    """Of one call: what comes after a change comes once."""
    begin_ns = thread_cpu_ns()
    call()
    return (thread_cpu_ns() - begin_ns) / NS_PER_MS


Cost = Callable[[Array, Array, Array], float]


def _best_of(judge: Arm, rng: np.random.Generator) -> Cost:
    """The lowest objective that an independent solver finds from several starts."""
    nlp = PlainNlp(judge, Form.EXACT, "fatrop")

    def cost(p: Array, R: Array, q: Array) -> float:
        ends = [nlp.solve(p, R, start) for start in (q, *judge.postures(rng, STARTS))]
        reached = [end for end in ends if judge.distance_m(end, p) <= FINE_M]
        return min(judge.objective(end, R) for end in (q, *reached))

    return cost


def _is_cheap(judge: Arm, q: Array, R: Array, best: float) -> bool:
    return judge.objective(q, R) <= (1.0 + OPTIMAL_SHARE) * best + OPTIMAL
