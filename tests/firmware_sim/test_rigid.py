"""Rigid bodies against dense algebra, and accelerometers against a moving arm worked out apart."""

from collections.abc import Sequence

import numpy as np
import pinocchio as pin
import pytest
from numpy.typing import NDArray

from dforc.robot_model import RobotModel
from firmware_sim.description import RigSpec
from firmware_sim.plants.rigid import Push, RigidBodies

Vector = NDArray[np.float64]

ARM = tuple(f"r_shoulder_{name}" for name in ("pitch", "roll", "yaw"))
JOINTS = ("r_elbow", "torso_yaw", *ARM, "l_knee", "torso_roll", "torso_pitch", "neck_yaw")
SENSORS = ("r_arm_ft_sensor", "l_arm_ft_sensor")


def bodies(spec: RigSpec, coupled: Sequence[tuple[int, int]] = ()) -> RigidBodies:
    return RigidBodies(spec.plant, JOINTS, SENSORS, coupled)


def model_of(spec: RigSpec, frame: str = "r_hand_dh_frame") -> RobotModel:
    return RobotModel(spec.plant.urdf, JOINTS, frame, {"ft": "r_arm_ft_sensor"})


def accelerate(
    rigid: RigidBodies, q: Vector, dq: Vector, tau: Vector, diagonal: Vector, off: Vector
) -> Vector:
    for row, values in zip(rigid.motion, (q, dq, tau, diagonal), strict=True):
        row[rigid.columns] = values
    return rigid.accelerate(off)[rigid.columns]


def feel(rigid: RigidBodies, q: Vector, dq: Vector, ddq: Vector) -> None:
    for row, values in zip(rigid.cut_motion, (q, dq, ddq), strict=True):
        row[rigid.cut_columns] = values
    rigid.feel()


def motion(seed: int = 5) -> tuple[Vector, Vector, Vector]:
    rng = np.random.default_rng(seed)
    q, dq, ddq = (rng.uniform(-1.0, 1.0, len(JOINTS)) for _ in range(3))
    return q, dq, ddq


def test_coupled_rotors_enter_as_a_full_block(exact_spec: RigSpec) -> None:
    t, rotor = 1.6455, np.diag([0.1, 0.1, 0.05])
    T = np.array([[1.0, 0.0, 0.0], [-t, t, 0.0], [-t, t, t]])
    block = T.T @ rotor @ T
    pairs = [(2, 3), (2, 4), (3, 4)]  # places of the shoulder in JOINTS
    diagonal = np.full(len(JOINTS), 0.02)
    diagonal[2:5] = block.diagonal()
    q, dq, tau = motion()
    off = np.array([block[0, 1], block[0, 2], block[1, 2]])
    ddq = accelerate(bodies(exact_spec, pairs), q, dq, 20.0 * tau, diagonal, off)

    model, still = model_of(exact_spec), np.zeros(len(JOINTS))
    gravity = model.gravity(q)
    M = np.array([model.rnea(q, still, unit) - gravity for unit in np.eye(len(JOINTS))])
    M += np.diag(diagonal)
    M[2:5, 2:5] = M[2:5, 2:5] - np.diag(block.diagonal()) + block
    dense = np.linalg.solve(M, 20.0 * tau - model.rnea(q, dq, still))
    assert ddq == pytest.approx(dense, rel=1e-8, abs=1e-8)


def test_without_couplings_the_answer_is_the_articulated_body_algorithms(
    exact_spec: RigSpec,
) -> None:
    rigid = bodies(exact_spec)
    q, dq, tau = motion()
    ddq = accelerate(rigid, q, dq, tau, np.full(len(JOINTS), 0.05), np.empty(0))
    q_all, dq_all, tau_all = (np.zeros(rigid._model.nv) for _ in range(3))
    q_all[rigid.columns], dq_all[rigid.columns], tau_all[rigid.columns] = q, dq, tau
    reference = pin.aba(rigid._model, rigid._model.createData(), q_all, dq_all, tau_all)
    assert ddq == pytest.approx(reference[rigid.columns], rel=1e-9)


def test_every_sensor_reads_its_own_limb(exact_spec: RigSpec) -> None:
    rigid = bodies(exact_spec)
    q, dq, ddq = motion()
    feel(rigid, q, dq, ddq)
    right = model_of(exact_spec).sensor_wrench(q, dq, ddq, "ft")
    assert rigid.wrenches[0] == pytest.approx(right, abs=1e-9)
    left = RobotModel(
        exact_spec.plant.urdf, JOINTS, "l_hand_dh_frame", {"ft": "l_arm_ft_sensor"}
    ).sensor_wrench(q, dq, ddq, "ft")
    assert rigid.wrenches[1] == pytest.approx(left, abs=1e-9)


def test_push_on_the_right_hand_is_not_felt_in_the_left_arm(exact_spec: RigSpec) -> None:
    rigid, (q, dq, ddq) = bodies(exact_spec), motion()
    feel(rigid, q, dq, ddq)
    before = rigid.wrenches.copy()
    hand = rigid.push_point("r_hand_dh_frame", (0.0, 0.0, 0.0))
    assert hand is not None
    _, wrench = rigid.pushed(q, Push(hand, np.array([0.0, 0.0, 9.0])))
    feel(rigid, q, dq, ddq)
    rigid.feel_push(hand, wrench)
    assert np.linalg.norm((rigid.wrenches - before)[0, :3]) == pytest.approx(9.0)
    assert rigid.wrenches[1].tolist() == before[1].tolist()


def test_accelerometer_at_rest_feels_gravity_upwards(exact_spec: RigSpec) -> None:
    rigid, still = bodies(exact_spec), np.zeros(len(JOINTS))
    points = rigid.inertial_points(["root_link", "r_hand_dh_frame"])
    feel(rigid, motion()[0], still, still)
    force, turn = points.read()
    assert force[0] == pytest.approx([0.0, 0.0, 9.81])
    assert np.linalg.norm(force[1]) == pytest.approx(9.81)
    assert np.abs(turn).max() == 0.0


def test_accelerometer_in_the_hand_feels_the_second_difference_of_its_place(
    exact_spec: RigSpec,
) -> None:
    rigid, model = bodies(exact_spec), model_of(exact_spec)
    points = rigid.inertial_points(["r_hand_dh_frame"])
    q, dq, ddq = motion()
    feel(rigid, q, dq, ddq)
    force, turn = points.read()
    h = 1e-4
    poses = [model.tip_pose(q + dq * t + 0.5 * ddq * t * t) for t in (-h, 0.0, h)]
    R = poses[1][0]
    acceleration = (poses[0][1] - 2.0 * poses[1][1] + poses[2][1]) / h**2
    assert force[0] == pytest.approx(R.T @ (acceleration + np.array([0.0, 0.0, 9.81])), abs=1e-4)
    assert turn[0] == pytest.approx(pin.log3(poses[0][0].T @ poses[2][0]) / (2 * h), abs=1e-5)


def test_orientation_turns_the_sensors_axes_into_the_bases(exact_spec: RigSpec) -> None:
    rigid, model, still = bodies(exact_spec), model_of(exact_spec), np.zeros(len(JOINTS))
    points = rigid.inertial_points(["r_hand_dh_frame"])
    q = motion()[0]
    feel(rigid, q, still, still)
    R, (w, x, y, z) = points.orientation(0, np.eye(3))
    assert pytest.approx(model.tip_pose(q)[0], abs=1e-9) == R
    assert pytest.approx(R, abs=1e-9) == pin.Quaternion(w, x, y, z).toRotationMatrix()
