"""Contact detection on the real recording: false alarms, and pushes added to it.

The recording is free of contact. A push is a constant force of random direction on the hand, added
with its moment to the readings for HOLD rows; it is found when the detector touches before it ends.
The learner runs with its gate as on the robot, also during the push. Thresholds come from the
training rows alone, by `threshold_for`, from a learner that had seen the first half of them.
"""

import math
from collections.abc import Callable
from copy import copy
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from dforc.arrays import Matrix, Vector
from dforc.contacts.detection import ContactDetector, threshold_for
from dforc.learning.feature_ridge import FeatureRidge, LearnerState
from dforc.learning.gate import UpdateGate
from dforc.robot_model import RobotModel
from services.core.errors import ConfigError
from services.experiments.forces import icubdyn
from services.experiments.forces.arm_learning import (
    SENSOR_FRAME,
    TIP,
    URDF,
    ArmTask,
    Rows,
    kernels_of,
    load_task,
    rest_kernels,
)
from services.experiments.forces.arm_learning import identified as identified_parameters
from services.experiments.rows import Row, at_least, at_most
from services.robotfile.model_file import urdf_path

FEATURES = 200
DEBOUNCE = 3
OFF_SHARE = 0.6  # of the threshold
PUSHES = 500
FORCES_N = (3.0, 5.0, 10.0)
HOLD = 28  # rows, a second
AFTER = 28
RULE_N = 3.0  # actionPrimitives on the robot: the norm, one threshold, no debounce
SEEDS = 3


Level = Callable[[Vector], float]


class Residual:
    """Measured minus expected, row by row; a learner of it, where there is one, is gated."""

    def __init__(self, theta: Vector, learner: FeatureRidge | None = None) -> None:
        self._theta = theta
        self._learner = learner
        self._gate = UpdateGate()

    def start(self, rows: Rows) -> None:
        """Learn these rows first."""
        self._gate = UpdateGate()
        if self._learner is not None:
            self._learner.fit(rows.x, rows.y - rows.regressors @ self._theta)

    def take(self, x: Vector, y: Vector, regressor: Matrix) -> Vector:
        """The residual (6,) of one row, which is learned afterwards if the gate permits."""
        rest: Vector = y - regressor @ self._theta
        if self._learner is None:
            return rest
        residual: Vector = rest - self._learner.predict(x)
        if self._gate.admit(float(np.linalg.norm(residual[:3]))):
            self._learner.update(x, rest)
        return residual

    def keep(self) -> tuple[LearnerState | None, UpdateGate]:
        """All that `take` changes."""
        return None if self._learner is None else self._learner.state(), copy(self._gate)

    def restore(self, kept: tuple[LearnerState | None, UpdateGate]) -> None:
        """Go back to it."""
        state, gate = kept
        self._gate = copy(gate)
        if self._learner is not None and state is not None:
            self._learner.restore(state)


@dataclass(frozen=True, slots=True)
class Rule:
    """When a limb counts as touched."""

    level: Level
    on: float
    samples: int = DEBOUNCE
    off_share: float = OFF_SHARE

    def detector(self) -> ContactDetector:
        """A new one."""
        return ContactDetector(
            self.on,
            self.on * self.off_share,
            on_samples=self.samples,
            off_samples=self.samples,
        )


@dataclass(slots=True)
class Outcome:
    """What a rule did on the test."""

    false_alarms: int
    highest: float  # level that it did not fall below for `samples` rows
    delays: dict[float, list[int]]  # by force: rows from the first with the push; -1 = not found
    stuck: int  # pushes after whose end it still touched, AFTER rows later


def force_norm(residual: Vector) -> float:
    """The plain level [N]."""
    return math.hypot(*residual[:3].tolist())


def whitened(residuals: Matrix) -> Level:
    """Norm of all six components in units of the covariance of these residuals."""
    L = np.linalg.inv(np.linalg.cholesky(residuals.T @ residuals / len(residuals)))
    return lambda residual: float(np.linalg.norm(L @ residual))


def second_half(task: ArmTask, residual: Residual) -> Matrix:
    """Residuals of the second half of the training rows, the first one known."""
    half = len(task.train) // 2
    first, second = _part(task.train, 0, half), _part(task.train, half, len(task.train))
    residual.start(first)
    rows = zip(second.x, second.y, second.regressors, strict=True)
    return np.array([residual.take(*row) for row in rows])


def judge(task: ArmTask, residual: Residual, rule: Rule, pushes: dict[int, Vector]) -> Outcome:
    """One pass over the test, leaving it for every push and coming back."""
    residual.start(task.train)
    detector = rule.detector()
    delays: dict[float, list[int]] = {force: [] for force in FORCES_N}
    levels, alarms, stuck = [], 0, 0
    was = False
    for i in range(len(task.test)):
        if i in pushes and not was:
            kept = residual.keep()
            for force in FORCES_N:
                found, ended = _pushed(task.test, residual, rule, i, force * pushes[i])
                delays[force].append(found)
                stuck += not ended
                residual.restore(kept)
        level = rule.level(_take(task.test, residual, i))
        levels.append(level)
        touching = detector.update(level)
        alarms += touching and not was
        was = touching
    windows = np.lib.stride_tricks.sliding_window_view(np.array(levels), rule.samples)
    return Outcome(alarms, float(windows.min(axis=1).max()), delays, stuck)


def _pushed(
    rows: Rows, residual: Residual, rule: Rule, start: int, wrench: Vector
) -> tuple[int, bool]:
    """Rows until the push is found, -1 if it is not; whether it had ended AFTER its end."""
    detector = rule.detector()
    found = -1
    for i in range(start, start + HOLD + AFTER):
        push = wrench if i < start + HOLD else 0.0 * wrench
        touching = detector.update(rule.level(_take(rows, residual, i, push)))
        if touching and found < 0 and i < start + HOLD:
            found = i - start
    return found, not detector.touching


