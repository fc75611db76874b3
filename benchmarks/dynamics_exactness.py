"""The estimate against Newton and Euler by the book, and against idyntree where that is right."""

from collections.abc import Iterator
from typing import TYPE_CHECKING

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

if TYPE_CHECKING:
    from benchmarks.dynamics_peer import Peer

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


def largest(made: Robot, scenes: int, *, floating: bool) -> dict[str, Array]:
    """Largest errors of each path over random scenes."""
    rng = np.random.default_rng(20)
    paths = {"compiled": True, "plain": False} if HAS_COMPILER else {"plain": False}
    estimators = {
        name: WholeBodyEstimator(made.tree, Assumption(), compiled=way)
        for name, way in paths.items()
    }
    worst = {name: np.zeros(4) for name in paths}
    for _ in range(scenes):
        assumption = random_assumption(rng, made, floating=floating)
        true = scene(rng, made, assumption)
        imu = true.imu if floating else None
        for name, estimator in estimators.items():
            estimator.assume(assumption)
            found = estimator.estimate(true.q, true.dq, true.ddq, true.readings, None, imu)
            worst[name] = np.maximum(worst[name], errors(found, true))
    return worst


def rows(scenes: int = SCENES) -> list[Row]:
    """Torques [Nm] and everything else [N, Nm]: the largest error of each case."""
    found: list[Row] = []
    for name, made, floating in cases(scenes):
        for path, worst in largest(made, scenes, floating=floating).items():
            found.append(at_most(f"{path}: torque error, {name}", float(worst[0]), "Nm", BAR))
            rest = float(worst[1:].max())
            found.append(at_most(f"{path}: wrench error, {name}", rest, "N, Nm", BAR))
    return found + _peer_rows(scenes)


def _peer_rows(scenes: int) -> list[Row]:
    """One contact in each limb, where idyntree is right: both say the same."""
    try:
        from benchmarks.dynamics_peer import Peer
    except ImportError as error:
        return [Row("idyntree", None, "", f"{error}; pip install --group peers")]
    found = []
    for urdf, sensors in (("iCubLisboa01", LIMBS), ("iCubGazeboV2_5", (*LIMBS, *FEET))):
        made = robot(urdf, sensors)
        peer = Peer(made.path, made.tree.joints, sensors)
        tau, wrench = against_peer(made, peer, scenes)
        name = f"{urdf}, {len(sensors)} FT, fixed and floating ({6 * scenes} scenes)"
        found.append(at_most(f"torque, ours less idyntree's, {name}", tau, "Nm", BAR))
        found.append(at_most(f"wrench, ours less idyntree's, {name}", wrench, "N, Nm", BAR))
    return found


def against_peer(made: Robot, peer: "Peer", scenes: int) -> tuple[float, float]:
    """Largest differences of torques and of contact wrenches."""
    rng = np.random.default_rng(21)
    estimator = WholeBodyEstimator(made.tree, Assumption())
    limbs = sub_models(made)[1:]
    worst = [0.0, 0.0]
    kinds: tuple[Kind, ...] = ("wrench", "force", "direction")
    for kind in kinds * scenes:
        contacts = tuple(random_contact(rng, links, kind) for links in limbs)
        for source in ("", SOURCE):
            assumption = Assumption(contacts=contacts, source=source)
            estimator.assume(assumption)
            peer.assume(contacts)
            true = scene(rng, made, assumption)
            imu = true.imu if source else None
            found = estimator.estimate(true.q, true.dq, true.ddq, true.readings, None, imu)
            peer.load(true.q, true.dq, true.ddq, true.readings)
            if not peer.estimate(imu, source):
                raise RuntimeError("idyntree refused a tick")
            worst[0] = max(worst[0], float(np.abs(found.tau_nm - peer.torques()).max()))
            theirs = peer.wrenches_in_base(estimator.frame_pose)
            worst[1] = max(worst[1], float(np.abs(found.contact_wrenches - theirs).max()))
    return worst[0], worst[1]
