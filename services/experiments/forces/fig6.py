"""Figure 6: error per joint of learners of inverse dynamics on motion that they have not seen.

The paper compares on Sarcos and Barrett sets, which are not published as they were used; here the
data are made by script (made_arm). KRR and GPR learn from 2000 rows, RFRR from all 15 000; every
joint has a kernel of its own, found on 500 rows, and RFRR uses that of KRR.
"""

import warnings
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from rich.console import Console
from rich.progress import Progress, SpinnerColumn, TextColumn, TimeElapsedColumn
from rich.table import Table

from dforc.arrays import Matrix, Vector
from dforc.learning.feature_ridge import FeatureRidge, Kernel, fit_kernels
from dforc.learning.kernel_ridge import KernelRidge
from dforc.learning.recursive_ridge import batch_weights
from services.experiments.forces.made_arm import JOINTS, MadeArm, Motion, made_arm
from services.experiments.rows import Row, at_most, publish

RUNS = {500: 25, 1000: 10, 2000: 5}
"""At most so many runs of each size: the largest take a minute each."""

WRONG = 1.1  # factor on every inertial parameter of a wrong model
GROUPS = tuple((joint,) for joint in range(len(JOINTS)))

Say = Callable[[str], None]


@dataclass(frozen=True, slots=True, kw_only=True)
class Sizes:
    """How much of everything."""

    rollouts: int = 10
    rows: int = 1500
    unseen: int = 5
    unseen_rows: int = 1000
    hyper_rows: int = 500
    kernel_rows: int = 2000
    gpr_rows: int = 300  # that scikit-learn looks for its own hyperparameters on
    features: tuple[int, ...] = tuple(RUNS)


SHORT = Sizes(
    rollouts=2, rows=200, unseen=1, unseen_rows=150, hyper_rows=60, kernel_rows=150, gpr_rows=40,
    features=(100,),
)  # fmt: skip


@dataclass(frozen=True, slots=True, eq=False)
class Score:
    """nMSE per joint (7,): mean over the runs, and their standard deviation."""

    mean: Vector
    deviation: Vector
    runs: int = 1


def measure(arm: MadeArm, sizes: Sizes, runs: int, say: Say) -> dict[str, Score]:
    """Every learner on the same unseen rollouts."""
    order = np.random.default_rng(1).permutation(len(arm.train))
    hyper, some = arm.train.at(order[: sizes.hyper_rows]), arm.train.at(order[: sizes.kernel_rows])
    scores = {
        "CAD, no friction": _single(arm.errors(arm.test.regressors @ arm.drawing)),
        "linear": _single(arm.errors(_linear(arm))),
    }
    say("hyperparameters by marginal likelihood, joint by joint")
    kernels = fit_kernels(hyper.x, hyper.tau_nm, GROUPS)
    say(f"KRR on {len(some)} rows")
    scores[f"KRR {len(some)}"] = _single(arm.errors(_kernel_ridge(some, kernels, arm.test.x)))
    for size in sizes.features:
        scores[f"RFRR {size}"] = _many(arm, kernels, size, min(runs, RUNS.get(size, runs)), say)
    for name, factor in (
        ("semi-parametric 200", 1.0),
        ("semi-parametric 200, CAD 10 % wrong", WRONG),
    ):
        say(name)
        theta = factor * arm.drawing
        rest_kernels = fit_kernels(hyper.x, hyper.tau_nm - hyper.regressors @ theta, GROUPS)
        scores[name] = _semi_parametric(arm, rest_kernels, theta)
    return scores


def _single(errors: Vector) -> Score:
    return Score(errors, np.zeros_like(errors))


def _linear(arm: MadeArm) -> Matrix:
    centre, spread = arm.train.x.mean(0), arm.train.x.std(0)
    train, test = (
        np.c_[(motion.x - centre) / spread, np.ones(len(motion))]
        for motion in (arm.train, arm.test)
    )
    predicted: Matrix = test @ batch_weights(train, arm.train.tau_nm, 1e-3 * len(train))
    return predicted


def _kernel_ridge(motion: Motion, kernels: tuple[Kernel, ...], x: Matrix) -> Matrix:
    mean = motion.tau_nm.mean(0)
    columns = []
    for kernel in kernels:
        learner = KernelRidge(kernel.length_scales, kernel.regularisation)
        columns.append(
            learner.fit(motion.x, (motion.tau_nm - mean)[:, list(kernel.outputs)]).predict(x)
        )
    predicted: Matrix = np.hstack(columns) + mean
    return predicted


def _many(arm: MadeArm, kernels: tuple[Kernel, ...], size: int, runs: int, say: Say) -> Score:
    errors = []
    for seed in range(runs):
        say(f"RFRR {size}, run {seed + 1} of {runs}")
        errors.append(arm.errors(_features(arm, kernels, size, seed, arm.train.tau_nm)))
    return Score(np.mean(errors, 0), np.std(errors, 0), runs)


