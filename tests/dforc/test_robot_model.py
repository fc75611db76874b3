"""The model against hand calculation, finite differences and its own symmetries."""

from collections.abc import Callable
from pathlib import Path

import icub_models
import numpy as np
import pinocchio as pin
import pytest
from numpy.typing import NDArray

from dforc.robot_model import ModelError, RobotModel

Vector = NDArray[np.float64]

URDF = str(icub_models.get_model_file("iCubLisboa01"))
TORSO = ("torso_yaw", "torso_roll", "torso_pitch")
ARM = (
    "r_shoulder_pitch",
    "r_shoulder_roll",
    "r_shoulder_yaw",
    "r_elbow",
    "r_wrist_prosup",
    "r_wrist_pitch",
    "r_wrist_yaw",
)
JOINTS = TORSO + ARM
HOME = np.radians([0.0, 0.0, 0.0, -30.0, 30.0, 0.0, 45.0, 0.0, 0.0, 0.0])
GRAVITY_M_S2 = 9.81


@pytest.fixture(scope="module")
def model() -> RobotModel:
    return RobotModel(URDF, JOINTS, "r_hand_dh_frame", {"right_arm": "r_arm_ft_sensor"})


def posture(seed: int, model: RobotModel) -> tuple[Vector, Vector, Vector]:
    rng = np.random.default_rng(seed)
    q = rng.uniform(model.lower_rad, model.upper_rad)
    return q, rng.uniform(-2, 2, model.n), rng.uniform(-5, 5, model.n)


def test_limits_stand_in_the_order_of_the_names_handed_in(model: RobotModel) -> None:
    assert model.lower_rad[2] == pytest.approx(-0.383972)  # torso_pitch, first in the URDF
    assert model.upper_rad[2] == pytest.approx(1.46608)
    assert model.lower_rad[3] == pytest.approx(-1.65806)


def test_jacobian_is_the_derivative_of_the_tip_pose(model: RobotModel) -> None:
    q, _, _ = posture(1, model)
    J = model.tip_jacobian(q)
    step = 1e-6
    for i in range(model.n):
        ahead, behind = q.copy(), q.copy()
        ahead[i] += step
        behind[i] -= step
        (R1, p1), (R0, p0) = model.tip_pose(ahead), model.tip_pose(behind)
        assert J[:3, i] == pytest.approx((p1 - p0) / (2 * step), abs=1e-7)
        assert J[3:, i] == pytest.approx(pin.log3(R1 @ R0.T) / (2 * step), abs=1e-7)


def test_torques_move_with_the_order_of_the_joints(model: RobotModel) -> None:
    turned = RobotModel(URDF, JOINTS[::-1], "r_hand_dh_frame", {})
    q, dq, ddq = posture(2, model)
    assert turned.rnea(q[::-1], dq[::-1], ddq[::-1])[::-1] == pytest.approx(model.rnea(q, dq, ddq))


def test_gravity_is_inverse_dynamics_at_rest(model: RobotModel) -> None:
    q, _, _ = posture(3, model)
    still = np.zeros(model.n)
    assert model.gravity(q) == pytest.approx(model.rnea(q, still, still), abs=1e-12)


def test_gravity_is_the_slope_of_the_potential_energy(model: RobotModel) -> None:
    q, _, _ = posture(4, model)
    raw = pin.buildModelFromUrdf(URDF)
    data = raw.createData()
    at = [raw.idx_qs[raw.getJointId(name)] for name in JOINTS]

    def energy(values: Vector) -> float:
        whole = pin.neutral(raw)
        whole[at] = values
        return float(pin.computePotentialEnergy(raw, data, whole))

    assert model.gravity(q) == pytest.approx(slope(energy, q), abs=1e-6)


def slope(function: Callable[[Vector], float], q: Vector, step: float = 1e-5) -> Vector:
    out = np.zeros_like(q)
    for i in range(len(q)):
        ahead, behind = q.copy(), q.copy()
        ahead[i] += step
        behind[i] -= step
        out[i] = (function(ahead) - function(behind)) / (2 * step)
    return out


def test_sensor_at_rest_carries_the_weight_beyond_it(model: RobotModel) -> None:
    still = np.zeros(model.n)
    q, _, _ = posture(5, model)
    wrench = model.sensor_wrench(q, still, still, "right_arm")
    R, _ = model.sensor_pose(q, "right_arm")
    mass_kg = 0.729 + 0.074 + 0.525 + 0.213  # URDF: upper arm, elbow, forearm, hand
    assert R @ wrench[:3] == pytest.approx([0.0, 0.0, -mass_kg * GRAVITY_M_S2], abs=0.02)


def test_sensor_shows_the_force_of_acceleration(model: RobotModel) -> None:
    still = np.zeros(model.n)
    q, _, ddq = posture(6, model)
    resting = model.sensor_wrench(q, still, still, "right_arm")
    moving = model.sensor_wrench(q, still, ddq, "right_arm")
    opposite = model.sensor_wrench(q, still, -ddq, "right_arm")
    assert np.linalg.norm(moving - resting) > 0.5
    assert moving - resting == pytest.approx(resting - opposite, abs=1e-9)


