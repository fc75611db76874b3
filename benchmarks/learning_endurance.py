"""A million updates: does the recursion stay with the batch, and P positive definite?"""

from collections.abc import Callable

import numpy as np

from dforc.learning.random_features import RandomFeatures
from dforc.learning.recursive_ridge import RecursiveRidge
from services.core.clock import RealClock
from services.experiments.rows import Row, at_most

INPUTS, OUTPUTS, REGULARISATION = 12, 6, 1e-3
CHUNK = 10_000


def endurance_rows(updates: int, size: int, say: Callable[[str], None]) -> list[Row]:
    """Difference to the batch of the same samples, in units of the weights' own size."""
    rng = np.random.default_rng(4)
    features = RandomFeatures(INPUTS, size, np.full(INPUTS, 3.0), 0)
    learner = RecursiveRidge(size, OUTPUTS, REGULARISATION)
    truth = rng.standard_normal((size, OUTPUTS))
    A, moment = REGULARISATION * np.eye(size), np.zeros((size, OUTPUTS))
    clock = RealClock()
    spent_ns = 0
    indefinite = 0
    for start in range(0, updates, CHUNK):
        count = min(CHUNK, updates - start)
        # a slow walk through the inputs, as a motion is, and never the same twice
        x = np.cumsum(0.05 * rng.standard_normal((count, INPUTS)), 0) + rng.standard_normal(INPUTS)
        phi = features.features_of_rows(x)
        y = phi @ truth + 0.1 * rng.standard_normal((count, OUTPUTS))
        A += phi.T @ phi
        moment += phi.T @ y
        begin_ns = clock.now_ns()
        for i in range(count):
            learner.update(phi[i], y[i])
        spent_ns += clock.now_ns() - begin_ns
        indefinite += not learner.definite()
        if start % (10 * CHUNK) == 0:
            say(f"{start + count} updates of {updates}")
    batch = np.linalg.solve(A, moment)
    worst = float(np.abs(learner.weights - batch).max() / np.abs(batch).std())
    name = f"{updates} updates at D = {size}"
    return [
        at_most(f"{name}: against the batch", worst, "of a weight", 1e-6),
        at_most(f"{name}: times P was not positive definite", float(indefinite), "", 0.0),
        Row(f"{name}: mean", spent_ns / updates / 1e3, "us"),
    ]
