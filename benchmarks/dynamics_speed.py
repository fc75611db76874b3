"""What one whole estimate costs, call to call from Python: ours, both ways, and idyntree's."""

from collections.abc import Callable, Sequence
from statistics import median

import numpy as np

from benchmarks.dynamics_scenes import FEET, LIMBS, Robot, Scene, robot, scene
from dforc.compiled import HAS_COMPILER
from dforc.estimation.assumption import Assumption, Contact, standing
from dforc.estimation.estimator import WholeBodyEstimator
from services.core.clock import RealClock
from services.experiments.rows import Row, at_least, at_most

ROUNDS = 300
TURN_US, WARM_CALLS = 300.0, 5
"""A turn is shorter than what the system leaves a process alone for; its first calls find the
caches as the others left them, and are not timed."""
SCENES = 32
ROBOTS = 64
PEER = "idyntree"
COMPILED_BAR, PLAIN_BAR, NESTED_BAR = 6.0, 1.2, 1.2
EMPTY = "empty call"
KNEES = tuple(Contact(frame=f"{side}_lower_leg") for side in "lr")

Call = Callable[[int], object]


def rows(rounds: int = ROUNDS) -> list[Row]:
    """Everything about time, medians of interleaved turns."""
    four, six = robot("iCubLisboa01", LIMBS), robot("iCubGazeboV2_5", (*LIMBS, *FEET))
    standing_six = Assumption(contacts=(*standing().contacts, *KNEES))
    calls: dict[str, Call] = {EMPTY: lambda _: None}
    missing: list[Row] = []
    for made, assumption in ((four, standing()), (six, standing_six)):
        calls |= _ours(made, assumption)
        missing += _add_peer(calls, made, assumption)
    spent = {name: median(values) for name, values in turns_us(calls, rounds).items()}
    found = [Row(f"{name}, median of {rounds} turns", us, "us") for name, us in spent.items()]
    return found + missing + _ratios(spent, (four, six)) + _fleet(four)


def turns_us(calls: dict[str, Call], rounds: int) -> dict[str, list[float]]:
    """Microseconds per call of each, over rounds in which each has a turn of the same length."""
    spent: dict[str, list[float]] = {name: [] for name in calls}
    counts = dict.fromkeys(calls, 20)
    for turn in range(rounds + 1):
        for name, call in calls.items():
            took_us = _turn_us(call, counts[name])
            if turn > 0:
                spent[name].append(took_us)
            else:
                counts[name] = max(1, min(1000, round(TURN_US / took_us)))
    return spent


def _turn_us(call: Call, count: int) -> float:
    clock = RealClock()
    for index in range(WARM_CALLS):
        call(index)
    begin_ns = clock.now_ns()
    for index in range(count):
        call(index)
    return (clock.now_ns() - begin_ns) / count / 1e3


def _label(what: str, made: Robot) -> str:
    return f"{what}, {made.tree.n} torques, {made.tree.m} FT"


def _scenes(made: Robot, assumption: Assumption) -> list[Scene]:
    rng = np.random.default_rng(2)
    return [scene(rng, made, assumption) for _ in range(SCENES)]


def _ours(made: Robot, assumption: Assumption) -> dict[str, Call]:
    scenes = _scenes(made, assumption)
    paths = {"compiled": True, "plain": False} if HAS_COMPILER else {"plain": False}
    return {
        _label(name, made): _call(WholeBodyEstimator(made.tree, assumption, compiled=way), scenes)
        for name, way in paths.items()
    }


def _call(estimator: WholeBodyEstimator, scenes: Sequence[Scene]) -> Call:
    """One estimate, with torques and wrenches read out."""

    def call(i: int) -> object:
        given = scenes[i % SCENES]
        found = estimator.estimate(given.q, given.dq, given.ddq, given.readings)
        return found.tau_nm, found.contact_wrenches

    return call


def _add_peer(calls: dict[str, Call], made: Robot, assumption: Assumption) -> list[Row]:
    """Both ways to hand over the numbers; a row that says so where it is not installed."""
    try:
        from benchmarks.dynamics_peer import Peer
    except ImportError as error:
        return [Row(_label(PEER, made), None, "us", f"{error}; pip install --group peers")]
    scenes = _scenes(made, assumption)
    peer = Peer(made.path, made.tree.joints, made.tree.sensors)
    peer.assume(assumption.contacts)

    def whole(load: Callable[..., None]) -> Call:
        def call(i: int) -> object:
            given = scenes[i % SCENES]
            load(given.q, given.dq, given.ddq, given.readings)
            peer.estimate()
            return peer.torques(), peer.wrenches()

        return call

    calls[_label(f"{PEER} by whole vectors", made)] = whole(peer.load)
    calls[_label(f"{PEER} number by number", made)] = whole(peer.load_one_by_one)
    return []


def _ratios(spent: dict[str, float], robots: tuple[Robot, Robot]) -> list[Row]:
    """How often our call fits into the peer's."""
    found = []
    for made in robots:
        peer = spent.get(_label(f"{PEER} by whole vectors", made))
        for way, bar in (("compiled", COMPILED_BAR), ("plain", PLAIN_BAR)):
            ours = spent.get(_label(way, made))
            if peer is not None and ours is not None:
                name = _label(f"{PEER} by whole vectors over {way}", made)
                found.append(at_least(name, peer / ours, "x", bar))
    four, six = (spent.get(_label("compiled", made)) for made in robots)
    if four is not None and six is not None:
        found.append(at_most("compiled, 6 FT (2 nested) over 4 FT", six / four, "x", NESTED_BAR))
    return found


def _fleet(made: Robot) -> list[Row]:
    """One estimate for each of many robots in turn: caches are cold, plans differ."""
    if not HAS_COMPILER:
        return []
    scenes = _scenes(made, standing())
    fleet = [_call(WholeBodyEstimator(made.tree, standing()), scenes) for _ in range(ROBOTS)]

    def sweep(i: int) -> None:
        for call in fleet:
            call(i)

    sweep_us = median(turns_us({"sweep": sweep}, 100)["sweep"])
    share = sweep_us * 100 / 1e6 * 100.0
    return [
        Row(f"one estimate for each of {ROBOTS} robots", sweep_us / 1e3, "ms"),
        Row(f"{ROBOTS} robots at 100 Hz", share, "% of a core", "no bar; 5 is the aim"),
    ]