def test_sensor_wrench_accounts_for_the_torque_of_the_joints_before_it(model: RobotModel) -> None:
    """Cutting the arm at the sensor leaves a rest whose torques differ by exactly that wrench."""
    q, dq, ddq = posture(7, model)
    tau, wrenches = model.inverse_dynamics(q, dq, ddq)
    R, p = model.sensor_pose(q, "right_arm")
    force, moment = R @ wrenches["right_arm"][:3], R @ wrenches["right_arm"][3:]
    tau_of_limb = -(cut_jacobian(q, p)[:3].T @ force + cut_jacobian(q, p)[3:].T @ moment)
    near = tau - tau_of_limb
    assert near[6:] == pytest.approx(tau[6:], abs=1e-12)  # the joints beyond are not touched by it
    assert near[:6] == pytest.approx(near_side_torque(q, dq, ddq)[:6], abs=1e-9)


def cut_jacobian(q: Vector, point_m: Vector) -> Vector:
    """Jacobian (6 x n) of the body before the sensor at a point in the base frame."""
    raw = pin.buildModelFromUrdf(URDF)
    data = raw.createData()
    whole = pin.neutral(raw)
    at = [raw.idx_qs[raw.getJointId(name)] for name in JOINTS]
    whole[at] = q
    joint = raw.getJointId("r_shoulder_yaw")
    pin.computeJointJacobians(raw, data, whole)
    J = pin.getJointJacobian(raw, data, joint, pin.LOCAL_WORLD_ALIGNED)[:, at]
    lever = point_m - data.oMi[joint].translation
    shifted: Vector = J.copy()
    shifted[:3] -= np.cross(lever, J[3:].T).T
    return shifted


def near_side_torque(q: Vector, dq: Vector, ddq: Vector) -> Vector:
    """Torques of the same robot with everything beyond the right arm's sensor weightless."""
    root = Path(URDF).read_text(encoding="utf-8")
    raw = pin.buildModelFromXML(without_inertia(root, "r_upper_arm"))
    for name in ("r_elbow", "r_wrist_prosup", "r_wrist_pitch", "r_wrist_yaw"):
        raw.inertias[raw.getJointId(name)] = pin.Inertia.Zero()
    data = raw.createData()
    at = [raw.idx_qs[raw.getJointId(name)] for name in JOINTS]
    vectors = []
    for values in (q, dq, ddq):
        whole = pin.neutral(raw)
        whole[at] = values
        vectors.append(whole)
    tau: Vector = pin.rnea(raw, data, *vectors)[at]
    return tau


def without_inertia(urdf: str, link: str) -> str:
    head, _, tail = urdf.partition(f'<link name="{link}">')
    start, end = tail.index("<inertial>"), tail.index("</inertial>") + len("</inertial>")
    return f'{head}<link name="{link}">{tail[:start]}{tail[end:]}'


def test_chain_description_rebuilds_the_tip_pose(model: RobotModel) -> None:
    q, _, _ = posture(8, model)
    T = np.eye(4)
    chain = model.chain_description()
    for number, element in enumerate(chain):
        step = np.eye(4)
        angle = q[element.joint] if element.joint >= 0 else 0.0
        step[:3, :3] = element.R @ pin.exp3(element.axis * angle)
        step[:3, 3] = element.p
        T = T @ step
        assert element.parent == number - 1
    R, p = model.tip_pose(q)
    assert len(chain) == model.n + 1
    assert T[:3, :3] == pytest.approx(R, abs=1e-12)
    assert T[:3, 3] == pytest.approx(p, abs=1e-12)


def test_results_are_not_changed_by_the_next_call(model: RobotModel) -> None:
    q, dq, ddq = posture(9, model)
    first = model.sensor_wrench(q, dq, ddq, "right_arm"), *model.tip_pose(q), model.gravity(q)
    kept = [values.copy() for values in first]
    model.sensor_wrench(q + 0.1, dq, ddq, "right_arm")
    model.tip_pose(q + 0.1)
    model.gravity(q + 0.1)
    for values, copy in zip(first, kept, strict=True):
        assert np.array_equal(values, copy)


def test_joint_positions_hold_the_shoulder_where_the_urdf_puts_it(model: RobotModel) -> None:
    positions = model.joint_positions(HOME)
    raw = pin.buildModelFromUrdf(URDF)
    data = raw.createData()
    whole = pin.neutral(raw)
    for name, angle in zip(JOINTS, HOME, strict=True):
        whole[raw.idx_qs[raw.getJointId(name)]] = angle
    pin.forwardKinematics(raw, data, whole)
    for i, name in enumerate(JOINTS):
        assert positions[i] == pytest.approx(data.oMi[raw.getJointId(name)].translation, abs=1e-12)


@pytest.mark.parametrize(
    ("joints", "tip", "sensor", "named"),
    [
        (("r_elbw",), "r_hand", "r_arm_ft_sensor", "r_elbow"),
        (("r_elbow",), "r_paw", "r_arm_ft_sensor", "r_paw"),
        (("r_elbow",), "r_hand", "r_arm_sensor", "r_arm_ft_sensor"),
    ],
)
def test_wrong_name_is_refused_with_what_there_is(
    joints: tuple[str, ...], tip: str, sensor: str, named: str
) -> None:
    with pytest.raises(ModelError, match=named):
        RobotModel(URDF, joints, tip, {"arm": sensor})


def test_missing_file_is_refused_with_its_path() -> None:
    with pytest.raises(ModelError, match="no/such"):
        RobotModel("no/such.urdf", ("r_elbow",), "r_hand", {})
