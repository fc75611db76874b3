"""Figure 7: average nMSE of what is predicted of the recorded arm's wrench, sample after sample.

Protocol of the paper: kernels by marginal likelihood on 500 rows, a start from 2000, then predict
and update over 5000. A guess 36 ms after the last truth is an easy game: repeating that truth does
well too. Hence the rows beside it: persistence, the model by itself, labels that come late, and a
learner that is frozen half-way.
"""

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from rich.console import Console
from rich.progress import Progress, SpinnerColumn, TextColumn, TimeElapsedColumn
from rich.table import Table

from dforc.arrays import Matrix, Vector
from dforc.learning.feature_ridge import FeatureRidge, Kernel
from dforc.learning.kernel_ridge import KernelRidge
from dforc.learning.recursive_ridge import RecursiveRidge
from dforc.learning.semi_parametric import SemiParametric
from services.experiments.forces.arm_learning import (
    ArmTask,
    drawing_errors,
    features_only,
    features_run,
    identified,
    kernels_of,
    load_task,
    predict_then_update,
    rest_kernels,
    semi_parametric_run,
)
from services.experiments.rows import Row, at_least, at_most, publish

SIZES = (200, 500, 1000)
REFIT_ROWS = 500
SECOND_ROWS = 28  # of the recording, in one second
SEMI_RUNS = 5
LARGE, LARGE_RUNS = 1000, 5  # runs differ by 1e-5 there, and each takes half a minute
SHOWN = (100, 1000, 2000, 5000)
SHORT_RUNS = 2
LINEAR_REGULARISATION = 1e-6

Progressed = Callable[[str], None]


@dataclass(frozen=True, slots=True, eq=False)
class Curve:
    """One learner: its average nMSE after each row, and how far the runs' ends are apart."""

    name: str
    values: Vector
    deviation: float | None = None

    @property
    def end(self) -> float:
        """After all rows."""
        return float(self.values[-1])


@dataclass(frozen=True, slots=True, eq=False)
class Outcome:
    """Every curve by name, and the figures that are no curve."""

    curves: dict[str, Curve]
    figures: dict[str, float]


def measure(
    task: ArmTask, runs: int, sizes: tuple[int, ...], refits: bool, say: Progressed
) -> Outcome:
    """All learners, one after the other, on the same rows."""
    say("hyperparameters by marginal likelihood")
    kernels = kernels_of(task)
    curves = [
        Curve("persistence", task.curve(_persistence(task))),
        Curve("linear, incremental", task.curve(_linear(task))),
        Curve("CAD + offset", task.curve(drawing_errors(task))),
    ]
    rigid = identified(task)
    curves.append(Curve("rigid bodies identified", task.curve(_rigid_errors(task, rigid.theta))))
    say("KRR on 2000 rows")
    curves.append(Curve("KRR, static", task.curve(_kernel_ridge(task, kernels, len(task.test)))))
    if refits:
        say(f"KRR, refitted on everything every {REFIT_ROWS} rows")
        curves.append(Curve("KRR, refitted", task.curve(_kernel_ridge(task, kernels, REFIT_ROWS))))
    for size in sizes:
        many = runs if size < LARGE else min(runs, LARGE_RUNS)
        curves.append(_many(task, kernels, size, many, say))
    semi, figures = _semi_parametric(task, rest_kernels(task, rigid, kernels), runs, say)
    figures |= _late_and_cold(task, kernels, min(runs, SEMI_RUNS), say)
    return Outcome({curve.name: curve for curve in [*curves, *semi]}, figures)


def _many(
    task: ArmTask, kernels: tuple[Kernel, ...], size: int, runs: int, say: Progressed
) -> Curve:
    values = []
    for seed in range(runs):
        say(f"RFRR {size}, run {seed + 1} of {runs}")
        values.append(task.curve(features_run(task, FeatureRidge(kernels, size, seed))))
    return Curve(f"RFRR {size}", np.mean(values, 0), _deviation(values))


def _deviation(runs: list[Vector]) -> float | None:
    """Of the runs' ends; one run has none."""
    return float(np.std([run[-1] for run in runs])) if len(runs) > 1 else None


def _semi_parametric(
    task: ArmTask, kernels: tuple[Kernel, ...], runs: int, say: Progressed
) -> tuple[list[Curve], dict[str, float]]:
    half = len(task.test) // 2
    late: dict[int, list[Vector]] = {0: [], 1: [], 5: []}
    frozen = []
    for seed in range(min(runs, SEMI_RUNS)):
        say(f"semi-parametric, run {seed + 1} of {min(runs, SEMI_RUNS)}")
        learner = SemiParametric(identified(task), FeatureRidge(kernels, 200, seed))
        for seconds, ends in late.items():
            errors = semi_parametric_run(task, learner, seconds * SECOND_ROWS)
            ends.append(task.curve(errors))
        errors = semi_parametric_run(task, learner, last=half)
        frozen.append(task.error(errors[half:]))
    names = {0: "semi-parametric", 1: "semi-parametric, 1 s late", 5: "semi-parametric, 5 s late"}
    curves = [
        Curve(names[seconds], np.mean(ends, 0), _deviation(ends)) for seconds, ends in late.items()
    ]
    return curves, {"semi-parametric, frozen second half": float(np.mean(frozen))}


