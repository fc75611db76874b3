"""CasADi kinematics against pinocchio and against finite differences."""

import casadi as ca
import icub_models
import numpy as np
import pytest

from dforc.arrays import Vector
from dforc.ik.kernel_chain import rotation_onto
from dforc.robot_model import RobotModel
from dforc.rotation import rotation_error
from dforc.symbolic.kinematics import symbolic_chain

STEP_RAD = 1e-6


def forward_kinematics(model: RobotModel) -> ca.Function:
    """q (n) -> rotation (3, 3), position (3), geometric Jacobian (6, n)."""
    s = symbolic_chain(model.chain_description(), model.n)
    return ca.Function("f", [s.q], [s.rotation, s.position, ca.vertcat(s.linear, s.axes)])


def test_pose_and_jacobian_are_those_of_the_model(
    model: RobotModel, postures: list[Vector]
) -> None:
    function = forward_kinematics(model)
    for q in postures:
        rotation, position, jacobian = (np.array(value) for value in function(q))
        R, p = model.tip_pose(q)
        assert rotation == pytest.approx(R, abs=1e-12)
        assert position[:, 0] == pytest.approx(p, abs=1e-12)
        assert jacobian == pytest.approx(model.tip_jacobian(q), abs=1e-12)


def test_jacobian_is_the_derivative_of_the_pose(model: RobotModel, postures: list[Vector]) -> None:
    function = forward_kinematics(model)
    q = postures[0]
    _, _, J = (np.array(value) for value in function(q))
    for i in range(model.n):
        turn = np.zeros(model.n)
        turn[i] = STEP_RAD
        (R1, p1), (R0, p0) = (
            tuple(np.array(value) for value in function(q + sign * turn)[:2]) for sign in (1, -1)
        )
        assert J[:3, i] == pytest.approx((p1 - p0)[:, 0] / (2 * STEP_RAD), abs=1e-8)
        assert J[3:, i] == pytest.approx(rotation_error(R0, R1) / (2 * STEP_RAD), abs=1e-8)


def test_joints_beside_the_chain_have_no_part_in_it() -> None:
    urdf = str(icub_models.get_model_file("iCubLisboa01"))
    both = RobotModel(urdf, ("neck_pitch", "r_elbow", "r_wrist_yaw"), "r_hand_dh_frame", {})
    chain = symbolic_chain(both.chain_description(), both.n)
    assert chain.order == (1, 2)
    function = forward_kinematics(both)
    q = np.array([0.2, 0.9, 0.1])
    assert np.array(function(q)[2])[:, 0] == pytest.approx(np.zeros(6))
    assert np.array(function(q)[1])[:, 0] == pytest.approx(both.tip_pose(q)[1], abs=1e-12)


def test_frame_onto_an_axis_is_a_rotation() -> None:
    rng = np.random.default_rng(2)
    for axis in [*rng.normal(size=(10, 3)), np.array([0.0, 0.0, -1.0])]:
        unit = axis / np.linalg.norm(axis)
        frame = rotation_onto(unit)
        assert frame[:, 2] == pytest.approx(unit)
        assert frame.T @ frame == pytest.approx(np.eye(3), abs=1e-14)
        assert np.linalg.det(frame) == pytest.approx(1.0)
