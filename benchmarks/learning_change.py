"""A load of 0.3 kg in the recorded hand for 70 s: who notices, how fast, and what is left behind.

The load is added to the recording by the model's regressor: a point mass in the hand. A learner
that knows of the grasp looks for the four parameters of a load, its mass and its lever, and lets
its features wait meanwhile; the others are left to themselves. Beside each runs the same learner
on the recording as it is: the error of the one over that of the other is what the load costs.
"""

from collections.abc import Callable

import numpy as np

from dforc.arrays import Matrix, Vector
from dforc.learning.feature_ridge import FeatureRidge
from dforc.learning.semi_parametric import RigidParameters, SemiParametric
from services.experiments.forces.arm_learning import (
    MODEL_NOISE,
    ArmTask,
    features_only,
    identified,
    kernels_of,
    predict_then_update,
    rest_kernels,
)
from services.experiments.rows import Row, at_most

MASS_KG = 0.3
CENTRE_M = np.array([0.02, 0.0, -0.25])  # of the load, in the frame of the elbow
TAKEN, PUT_DOWN = 2000, 4000  # rows
SETTLING_ROWS = 100  # in which the load is found
WINDOW_ROWS = 50
BACK_BAR, BACK_WITHIN_ROWS, REVISIT_BAR = 1.2, 300.0, 2.0
LOAD = slice(10, 14)  # mass and lever of the forearm, among the regressor's columns
SPREAD = (1.0, 0.3, 0.3, 0.3)  # kg, kg m


def change_rows(task: ArmTask, say: Callable[[str], None]) -> list[Row]:
    """RFRR, the semi-parametric form, and the same with a load that it knows it has taken."""
    loaded = _with_load(task)
    kernels = kernels_of(task)
    rigid = identified(task)
    rest = rest_kernels(task, rigid, kernels)
    say("RFRR 200")
    errors = [_features(task, FeatureRidge(kernels, 200, 0), y) for y in (task.test.y, loaded)]
    rows = _rows(task, "RFRR 200, not told", *errors, bars=False)
    say("semi-parametric")
    both = SemiParametric(rigid, FeatureRidge(rest, 200, 0))
    twin = _semi_parametric(task, both, task.test.y, told=False)
    errors = [_semi_parametric(task, both, loaded, told=told) for told in (False, True)]
    rows += _rows(task, "semi-parametric 200, not told", twin, errors[0], bars=False)
    return rows + _rows(task, "semi-parametric 200, told of the grasp", twin, errors[1], bars=True)


def _with_load(task: ArmTask) -> Matrix:
    """The test's wrenches with the load in the hand for a while."""
    c = CENTRE_M
    inertia = MASS_KG * (c @ c * np.eye(3) - np.outer(c, c))
    body = np.r_[MASS_KG, MASS_KG * c, inertia[np.tril_indices(3)]]
    y = task.test.y.copy()
    y[TAKEN:PUT_DOWN] += task.test.regressors[TAKEN:PUT_DOWN, :, 10:20] @ body
    return y


def _features(task: ArmTask, learner: FeatureRidge, y: Matrix) -> Matrix:
    learner.fit(task.train.x, task.train.y)
    return features_only(task, learner, y=y)


def _semi_parametric(task: ArmTask, learner: SemiParametric, y: Matrix, *, told: bool) -> Matrix:
    x, regressors = task.test.x, task.test.regressors
    learner.fit(task.train.x, task.train.regressors, task.train.y)
    load = RigidParameters(np.zeros(4), SPREAD, MODEL_NOISE)

    def carried(i: int) -> Vector:
        if not told or not TAKEN <= i < PUT_DOWN:
            return np.zeros(6)
        wrench: Vector = regressors[i][:, LOAD] @ load.theta
        return wrench

    def update(i: int) -> None:
        if told and TAKEN <= i < TAKEN + SETTLING_ROWS:
            left = y[i] - learner.predict(x[i], regressors[i])
            load.add(regressors[i : i + 1, :, LOAD], left[None])
            load.solve()
        else:
            learner.update(x[i], regressors[i], y[i] - carried(i))

    return predict_then_update(
        lambda i: learner.predict(x[i], regressors[i]) + carried(i), update, y
    )


def _rows(task: ArmTask, name: str, twin: Matrix, errors: Matrix, *, bars: bool) -> list[Row]:
    ratio = _windowed(errors) / _windowed(twin)
    above = np.flatnonzero(ratio[TAKEN:PUT_DOWN] > BACK_BAR)
    settled = np.flatnonzero(ratio[TAKEN + WINDOW_ROWS : PUT_DOWN] <= BACK_BAR)
    first = float(settled[0] + WINDOW_ROWS) if len(settled) else float(PUT_DOWN - TAKEN)
    share = 100.0 * len(above[above >= first]) / (PUT_DOWN - TAKEN)
    during = task.error(errors[TAKEN + 300 : PUT_DOWN]) / task.error(twin[TAKEN + 300 : PUT_DOWN])
    after = task.error(errors[PUT_DOWN:]) / task.error(twin[PUT_DOWN:])
    back = f"{name}: rows until the error is {BACK_BAR:g} of that without the load"
    revisit = f"{name}: nMSE after it is put down, over that without"
    return [
        at_most(back, first, "rows", BACK_WITHIN_ROWS) if bars else Row(back, first, "rows"),
        Row(f"{name}: rows above that later", share, "%"),
        Row(f"{name}: nMSE with the load, after 300 rows, over that without", during, "x"),
        at_most(revisit, after, "x", REVISIT_BAR) if bars else Row(revisit, after, "x"),
    ]


def _windowed(errors: Matrix) -> Vector:
    """Root of the mean square force error over the last rows."""
    squares = np.cumsum((errors[:, :3] ** 2).sum(1))
    squares[WINDOW_ROWS:] = squares[WINDOW_ROWS:] - squares[:-WINDOW_ROWS]
    counts = np.minimum(np.arange(1, len(errors) + 1), WINDOW_ROWS)
    level: Vector = np.sqrt(squares / counts)
    return level
