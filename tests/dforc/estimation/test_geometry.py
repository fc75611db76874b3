"""Poses, Jacobians and the centre of mass, against pinocchio and finite differences."""

from collections.abc import Callable

import numpy as np
import pinocchio as pin
import pytest

from benchmarks.dynamics_scenes import Robot, scene
from dforc.estimation.assumption import Assumption, standing
from dforc.estimation.estimator import WholeBodyEstimator

Make = Callable[[Assumption], WholeBodyEstimator]
STEP_RAD = 1e-6


def test_frames_stand_where_the_book_puts_them(icub: Robot, make: Make) -> None:
    estimator = make(standing())
    true = scene(np.random.default_rng(1), icub, standing())
    estimator.estimate(true.q, true.dq, true.ddq, true.readings)
    motion = dict(zip(icub.tree.joints, ((q, 0.0, 0.0) for q in true.q), strict=True))
    states = icub.truth.move(motion).states
    for link in icub.tree.links:
        R, p = estimator.frame_pose(link)
        assert pytest.approx(states[link].R, abs=1e-12) == R
        assert p == pytest.approx(states[link].p, abs=1e-12)


def test_jacobian_is_what_a_small_step_of_each_joint_does(icub: Robot, make: Make) -> None:
    estimator = make(standing())
    true = scene(np.random.default_rng(2), icub, standing())
    point = (0.03, -0.02, 0.1)

    def at(q: np.ndarray) -> np.ndarray:
        estimator.estimate(q, true.dq, true.ddq, true.readings)
        R, p = estimator.frame_pose("l_hand")
        moved: np.ndarray = p + R @ np.array(point)
        return moved

    at(true.q)
    J = estimator.jacobian("l_hand", point)
    for joint, step in enumerate(np.eye(32) * STEP_RAD):
        change = (at(true.q + step) - at(true.q - step)) / (2.0 * STEP_RAD)
        assert J[:3, joint] == pytest.approx(change, abs=1e-8)
    axis = icub.tree.joints.index("torso_yaw")
    assert np.linalg.norm(J[3:, axis]) == pytest.approx(1.0)
    assert np.count_nonzero(J[3:].any(axis=0)) == 10  # three of the torso, seven of the arm


def test_virtual_work_of_the_contacts_is_in_the_torques(icub: Robot, make: Make) -> None:
    """The torques of two estimates that differ by one push differ by J' of it."""
    estimator = make(standing())
    true = scene(np.random.default_rng(3), icub, standing())
    found = estimator.estimate(true.q, true.dq, true.ddq, true.readings)
    calm = estimator.estimate(true.q, true.dq, true.ddq, true.internal)
    works = [
        estimator.jacobian(contact.frame).T @ wrench
        for contact, wrench in zip(standing().contacts, found.contact_wrenches, strict=True)
    ]
    assert found.tau_nm == pytest.approx(calm.tau_nm - sum(works), abs=1e-9)


def test_centre_of_mass_and_its_jacobian_are_pinocchios(icub: Robot, make: Make) -> None:
    model = pin.buildModelFromUrdf(icub.path, pin.JointModelFreeFlyer())
    data = model.createData()
    names = list(model.names)[2:]
    q = np.random.default_rng(4).uniform(-1.0, 1.0, 32)
    placed = np.concatenate(
        [pin.neutral(model)[:7], [q[icub.tree.joints.index(name)] for name in names]]
    )
    estimator = make(standing())
    expected = pin.centerOfMass(model, data, placed)
    assert estimator.centre_of_mass(q) == pytest.approx(expected, abs=1e-12)
    J = pin.jacobianCenterOfMass(model, data, placed)[:, 6:]
    columns = [names.index(name) for name in icub.tree.joints]
    assert estimator.centre_of_mass_jacobian(q) == pytest.approx(J[:, columns], abs=1e-12)


def test_gravity_torques_are_the_slope_of_the_height_of_the_mass(icub: Robot, make: Make) -> None:
    estimator = make(standing())
    q = np.random.default_rng(5).uniform(-1.0, 1.0, 32)
    weight_n = 9.81 * float(icub.tree.mass.sum())
    lifted = weight_n * estimator.centre_of_mass_jacobian(q)[2]
    assert estimator.gravity(q) == pytest.approx(lifted, abs=1e-9)
