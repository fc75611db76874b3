"""Signs and sizes that can be worked out on paper: one arm of 2 kg that hangs from a hinge.

The hinge turns about y; 0.2 m below it is the sensor, 0.5 m below it the centre of mass, 0.7 m
below it the hand. All axes are the base's when the arm hangs: x forwards, z up.
"""

from pathlib import Path

import numpy as np
import pytest

from dforc.estimation.assumption import Assumption, BaseMotion, Contact, KnownWrench
from dforc.estimation.estimator import WholeBodyEstimator
from dforc.estimation.tree_model import TreeModel
from dforc.robot_model import ModelError

URDF = """<robot name="arm">
<link name="base"/>
<link name="upper"/>
<link name="lower"><inertial><origin xyz="0 0 -0.3"/><mass value="2"/>
<inertia ixx="0" ixy="0" ixz="0" iyy="0" iyz="0" izz="0"/></inertial></link>
<link name="hand"/>
<joint name="hinge" type="revolute"><parent link="base"/><child link="upper"/>
<axis xyz="0 1 0"/><limit lower="-3" upper="3" effort="0" velocity="0"/></joint>
<joint name="ft" type="fixed"><parent link="upper"/><child link="lower"/>
<origin xyz="0 0 -0.2"/></joint>
<joint name="palm" type="fixed"><parent link="lower"/><child link="hand"/>
<origin xyz="0 0 -0.5"/></joint>
</robot>"""
WEIGHT_N = 2.0 * 9.81
ZERO = np.zeros(1)


@pytest.fixture
def arm(tmp_path: Path) -> TreeModel:
    path = tmp_path / "arm.urdf"
    path.write_text(URDF)
    return TreeModel.from_urdf(str(path), ("hinge",), {"ft": "ft"})


@pytest.fixture
def estimator(arm: TreeModel, compiled: bool) -> WholeBodyEstimator:
    return WholeBodyEstimator(arm, Assumption(contacts=(Contact(frame="hand"),)), compiled=compiled)


def test_hanging_arm_pulls_the_sensor_down(estimator: WholeBodyEstimator) -> None:
    predicted = estimator.predict(ZERO, ZERO, ZERO)
    assert predicted[0] == pytest.approx([0.0, 0.0, -WEIGHT_N, 0.0, 0.0, 0.0], abs=1e-12)


def test_arm_held_out_in_front_needs_half_its_weight_in_torque(
    estimator: WholeBodyEstimator,
) -> None:
    """A quarter turn about -y brings the mass to x = +0.5 m: gravity turns about +y, the drive
    about -y."""
    assert estimator.gravity(np.array([-np.pi / 2])) == pytest.approx([-0.5 * WEIGHT_N])


def test_push_of_ten_newtons_forwards_is_found_at_the_hand(
    estimator: WholeBodyEstimator,
) -> None:
    reading = np.array([[10.0, 0.0, -WEIGHT_N, 0.0, -5.0, 0.0]])
    found = estimator.estimate(ZERO, ZERO, ZERO, reading)
    assert found.contact_wrenches[0] == pytest.approx([10.0, 0, 0, 0, 0, 0], abs=1e-12)
    assert found.contact_points_m[0] == pytest.approx([0.0, 0.0, -0.7])
    assert found.tau_nm == pytest.approx([7.0])  # the push turns the hinge about -y
    assert found.base_wrench == pytest.approx([-10.0, 0.0, WEIGHT_N, 0.0, 7.0, 0.0], abs=1e-12)


def test_accelerating_hinge_feels_the_mass_at_its_lever(estimator: WholeBodyEstimator) -> None:
    """2 kg at 0.5 m: 0.5 kgm2, and -x m/s2 of 1.5 at the mass."""
    tau = estimator.estimate(
        ZERO, ZERO, np.array([3.0]), estimator.predict(ZERO, ZERO, np.array([3.0]))
    ).tau_nm
    assert tau == pytest.approx([1.5])
    assert estimator.predict(ZERO, ZERO, np.array([3.0]))[0, 0] == pytest.approx(3.0)


def test_turning_hinge_pulls_with_the_centripetal_force(estimator: WholeBodyEstimator) -> None:
    """4 rad/s at 0.5 m: 8 m/s2 towards the hinge, 16 N more on the sensor."""
    predicted = estimator.predict(ZERO, np.array([4.0]), ZERO)
    assert predicted[0, 2] == pytest.approx(-WEIGHT_N - 16.0)


def test_falling_robot_weighs_nothing(arm: TreeModel, compiled: bool) -> None:
    estimator = WholeBodyEstimator(arm, Assumption(source="hand"), compiled=compiled)
    still = (0.0, 0.0, 0.0)
    falling = BaseMotion(omega_rad_s=still, domega_rad_s2=still, acceleration_m_s2=still)
    assert estimator.predict(ZERO, ZERO, ZERO, falling) == pytest.approx(0.0, abs=1e-12)


def test_hand_that_feels_gravity_sideways_hangs_from_a_tilted_base(
    arm: TreeModel, compiled: bool
) -> None:
    """At rest and reading +9.81 along its own x: down is -x, so the drive holds 9.81 Nm."""
    estimator = WholeBodyEstimator(arm, Assumption(source="hand"), compiled=compiled)
    still = (0.0, 0.0, 0.0)
    lying = BaseMotion(omega_rad_s=still, domega_rad_s2=still, acceleration_m_s2=(9.81, 0.0, 0.0))
    predicted = estimator.predict(ZERO, ZERO, ZERO, lying)
    assert predicted[0] == pytest.approx([-WEIGHT_N, 0, 0, 0, 0.3 * WEIGHT_N, 0], abs=1e-12)
    found = estimator.estimate(ZERO, ZERO, ZERO, predicted, None, lying)
    assert found.tau_nm == pytest.approx([-0.5 * WEIGHT_N])


def test_known_load_in_the_hand_is_no_contact(arm: TreeModel, compiled: bool) -> None:
    """1 N down, 0.1 m in front of the hand: 0.1 Nm about +y on the arm."""
    load = KnownWrench(frame="hand", point_m=(0.1, 0, 0), wrench=(0, 0, -1.0, 0, 0, 0))
    assumption = Assumption(contacts=(Contact(frame="hand"),), known=(load,))
    estimator = WholeBodyEstimator(arm, assumption, compiled=compiled)
    reading = np.array([[0.0, 0.0, -WEIGHT_N - 1.0, 0.0, 0.1, 0.0]])
    found = estimator.estimate(ZERO, ZERO, ZERO, reading)
    assert found.contact_wrenches == pytest.approx(0.0, abs=1e-12)
    assert found.tau_nm == pytest.approx([-0.1])


def test_joint_without_end_stops_turns_like_any_other(tmp_path: Path, compiled: bool) -> None:
    path = tmp_path / "wheel.urdf"
    path.write_text(URDF.replace('"revolute"', '"continuous"'))
    wheel = TreeModel.from_urdf(str(path), ("hinge",), {"ft": "ft"})
    estimator = WholeBodyEstimator(wheel, Assumption(), compiled=compiled)
    assert estimator.gravity(np.array([-np.pi / 2])) == pytest.approx([-0.5 * WEIGHT_N])


def test_joint_that_slides_is_refused_by_name(tmp_path: Path) -> None:
    path = tmp_path / "slide.urdf"
    path.write_text(URDF.replace('"revolute"', '"prismatic"'))
    with pytest.raises(ModelError, match="hinge"):
        TreeModel.from_urdf(str(path), ("hinge",), {"ft": "ft"})
