"""Pushes anywhere: what the joints and every sensor on the way to the base feel of them."""

from collections.abc import Sequence

import numpy as np
import pytest
from numpy.typing import NDArray

from dforc.robot_model import RobotModel
from firmware_sim.description import PlantSpec
from firmware_sim.network import RigError
from firmware_sim.plants.rigid import Push, RigidBodies
from firmware_sim.pushes import Pushes
from services.config import load_robot
from services.robotfile.model_file import model_path

Vector = NDArray[np.float64]

LEG = tuple(f"l_{name}" for name in ("hip_pitch", "hip_roll", "hip_yaw", "knee"))
JOINTS = (*LEG, "l_ankle_pitch", "l_ankle_roll", "torso_yaw", "r_shoulder_roll", "r_elbow")
SENSORS = ("l_leg_ft_sensor", "l_foot_ft_sensor", "r_arm_ft_sensor")
URDF = str(model_path(load_robot("icub")))
FORCE_N = np.array([3.0, -20.0, 7.0])
POINT_M = (0.02, -0.05, 0.03)
REST: Vector = np.zeros(len(JOINTS))


@pytest.fixture
def rigid() -> RigidBodies:
    exact = PlantSpec(urdf=URDF, tip_frame="r_hand_dh_frame", seed=0, mass_error=0, com_error_m=0)
    return RigidBodies(exact, JOINTS, SENSORS)


def posture(seed: int = 3) -> Vector:
    return np.random.default_rng(seed).uniform(-0.6, 0.6, len(JOINTS))


def push(rigid: RigidBodies, frame: str) -> Push:
    point = rigid.push_point(frame, POINT_M)
    assert point is not None
    return Push(point, FORCE_N)


def felt(rigid: RigidBodies, q: Vector, pushes: Sequence[Push]) -> Vector:
    """What the sensors read more than without the pushes, the joints standing still."""
    for row, values in zip(rigid.cut_motion, (q, REST, REST), strict=True):
        row[rigid.cut_columns] = values
    rigid.feel()
    before = rigid.wrenches.copy()
    for one in pushes:
        rigid.feel_push(one.at, rigid.pushed(q, one)[1])
    return rigid.wrenches - before


@pytest.mark.parametrize("frame", ["l_lower_leg", "l_sole", "r_forearm", "l_knee"])
def test_joint_torques_are_the_work_of_the_force_on_the_point(
    rigid: RigidBodies, frame: str
) -> None:
    model, q = RobotModel(URDF, JOINTS, frame, {}), posture()

    def work(at: Vector) -> float:
        R, p = model.tip_pose(at)
        return float(FORCE_N @ (p + R @ np.array(POINT_M)))

    h = 1e-6
    slopes = [(work(q + h * unit) - work(q - h * unit)) / (2 * h) for unit in np.eye(len(q))]
    tau_nm, _ = rigid.pushed(q, push(rigid, frame))
    assert tau_nm == pytest.approx(slopes, abs=1e-6)
    assert np.abs(tau_nm).max() > 1.0


def test_push_under_the_foot_is_felt_by_both_sensors_of_the_leg(rigid: RigidBodies) -> None:
    q = posture()
    sensors = {"leg": "l_leg_ft_sensor", "foot": "l_foot_ft_sensor"}
    model = RobotModel(URDF, JOINTS, "l_sole", sensors)
    R_foot, origin = model.tip_pose(q)
    point = origin + R_foot @ np.array(POINT_M)
    wrenches = felt(rigid, q, [push(rigid, "l_sole")])
    for row, name in zip(wrenches, sensors, strict=False):
        R, p = model.sensor_pose(q, name)
        expected = np.concatenate([R.T @ FORCE_N, R.T @ np.cross(point - p, FORCE_N)])
        assert row == pytest.approx(expected, abs=1e-9)
    assert wrenches[2].tolist() == [0.0] * 6


@pytest.mark.parametrize(
    ("frame", "feels"),
    [
        ("l_lower_leg", (True, False, False)),  # beyond the leg's sensor, above the foot's
        ("l_hip_1", (False, False, False)),  # above both
        ("chest", (False, False, False)),
        ("r_hand", (False, False, True)),
        ("root_link", (False, False, False)),
    ],
)
def test_only_sensors_between_the_link_and_the_base_feel_it(
    rigid: RigidBodies, frame: str, feels: tuple[bool, ...]
) -> None:
    forces = np.linalg.norm(felt(rigid, posture(), [push(rigid, frame)])[:, :3], axis=1)
    expected = [float(np.linalg.norm(FORCE_N)) * feel for feel in feels]
    assert forces == pytest.approx(expected, abs=1e-9)


def test_pushes_at_two_links_add_up(rigid: RigidBodies) -> None:
    q = posture()
    hand, knee = push(rigid, "r_hand"), push(rigid, "l_lower_leg")
    both = felt(rigid, q, [hand, knee])
    assert both == pytest.approx(felt(rigid, q, [hand]) + felt(rigid, q, [knee]), abs=1e-12)


def test_pushes_last_their_time_each(rigid: RigidBodies) -> None:
    pushes = Pushes(rigid, "r_hand_dh_frame")
    pushes.begin((1.0, 0.0, 0.0), 0.002, "", (0.0, 0.0, 0.0))
    pushes.begin((0.0, 2.0, 0.0), 0.004, "l_knee", (0.0, 0.0, 0.0))
    assert [len(pushes.step()) for _ in range(5)] == [2, 2, 1, 1, 0]


def test_next_push_at_a_frame_takes_the_place_of_the_last(rigid: RigidBodies) -> None:
    pushes = Pushes(rigid, "r_hand_dh_frame")
    pushes.begin((1.0, 0.0, 0.0), 9.0, "", (0.0, 0.0, 0.0))
    pushes.begin((0.0, 2.0, 0.0), 0.001, "r_hand_dh_frame", (0.0, 0.0, 0.0))
    (only,) = pushes.step()
    assert only.force_n.tolist() == [0.0, 2.0, 0.0]
    assert pushes.step() == ()


def test_push_at_a_link_that_is_not_there_is_refused(rigid: RigidBodies) -> None:
    with pytest.raises(RigError, match="cannot push at 'tail': the model has no such link"):
        Pushes(rigid, "r_hand_dh_frame").begin((1.0, 0.0, 0.0), 1.0, "tail", (0.0, 0.0, 0.0))
