"""Torques, contacts, base and predicted readings against Newton and Euler by the book."""

from collections.abc import Callable

import numpy as np
import pinocchio as pin
import pytest

from benchmarks.dynamics_exactness import against_peer, largest, random_assumption
from benchmarks.dynamics_scenes import FEET, LIMBS, SOURCE, URDFS, Robot, scene
from benchmarks.newton_euler import UP, BaseState, Push
from dforc.estimation.assumption import Assumption, BaseMotion, Contact
from dforc.estimation.estimator import WholeBodyEstimator

SENSORS = ((), LIMBS, (*LIMBS, *FEET))
Load = Callable[[str, tuple[str, ...]], Robot]


@pytest.mark.parametrize("floating", [False, True], ids=["fixed", "floating"])
@pytest.mark.parametrize("sensors", SENSORS, ids=["0 FT", "4 FT", "6 FT"])
@pytest.mark.parametrize("urdf", URDFS)
def test_is_exact_for_contacts_of_every_kind_anywhere(
    load: Load, urdf: str, sensors: tuple[str, ...], floating: bool
) -> None:
    worst = largest(load(urdf, sensors), 1, floating=floating)
    assert {path: error for path, error in worst.items() if error.max() > 1e-9} == {}


def test_agrees_with_idyntree_where_that_is_right(icub: Robot) -> None:
    pytest.importorskip("idyntree")
    from benchmarks.dynamics_peer import Peer

    peer = Peer(icub.path, icub.tree.joints, LIMBS)
    assert max(against_peer(icub, peer, 1)) < 1e-9


def test_the_book_agrees_with_pinocchio_on_the_uncut_robot(icub: Robot) -> None:
    """The truth of these tests is held against a third party before it is believed."""
    model = pin.buildModelFromUrdf(icub.path, pin.JointModelFreeFlyer())
    data = model.createData()
    rng = np.random.default_rng(3)
    angles, dq, ddq = rng.uniform(-1.5, 1.5, (3, 32))
    names = list(model.names)[2:]
    omega, domega, acceleration = rng.normal(size=(3, 3))
    base = BaseState(omega, domega, acceleration + UP)
    force, moment, point = rng.normal(size=(3, 3))
    push = Push("l_hand", point, force, moment)
    motion = dict(zip(names, zip(angles, dq, ddq, strict=True), strict=True))
    truth = icub.truth.move(motion, [push], base)

    q = np.concatenate([pin.neutral(model)[:7], angles])
    v = np.concatenate([np.zeros(3), omega, dq])
    a = np.concatenate([acceleration, domega, ddq])
    hand = model.frames[model.getFrameId("l_hand")]
    on_joint = hand.placement.act(pin.Force(force, moment + np.cross(point, force)))
    pushes = [pin.Force.Zero() for _ in range(model.njoints)]
    pushes[hand.parentJoint] = on_joint
    tau = pin.rnea(model, data, q, v, a, pushes)
    assert [truth.torque(name) for name in names] == pytest.approx(tau[6:], abs=1e-9)
    assert truth.base_need() == pytest.approx(tau[:6], abs=1e-9)


def test_without_sensors_the_torques_are_those_of_plain_inverse_dynamics(
    load: Load, compiled: bool
) -> None:
    made = load("iCubLisboa01", ())
    contacts = (Contact(frame="l_hand"), Contact(frame="r_foot"))
    estimator = WholeBodyEstimator(made.tree, Assumption(contacts=contacts), compiled=compiled)
    model = made.tree.pin_model
    q, dq, ddq = np.random.default_rng(5).uniform(-1.0, 1.0, (3, 32))
    found = estimator.estimate(q, dq, ddq, np.zeros((0, 6)))
    given = np.zeros((3, 32))
    given[:, made.tree.columns] = q, dq, ddq
    expected = pin.rnea(model, model.createData(), *given)
    assert found.tau_nm == pytest.approx(expected[made.tree.columns], abs=1e-9)
    assert found.contact_wrenches == pytest.approx(0.0, abs=0.0)


def test_both_paths_give_the_same_numbers(load: Load) -> None:
    made = load("iCubGenova03", (*LIMBS, *FEET))
    pytest.importorskip("numba")
    ways = [WholeBodyEstimator(made.tree, Assumption(), compiled=way) for way in (True, False)]
    rng = np.random.default_rng(6)
    for floating in (False, True) * 8:
        assumption = random_assumption(rng, made, floating=floating)
        q, dq, ddq = rng.uniform(-1.5, 1.5, (3, made.tree.n))
        readings = rng.normal(size=(6, 6)) * 20.0  # contradicting: least squares, residuals
        valid = rng.uniform(size=6) > 0.3
        x, y, z, *rest = rng.uniform(-3.0, 3.0, 9).tolist()
        imu = BaseMotion(
            omega_rad_s=(x, y, z),
            domega_rad_s2=(rest[0], rest[1], rest[2]),
            acceleration_m_s2=(rest[3], rest[4], rest[5]),
        )
        for way in ways:
            way.assume(assumption)
        a, b = (
            way.estimate(q, dq, ddq, readings, valid, imu if floating else None).numbers
            for way in ways
        )
        assert np.abs(a - b).max() < 1e-12 * np.abs(a).max()


def test_prediction_is_the_internal_wrench_of_the_same_motion(icub: Robot, compiled: bool) -> None:
    rng = np.random.default_rng(7)
    contacts = (Contact(frame="l_hand"), Contact(frame="r_foot"))
    for source in ("", SOURCE):
        assumption = Assumption(contacts=contacts, source=source)
        estimator = WholeBodyEstimator(icub.tree, assumption, compiled=compiled)
        true = scene(rng, icub, assumption)
        imu = true.imu if source else None
        predicted = estimator.predict(true.q, true.dq, true.ddq, imu)
        assert predicted == pytest.approx(true.internal, abs=1e-9)
        assert (
            estimator.estimate(true.q, true.dq, true.ddq, true.readings, None, imu).internal
        ) == pytest.approx(predicted, abs=1e-12)
