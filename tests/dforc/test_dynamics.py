"""Torque estimate against pinocchio's inverse dynamics with a force on the hand."""

import icub_models
import numpy as np
import pinocchio as pin
import pytest

from dforc.arrays import Vector
from dforc.dynamics import (
    Estimate,
    NotAtRestError,
    OffsetSamples,
    TooFewSamplesError,
    TorqueEstimator,
    offset_of,
    spread_of,
)
from dforc.errors import NotFiniteError
from dforc.robot_model import RobotModel, load_model

SENSOR = "r_arm_ft"
FORCE_N = np.array([8.0, -12.0, 5.0])
MOMENT_NM = np.array([0.4, -0.2, 0.3])


@pytest.fixture
def estimator(model: RobotModel) -> TorqueEstimator:
    return TorqueEstimator(model, SENSOR)


def pushed_robot(
    model: RobotModel, q: Vector, dq: Vector, force: Vector, moment: Vector
) -> tuple[Vector, Vector]:
    """Drive torques and sensor reading of a robot whose hand is pushed, by pinocchio alone."""
    urdf = str(icub_models.get_model_file("iCubLisboa01"))
    plant = load_model(urdf, model.joints, ("r_arm_ft_sensor",))
    data = plant.createData()
    at = [plant.idx_vs[plant.getJointId(name)] for name in model.joints]
    q_all, v_all = np.zeros(plant.nq), np.zeros(plant.nv)
    q_all[at], v_all[at] = q, dq
    pin.forwardKinematics(plant, data, q_all)
    pin.updateFramePlacements(plant, data)
    hand = plant.getFrameId("r_hand_dh_frame")
    body = plant.frames[hand].parentJoint
    at_hand = pin.SE3(np.eye(3), data.oMf[hand].translation)
    forces = [pin.Force.Zero() for _ in range(plant.njoints)]
    forces[body] = data.oMi[body].actInv(at_hand.act(pin.Force(force, moment)))
    tau = pin.rnea(plant, data, q_all, v_all, np.zeros(plant.nv), forces)[at]
    reading = -data.f[plant.getJointId("r_arm_ft_sensor")].vector
    return tau, reading.copy()


def test_torques_and_push_are_exact(
    model: RobotModel, estimator: TorqueEstimator, postures: list[Vector]
) -> None:
    rng = np.random.default_rng(4)
    for q in postures[:20]:
        dq = rng.normal(size=10)
        tau, reading = pushed_robot(model, q, dq, FORCE_N, MOMENT_NM)
        estimate = estimator.estimate(q, dq, reading, np.zeros(6))
        assert estimate.tau_nm == pytest.approx(tau, abs=1e-9)
        assert estimate.force_n == pytest.approx(FORCE_N, abs=1e-9)
        assert estimate.moment_nm == pytest.approx(MOMENT_NM, abs=1e-9)


def test_weight_on_the_hand_makes_the_shoulder_lift_more(
    model: RobotModel, estimator: TorqueEstimator, home: Vector
) -> None:
    """Sign, by hand: 1 kg on the hand pulls down 0.3 m in front of the shoulder."""
    still = np.zeros(10)
    weight = np.array([0.0, 0.0, -9.81])
    _, reading = pushed_robot(model, home, still, weight, np.zeros(3))
    estimate = estimator.estimate(home, still, reading, np.zeros(6))
    added = estimate.tau_nm - model.gravity(home)
    J = model.tip_jacobian(home)
    assert added == pytest.approx(9.81 * J[2], abs=1e-9)  # drives raise what the weight lowers
    assert estimate.force_n[2] == pytest.approx(-9.81)


def test_limb_at_rest_without_contact_exerts_gravity_alone(
    model: RobotModel, estimator: TorqueEstimator, home: Vector
) -> None:
    still = np.zeros(10)
    _, reading = pushed_robot(model, home, still, np.zeros(3), np.zeros(3))
    alone = estimator.estimate(home, still, reading, np.zeros(6))
    assert alone.force_n == pytest.approx(np.zeros(3), abs=1e-9)
    assert alone.tau_nm == pytest.approx(estimator.gravity(home), abs=1e-9)


def test_offset_is_the_mean_excess_and_leaves_the_estimate(
    model: RobotModel, estimator: TorqueEstimator, home: Vector
) -> None:
    rng = np.random.default_rng(5)
    offset = np.array([1.5, -0.7, 0.3, 0.05, -0.02, 0.08])
    still, samples = np.zeros(10), OffsetSamples(wanted=400)
    _, clean = pushed_robot(model, home, still, np.zeros(3), np.zeros(3))
    noise = np.array([0.05] * 3 + [0.002] * 3)
    while not samples.complete:
        samples = estimator.add_sample(
            samples, home, still, clean + offset + rng.normal(size=6) * noise
        )
    found = offset_of(samples)
    assert found == pytest.approx(offset, abs=0.01)
    assert spread_of(samples) == pytest.approx(noise, rel=0.2)
    tau, reading = pushed_robot(model, home, still, FORCE_N, MOMENT_NM)
    estimate = estimator.estimate(home, still, reading + offset, found)
    assert estimate.tau_nm == pytest.approx(tau, abs=0.02)


@pytest.mark.parametrize("bad", [np.nan, np.inf])
def test_what_is_not_finite_enters_neither_estimate_nor_offset(
    estimator: TorqueEstimator, home: Vector, bad: float
) -> None:
    still, good = np.zeros(10), np.zeros(6)
    spoilt = good.copy()
    spoilt[4] = bad
    q = home.copy()
    q[2] = bad
    for arguments in (
        (q, still, good, good),
        (home, q, good, good),
        (home, still, spoilt, good),
        (home, still, good, spoilt),
    ):
        with pytest.raises(NotFiniteError):
            estimator.estimate(*arguments)
    with pytest.raises(NotFiniteError):
        estimator.add_sample(OffsetSamples(wanted=2), home, still, spoilt)
    with pytest.raises(NotFiniteError):
        estimator.gravity(q)


def test_moving_limb_is_not_calibrated(estimator: TorqueEstimator, home: Vector) -> None:
    moving = np.zeros(10)
    moving[6] = 0.1
    with pytest.raises(NotAtRestError, match=r"0\.100 rad/s"):
        estimator.add_sample(OffsetSamples(wanted=2), home, moving, np.zeros(6))


def test_offset_needs_all_its_samples(estimator: TorqueEstimator, home: Vector) -> None:
    samples = estimator.add_sample(OffsetSamples(wanted=2), home, np.zeros(10), np.zeros(6))
    assert not samples.complete
    with pytest.raises(TooFewSamplesError, match="1 samples of 2"):
        offset_of(samples)


def test_estimate_takes_what_messages_carry(estimator: TorqueEstimator, home: Vector) -> None:
    still, reading = (0.0,) * 10, (0.0,) * 6
    estimate: Estimate = estimator.estimate(tuple(home.tolist()), still, reading, reading)
    assert estimate.tau_nm.shape == (10,)
