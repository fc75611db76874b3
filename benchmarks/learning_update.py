"""What one sample costs: ours, the papers' scheme, scikit-learn; one after the other in turns."""

from collections.abc import Callable
from statistics import median

import numpy as np

from benchmarks.learning_peers import CholeskyRidge, GradientDescent
from dforc.learning.random_features import RandomFeatures
from dforc.learning.recursive_ridge import HELD, RecursiveRidge, batch_weights
from services.core.clock import RealClock
from services.experiments.rows import Row, at_least, at_most

INPUTS, OUTPUTS, REGULARISATION = 12, 6, 1e-3
BATCH = 3000
TURNS = {200: (300, HELD), 500: (150, HELD), 1000: (60, HELD), 2000: (20, HELD)}
"""How many, and calls in each: one of ours in HELD does the writing of all, so it is among them."""
FIGURE_US = {200: 12.0, 500: 40.0, 1000: 120.0, 2000: 600.0}
RESTORE_BAR_MS = 20.0

PAPERS, DESCENT = PEERS = ("papers' scheme", "scikit-learn SGD")

Call = Callable[[int], object]


def turns_us(calls: dict[str, Call], rounds: int, count: int) -> dict[str, list[float]]:
    """Microseconds per call of each, over rounds in which each has its turn.

    A turn begins with calls that are not timed: the others have emptied the cache.
    """
    clock = RealClock()
    spent: dict[str, list[float]] = {name: [] for name in calls}
    for _ in range(rounds):
        for name, call in calls.items():
            for index in range(HELD):
                call(index)
            begin_ns = clock.now_ns()
            for index in range(count):
                call(index)
            spent[name].append((clock.now_ns() - begin_ns) / count / 1e3)
    return spent


def update_rows(sizes: tuple[int, ...] = tuple(TURNS)) -> list[Row]:
    """Updates at every size, with the ratio to the papers' scheme in the same turns."""
    return [row for size in sizes for row in _rows_of_size(size)]


def _rows_of_size(size: int) -> list[Row]:
    rng = np.random.default_rng(1)
    features = RandomFeatures(INPUTS, size, np.full(INPUTS, 3.0), 0)
    x = rng.standard_normal((BATCH, INPUTS))
    phi = features.features_of_rows(x)
    y = phi @ rng.standard_normal((size, OUTPUTS)) + 0.1 * rng.standard_normal((BATCH, OUTPUTS))
    ours = RecursiveRidge(size, OUTPUTS, REGULARISATION)
    ours.fit(phi, y)
    calls: dict[str, Call] = {
        "empty call": lambda _: None,
        "update": lambda i: ours.update(phi[i], y[i]),
        "features": lambda i: features.features(x[i]),
        "predict": lambda i: ours.predict(phi[i]),
    }
    missing = _add_peers(calls, phi, y)
    for call in calls.values():
        call(0)
    spent = turns_us(calls, *TURNS[size])
    rows = []
    for name, values in spent.items():
        bar = ""
        if name == "update":
            bar = f"about {FIGURE_US[size]:g} on a quiet machine; least {min(values):.3g}"
        rows.append(
            Row(f"D = {size}, {OUTPUTS} outputs: {name}, median", median(values), "us", bar)
        )
    rows += [Row(f"D = {size}: {name}", None, "", why) for name, why in missing.items()]
    for peer in [name for name in PEERS if name in spent]:
        ratio = median(spent[peer]) / median(spent["update"])
        name = f"D = {size}: {peer} over ours"
        rows.append(at_least(name, ratio, "x", 4.0) if peer == PAPERS else Row(name, ratio, "x"))
    if PAPERS in spent:
        rows.append(_agreement(phi, y, size))
    return rows


