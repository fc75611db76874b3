"""The estimate against Newton and Euler by the book, and against idyntree where that is right."""

from collections.abc import Iterator

import numpy as np

from benchmarks.dynamics_scenes import (
    FEET,
    LIMBS,
    SOURCE,
    URDFS,
    Robot,
    Scene,
    random_contact,
    robot,
    scene,
    sub_models,
)
from benchmarks.newton_euler import Array
from dforc.compiled import HAS_COMPILER
from dforc.estimation.assumption import Assumption, Contact, Kind
from dforc.estimation.estimate import BodyEstimate
from dforc.estimation.estimator import WholeBodyEstimator
from services.experiments.rows import Row, at_most

BAR = 1e-9
SCENES = 12
KINDS: tuple[tuple[Kind, ...], ...] = (
    ("wrench",),
    ("force",),
    ("direction",),
    ("force", "direction"),
    ("direction", "direction", "direction"),
    (),
)


def random_assumption(rng: np.random.Generator, robot: Robot, *, floating: bool) -> Assumption:
    """Contacts of every kind anywhere, as many as can be told apart in each sub-model."""
    contacts: list[Contact] = []
    for index, links in enumerate(sub_models(robot)):
        held = index == 0 and not floating
        kinds = () if held else KINDS[rng.integers(len(KINDS))]
        contacts += [random_contact(rng, links, kind) for kind in kinds]
    return Assumption(
        contacts=tuple(contacts), source=SOURCE if floating else "", mainstay=not floating
    )


def errors(found: BodyEstimate, true: Scene) -> Array:
    """Largest differences: torques, wrenches of contacts and base, predicted readings, residual."""
    base = found.base_wrench - true.base
    return np.array(
        [
            np.abs(found.tau_nm - true.tau).max(),
            max(
                np.abs(found.contact_wrenches - true.wrenches).max(initial=0.0), np.abs(base).max()
            ),
            np.abs(found.internal - true.internal).max(initial=0.0),
            np.abs(found.residuals[:, :6]).max(),
        ]
    )


def cases(scenes: int) -> Iterator[tuple[str, Robot, bool]]:
    """Every model, base and set of sensors."""
    for urdf in URDFS:
        for sensors in ((), LIMBS, (*LIMBS, *FEET)):
            made = robot(urdf, sensors)
            for floating in (False, True):
                base = "floating" if floating else "fixed"
                yield f"{urdf}, {len(sensors)} FT, {base} ({scenes} scenes)", made, floating


def largest(made: Robot, estimator: WholeBodyEstimator, scenes: int, *, floating: bool) -> Array:
    """Largest errors over random scenes."""
    rng = np.random.default_rng(20)
    worst = np.zeros(4)
    for _ in range(scenes):
        assumption = random_assumption(rng, made, floating=floating)
        true = scene(rng, made, assumption)
        estimator.assume(assumption)
        imu = true.imu if floating else None
        found = estimator.estimate(true.q, true.dq, true.ddq, true.readings, None, imu)
        worst = np.maximum(worst, errors(found, true))
    return worst


def rows(scenes: int = SCENES) -> list[Row]:
    """Torques [Nm], wrenches [N, Nm] and predicted readings: the largest error of each case."""
    found: list[Row] = []
    for compiled in (True, False) if HAS_COMPILER else (False,):
        path = "compiled" if compiled else "plain"
        for name, made, floating in cases(scenes):
            estimator = WholeBodyEstimator(made.tree, Assumption(), compiled=compiled)
            tau, wrench, internal, residual = largest(
                made, estimator, scenes, floating=floating
            ).tolist()
            found.append(at_most(f"{path}: torque error, {name}", tau, "Nm", BAR))
            worst = max(wrench, internal, residual)
            found.append(at_most(f"{path}: wrench error, {name}", worst, "N, Nm", BAR))
    return found