def _late_and_cold(
    task: ArmTask, kernels: tuple[Kernel, ...], runs: int, say: Progressed
) -> dict[str, float]:
    late, cold = [], []
    for seed in range(runs):
        say(f"RFRR 200, labels late and cold start, run {seed + 1} of {runs}")
        learner = FeatureRidge(kernels, 200, seed)
        late.append(task.error(features_run(task, learner, SECOND_ROWS)))
        learner.reset(task.hyper.y.mean(0))
        errors = features_only(task, learner)
        cold.append(task.error(errors))
    return {
        "RFRR 200, 1 s late": float(np.mean(late)),
        "RFRR 200, cold start": float(np.mean(cold)),
    }


def _persistence(task: ArmTask) -> Matrix:
    before = np.vstack([task.train.y[-1:], task.test.y[:-1]])
    return task.test.y - before


def _rigid_errors(task: ArmTask, theta: Vector) -> Matrix:
    errors: Matrix = task.test.y - task.test.regressors @ theta
    return errors


def _linear(task: ArmTask) -> Matrix:
    mean, spread = task.train.x.mean(0), task.train.x.std(0)
    train, test = (
        np.hstack([(rows.x - mean) / spread, np.ones((len(rows), 1))])
        for rows in (task.train, task.test)
    )
    learner = RecursiveRidge(train.shape[1], 6, LINEAR_REGULARISATION)
    learner.fit(train, task.train.y)
    y = task.test.y
    return predict_then_update(
        lambda i: learner.predict(test[i]), lambda i: learner.update(test[i], y[i]), y
    )


def _kernel_ridge(task: ArmTask, kernels: tuple[Kernel, ...], every: int) -> Matrix:
    """Errors of KRR, solved anew for everything seen after `every` rows."""
    x, y = np.vstack([task.train.x, task.test.x]), np.vstack([task.train.y, task.test.y])
    errors = np.empty_like(task.test.y)
    for start in range(0, len(errors), every):
        seen, now = len(task.train) + start, slice(start, start + every)
        mean = y[:seen].mean(0)
        for kernel in kernels:
            columns = list(kernel.outputs)
            learner = KernelRidge(kernel.length_scales, kernel.regularisation)
            learner.fit(x[:seen], (y[:seen] - mean)[:, columns])
            guess = learner.predict(task.test.x[now]) + mean[columns]
            errors[now, columns] = task.test.y[now][:, columns] - guess
    return errors


def table(outcome: Outcome) -> Table:
    """Every learner on its way."""
    shown = Table("learner", *(f"after {n}" for n in SHOWN), title="average nMSE")
    for curve in outcome.curves.values():
        shown.add_row(curve.name, *(f"{curve.values[n - 1]:.4f}" for n in SHOWN))
    return shown


def rows_of(outcome: Outcome) -> list[Row]:
    """The end of each learner, then what is held against a bar."""
    rows = [Row(curve.name, curve.end, "nMSE") for curve in outcome.curves.values()]
    ours, static = outcome.curves["RFRR 200"], outcome.curves["KRR, static"]
    rows += [
        at_most("RFRR 200 after all rows", ours.end, "nMSE", 0.0075),
        at_least("static KRR over RFRR 200", static.end / ours.end, "x", 2.8),
    ]
    if ours.deviation is not None:
        name = "RFRR 200, standard deviation of the runs"
        rows.append(at_most(name, ours.deviation, "nMSE", 1e-4))
    if "RFRR 1000" in outcome.curves:
        ratio = ours.end / outcome.curves["RFRR 1000"].end
        rows.append(at_most("RFRR 200 over RFRR 1000", ratio, "x", 1.05))
    late = outcome.curves["semi-parametric, 1 s late"].end
    rows.append(at_most("semi-parametric, labels 1 s late", late, "nMSE", 0.0092))
    very_late = outcome.curves["semi-parametric, 5 s late"].end
    rows.append(at_most("semi-parametric, labels 5 s late", very_late, "nMSE", 0.0115))
    bars = {"semi-parametric, frozen second half": 0.0172, "RFRR 200, cold start": 0.0072}
    for name, value in outcome.figures.items():
        bar = bars.get(name)
        rows.append(Row(name, value, "nMSE") if bar is None else at_most(name, value, "nMSE", bar))
    return rows


def force_fig7(
    *,
    data: Path | None = None,
    runs: int = 25,
    short: bool = False,
    json: Path | None = None,
    plot: Path = Path("force-fig7.png"),
) -> int:
    """Figure 7 on the recording: 0 when every bar holds.

    Raises:
        ConfigError: the recording is not there.
    """
    from services.experiments.forces.learning_plots import draw_fig7

    console = Console()
    task = load_task(data)
    with Progress(
        SpinnerColumn(), TextColumn("{task.description}"), TimeElapsedColumn(), console=console
    ) as progress:
        shown = progress.add_task("starting", total=None)
        outcome = measure(
            task,
            SHORT_RUNS if short else runs,
            SIZES[:1] if short else SIZES,
            not short,
            lambda what: progress.update(shown, description=what),
        )
    draw_fig7(list(outcome.curves.values()), plot)
    console.print(table(outcome))
    status = publish("Figure 7: recorded right arm, predict then update", rows_of(outcome), json)
    console.print(f"plot: {plot}")
    return status