def _add_peers(calls: dict[str, Call], phi: np.ndarray, y: np.ndarray) -> dict[str, str]:
    """Add what is installed; what is not, and why."""
    missing = {}
    try:
        papers = CholeskyRidge(phi.shape[1], OUTPUTS, REGULARISATION)
        papers.fit(phi, y, REGULARISATION)
        calls[PAPERS] = lambda i: papers.update(phi[i], y[i])
    except ImportError as error:
        missing[PAPERS] = str(error)
    try:
        descent = GradientDescent(OUTPUTS)
        calls[DESCENT] = lambda i: descent.update(phi[i], y[i])
    except ImportError as error:
        missing[DESCENT] = f"{error}; pip install --group peers"
    return missing


def _agreement(phi: np.ndarray, y: np.ndarray, size: int) -> Row:
    """Both schemes from the same start over some samples, against the batch."""
    half, more = BATCH // 2, BATCH // 2 + 200
    ours = RecursiveRidge(size, OUTPUTS, REGULARISATION)
    papers = CholeskyRidge(size, OUTPUTS, REGULARISATION)
    ours.fit(phi[:half], y[:half])
    papers.fit(phi[:half], y[:half], REGULARISATION)
    for i in range(half, more):
        ours.update(phi[i], y[i])
        papers.update(phi[i], y[i])
    truth = batch_weights(phi[:more], y[:more], REGULARISATION)
    worst = max(float(np.abs(w - truth).max()) for w in (ours.weights, papers.weights))
    return at_most(f"D = {size}: either scheme against the batch", worst, "", 1e-6)


def kernel_ridge_rows() -> list[Row]:
    """scikit-learn's KernelRidge on 2000 rows: what learning by solving again costs."""
    from dforc.learning.kernel_ridge import KernelRidge

    rng = np.random.default_rng(2)
    x, y = rng.standard_normal((2000, INPUTS)), rng.standard_normal((2000, OUTPUTS))
    lengths = np.full(INPUTS, 3.0)
    ours = KernelRidge(lengths, 1e-3).fit(x, y)
    calls: dict[str, Call] = {
        "fit": lambda _: ours.fit(x, y),
        "predict": lambda i: ours.predict(x[i]),
    }
    rows = []
    try:
        from sklearn.kernel_ridge import KernelRidge as Peer

        peer = Peer(alpha=1e-3, kernel="rbf", gamma=0.5).fit(x / lengths, y)
        calls["scikit-learn fit"] = lambda _: peer.fit(x / lengths, y)
        calls["scikit-learn predict"] = lambda i: peer.predict(x[i : i + 1] / lengths)
        difference = float(np.abs(peer.predict(x / lengths) - ours.predict(x)).max())
        rows.append(at_most("KRR 2000: ours against scikit-learn", difference, "", 1e-8))
    except ImportError as error:
        rows.append(
            Row("scikit-learn KernelRidge", None, "", f"{error}; pip install --group peers")
        )
    for name, values in turns_us(calls, 3, 1).items():
        rows.append(Row(f"KRR 2000, {OUTPUTS} outputs: {name}, median", median(values), "us"))
    return rows


def snapshot_rows(size: int = 1000) -> list[Row]:
    """Save and restore at D = 1000."""
    features = RandomFeatures(INPUTS, size, np.full(INPUTS, 3.0), 0)
    rng = np.random.default_rng(3)
    learner = RecursiveRidge(size, OUTPUTS, REGULARISATION)
    phi = features.features_of_rows(rng.standard_normal((1200, INPUTS)))
    y = rng.standard_normal((1200, OUTPUTS))
    learner.fit(phi[:1000], y[:1000])
    state = learner.state()

    def both(_: int) -> None:
        learner.restore(learner.state())

    spent = turns_us({"both": both}, 15, 1)["both"]
    for i in range(1000, 1200):
        learner.update(phi[i], y[i])
    first = learner.weights
    learner.restore(state)
    for i in range(1000, 1200):
        learner.update(phi[i], y[i])
    same = np.array_equal(first, learner.weights)
    name = f"D = {size}: snapshot and restore together, median"
    return [
        at_most(name, median(spent) / 1e3, "ms", RESTORE_BAR_MS),
        Row("the same samples after a restore give the same bits", str(same), "", "True", same),
    ]