def _take(rows: Rows, residual: Residual, i: int, push: Vector | float = 0.0) -> Vector:
    return residual.take(rows.x[i], rows.y[i] + push, rows.regressors[i])


def _part(rows: Rows, first: int, last: int) -> Rows:
    return Rows(rows.x[first:last], rows.y[first:last], rows.regressors[first:last])


def random_pushes(task: ArmTask, generator: np.random.Generator) -> dict[int, Vector]:
    """By row of the test: the reading (6,) of 1 N on the hand, of random direction."""
    arm = RobotModel(str(urdf_path(URDF)), icubdyn.JOINTS, TIP, {"arm": SENSOR_FRAME})
    last = len(task.test) - HOLD - AFTER
    pushes = {}
    for row in generator.choice(last, size=PUSHES, replace=False).tolist():
        direction = generator.normal(size=3)
        force = direction / np.linalg.norm(direction)
        q_rad = task.test.x[row, : arm.n]
        R, sensor_m = arm.sensor_pose(q_rad, "arm")
        _, tip_m = arm.tip_pose(q_rad)
        pushes[row] = np.concatenate([force, np.cross(R.T @ (tip_m - sensor_m), force)])
    return pushes


def detection_rows(data: Path | None) -> list[Row]:
    """All rules, or one row that says that the recording is not here."""
    try:
        task = load_task(data)
    except ConfigError as error:
        return [Row("detection on the real recording", str(error), "", "not run", None)]
    kernels = kernels_of(task)
    pushes = random_pushes(task, np.random.default_rng(11))
    nothing = np.zeros_like(task.drawing)
    with_offset = task.drawing.copy()
    with_offset[-6:] = (task.train.y - task.train.regressors @ task.drawing).mean(0)
    rigid = identified_parameters(task)
    learned = rest_kernels(task, rigid, kernels)
    rows = []
    for seed in range(SEEDS):
        learner = Residual(nothing, FeatureRidge(kernels, FEATURES, seed))
        rows += _learned(f"RFRR {FEATURES}, seed {seed}", task, learner, pushes if not seed else {})
    semi = Residual(with_offset, FeatureRidge(learned, FEATURES, 0))
    rows += _learned(f"CAD + RFRR {FEATURES}", task, semi, pushes)
    rows += _whitened("CAD + RFRR, six components whitened", task, semi, pushes)
    drawing = Residual(with_offset)
    for name, model in (("own", drawing), ("the learner's", semi)):
        rule = Rule(force_norm, _threshold(second_half(task, model), force_norm))
        rows += _compared(f"CAD + offset, {name} threshold", task, drawing, rule, pushes)
    for name, residual in (("CAD + offset", drawing), ("CAD + RFRR", semi)):
        plain = Rule(force_norm, RULE_N, samples=1, off_share=1.0)
        rows += _compared(f"{name}, actionPrimitives' rule", task, residual, plain, pushes)
    return rows


def _threshold(residuals: Matrix, level: Level) -> float:
    return threshold_for([level(residual) for residual in residuals], icubdyn.PERIOD_S)


def _learned(name: str, task: ArmTask, residual: Residual, pushes: dict[int, Vector]) -> list[Row]:
    """With the bars."""
    on = _threshold(second_half(task, residual), force_norm)
    outcome = judge(task, residual, Rule(force_norm, on), pushes)
    rows = [
        at_most(f"detection, {name}: threshold from training rows", on, "N", 2.5),
        at_most(f"detection, {name}: false alarms in 177 s", outcome.false_alarms, "", 0),
        Row(f"detection, {name}: level held {DEBOUNCE} rows, highest", outcome.highest, "N"),
    ]
    for force, delays in outcome.delays.items() if pushes else ():
        found, median = _found(delays)
        label = f"detection, {name}: {force:g} N"
        least = {3.0: 0.95, 5.0: 0.999, 10.0: 1.0}[force]
        rows.append(at_least(f"{label} found", found, "", least))
        rows.append(at_most(f"{label}, median delay", median, "rows", 2))
    if pushes:
        rows.append(_stuck(name, outcome))
    return rows


def _compared(
    name: str, task: ArmTask, residual: Residual, rule: Rule, pushes: dict[int, Vector]
) -> list[Row]:
    """Without bars."""
    outcome = judge(task, residual, rule, pushes)
    rows = [
        Row(f"detection, {name}: threshold", rule.on, "N" if rule.level is force_norm else "sd"),
        Row(f"detection, {name}: false alarms in 177 s", outcome.false_alarms),
    ]
    for force, delays in outcome.delays.items():
        found, median = _found(delays)
        rows.append(Row(f"detection, {name}: {force:g} N found", found))
        rows.append(Row(f"detection, {name}: {force:g} N, median delay", median, "rows"))
    return [*rows, _stuck(name, outcome)]


def _whitened(name: str, task: ArmTask, residual: Residual, pushes: dict[int, Vector]) -> list[Row]:
    seen = second_half(task, residual)
    level = whitened(seen)
    return _compared(name, task, residual, Rule(level, _threshold(seen, level)), pushes)


def _found(delays: list[int]) -> tuple[float, float]:
    """Share of the pushes that were found, and the median delay of these."""
    found = [delay for delay in delays if delay >= 0]
    return len(found) / len(delays), float(np.median(found)) if found else math.inf


def _stuck(name: str, outcome: Outcome) -> Row:
    share = outcome.stuck / sum(len(delays) for delays in outcome.delays.values())
    return Row(f"detection, {name}: still touched a second after the push", share)