def _features(
    arm: MadeArm, kernels: tuple[Kernel, ...], size: int, seed: int, target: Matrix
) -> Matrix:
    """Predictions for the test, joint after joint: one joint's features in memory at a time."""
    predicted = np.empty_like(arm.test.tau_nm)
    for kernel in kernels:
        joint = list(kernel.outputs)
        learner = FeatureRidge((replace(kernel, outputs=(0,)),), size, [seed, *joint])
        learner.fit(arm.train.x, target[:, joint])
        predicted[:, joint] = learner.predict_rows(arm.test.x)
    return predicted


def _semi_parametric(arm: MadeArm, kernels: tuple[Kernel, ...], theta: Vector) -> Score:
    """The drawing's rigid bodies, and features on the rest."""
    rest = arm.train.tau_nm - arm.train.regressors @ theta
    learned = _features(arm, kernels, 200, 0, rest)
    return _single(arm.errors(arm.test.regressors @ theta + learned))


def gaussian_process(arm: MadeArm, sizes: Sizes, say: Say) -> Score:
    """GPR by scikit-learn, which looks for hyperparameters of its own.

    Raises:
        ImportError: it is not installed.
    """
    from sklearn.gaussian_process import GaussianProcessRegressor
    from sklearn.gaussian_process.kernels import RBF, ConstantKernel, WhiteKernel

    order = np.random.default_rng(1).permutation(len(arm.train))
    few, some = arm.train.at(order[: sizes.gpr_rows]), arm.train.at(order[: sizes.kernel_rows])
    centre, spread = arm.train.x.mean(0), arm.train.x.std(0)
    predicted = np.empty_like(arm.test.tau_nm)
    for joint, name in enumerate(JOINTS):
        say(f"GPR of scikit-learn, {name}")
        mean, level = some.tau_nm[:, joint].mean(), some.tau_nm[:, joint].std()
        kernel = ConstantKernel(1.0) * RBF(np.full(arm.train.x.shape[1], 4.0)) + WhiteKernel(0.1)
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # that a length scale has reached its bound
            found = GaussianProcessRegressor(kernel).fit(
                (few.x - centre) / spread, (few.tau_nm[:, joint] - mean) / level
            )
        learner = GaussianProcessRegressor(found.kernel_, optimizer=None)
        learner.fit((some.x - centre) / spread, (some.tau_nm[:, joint] - mean) / level)
        predicted[:, joint] = learner.predict((arm.test.x - centre) / spread) * level + mean
    return _single(arm.errors(predicted))


def table(scores: dict[str, Score]) -> Table:
    """Every learner, joint by joint."""
    shown = Table("learner", *(name.removeprefix("l_") for name in JOINTS), "mean", title="nMSE")
    for name, score in scores.items():
        cells = [
            f"{mean:.3f}" + (f" ±{sd:.3f}" if score.runs > 1 else "")
            for mean, sd in zip(score.mean, score.deviation, strict=True)
        ]
        shown.add_row(name, *cells, f"{score.mean.mean():.4f}")
    return shown


def rows_of(scores: dict[str, Score], *, short: bool) -> list[Row]:
    """Means over the joints, then each joint's error."""
    rows = []
    bars = (
        {}
        if short
        else {"semi-parametric 200": 0.025, "semi-parametric 200, CAD 10 % wrong": 0.035}
    )
    for name, score in scores.items():
        what = f"{name}, mean of {score.runs} runs" if score.runs > 1 else name
        value = float(score.mean.mean())
        bar = bars.get(name)
        rows.append(Row(what, value, "nMSE") if bar is None else at_most(what, value, "nMSE", bar))
    for name, score in scores.items():
        for joint, mean, sd in zip(JOINTS, score.mean, score.deviation, strict=True):
            spread = f"standard deviation {sd:.2g}" if score.runs > 1 else ""
            rows.append(Row(f"{name}: {joint}", float(mean), "nMSE", spread))
    rows += [
        Row(name, None, "", "not run: no implementation among the peers")
        for name in ("LWPR", "LGP")
    ]
    return rows


def force_fig6(
    *,
    runs: int = 25,
    short: bool = False,
    json: Path | None = None,
    plot: Path = Path("force-fig6.png"),
) -> int:
    """Figure 6 on made data: 0 when every bar holds."""
    from services.experiments.forces.learning_plots import draw_fig6

    console = Console()
    sizes = SHORT if short else Sizes()
    with Progress(
        SpinnerColumn(), TextColumn("{task.description}"), TimeElapsedColumn(), console=console
    ) as progress:
        shown = progress.add_task("making the data", total=None)

        def say(what: str) -> None:
            progress.update(shown, description=what)

        arm = made_arm(0, sizes.rollouts, sizes.rows, sizes.unseen, sizes.unseen_rows)
        scores = measure(arm, sizes, min(runs, 2) if short else runs, say)
        missing = []
        try:
            scores["GPR, scikit-learn"] = gaussian_process(arm, sizes, say)
        except ImportError as error:
            missing.append(Row("GPR, scikit-learn", None, "", f"not run: {error}"))
    draw_fig6({name: (s.mean, s.deviation) for name, s in scores.items()}, JOINTS, plot)
    console.print(table(scores))
    status = publish(
        "Figure 6: unseen motion of a made arm", [*rows_of(scores, short=short), *missing], json
    )
    console.print(f"plot: {plot}")
    return status
