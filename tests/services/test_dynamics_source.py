"""A robot whose base rocks as an IMU in its head tells, beside the same one on a rocking joint."""

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from dforc.robot_model import RobotModel
from services.config import load_robot
from services.messages import Imu
from services.robotfile.robot_tables import RobotFile
from services.streams import DYNAMICS_SAMPLES, EXTERNAL, IMU, TORQUE_ESTIMATE
from tests.services.whole_body import Stand

Vector = NDArray[np.float64]

ROCKER = """<link name="ground"/><joint name="rock" type="revolute"><parent link="ground"/>
<child link="base_link"/><origin xyz="0 0 0"/><axis xyz="0.6 0.8 0"/>
<limit lower="-1" upper="1" effort="0" velocity="0"/></joint></robot>"""
HZ = 1.0
AMPLITUDE_RAD = 0.2  # 7.9 rad/s2
GYRO_STEP_RAD_S = np.radians(1.0 / 16.0)
IMU_EVERY_MS = 10
GRAVITY_M_S2 = np.array([0.0, 0.0, 9.81])
DIFFERENCE_S = 1e-4


class Rocking(Stand):
    """Joint 0 of its model is the rocker; it and the neck's pitch go on sines."""

    def __init__(self, robot: RobotFile, urdf: Path, rock_rad: float, nod_rad: float) -> None:
        super().__init__(robot)
        joints = ("rock", *self.body.joints)
        self.rocker = RobotModel(str(urdf), joints, "imu_frame", self.body.sensor_frames)
        self.amplitude_rad = np.zeros(len(joints))
        self.amplitude_rad[0] = rock_rad
        self.amplitude_rad[joints.index("neck_pitch")] = nod_rad
        self.middle_rad = np.concatenate([[0.0], self.q_rad])
        self.true_tau_nm: Vector = np.zeros(len(joints))
        self.path = self.joints_at

    def whole_at(self, t_s: float) -> tuple[Vector, Vector, Vector]:
        """Rocker and joints."""
        w = 2.0 * np.pi * HZ
        sine, cosine = self.amplitude_rad * np.sin(w * t_s), self.amplitude_rad * np.cos(w * t_s)
        return self.middle_rad + sine, w * cosine, -w * w * sine

    def joints_at(self, t_s: float) -> tuple[Vector, Vector, Vector]:
        """What encoders see."""
        q, dq, ddq = self.whole_at(t_s)
        return q[1:], dq[1:], ddq[1:]

    def true_wrenches(self) -> dict[str, Vector]:
        """Of the rocking robot; its torques are kept in `true_tau_nm`."""
        t_s = self.now_ns * 1e-9
        self.true_tau_nm, wrenches = self.rocker.inverse_dynamics(*self.whole_at(t_s))
        return wrenches

    def imu(self) -> Imu:
        """What the head's IMU shows now."""
        t_s = self.now_ns * 1e-9
        poses = [self.rocker.tip_pose(self.whole_at(t_s + i * DIFFERENCE_S)[0]) for i in (-1, 0, 1)]
        turn = poses[1][0]
        acceleration = (poses[0][1] - 2.0 * poses[1][1] + poses[2][1]) / DIFFERENCE_S**2
        q, dq, _ = self.whole_at(t_s)
        omega = turn.T @ (self.rocker.tip_jacobian(q)[3:] @ dq)
        gx, gy, gz = (np.round(omega / GYRO_STEP_RAD_S) * GYRO_STEP_RAD_S).tolist()
        ax, ay, az = (turn.T @ (acceleration + GRAVITY_M_S2)).tolist()
        return Imu(
            stamp_ns=self.now_ns,
            quaternion=(1.0, 0.0, 0.0, 0.0),
            gyro_rad_s=(gx, gy, gz),
            acceleration_m_s2=(ax, ay, az),
            magnetic_t=(0.0, 0.0, 0.0),
            arrival_ns=self.now_ns,
        )

    def run_with_imu(self, milliseconds: int) -> Iterator[None]:
        """Millisecond by millisecond."""
        for tick in range(milliseconds):
            if tick % IMU_EVERY_MS == 0:
                self.others = {IMU["head_imu"]: self.imu()}
            self.run(1)
            yield


@pytest.fixture(scope="module")
def whole() -> RobotFile:
    return load_robot("icub")


@pytest.fixture(scope="module")
def rocker(whole: RobotFile, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The robot's URDF with a joint below its base."""
    text = Stand(whole).body.urdf.read_text(encoding="utf-8")
    path = tmp_path_factory.mktemp("rocker") / "robot.urdf"
    path.write_text(text.replace("</robot>", ROCKER), encoding="utf-8")
    return path


def settled(robot: RobotFile, urdf: Path, rock_rad: float, nod_rad: float) -> Rocking:
    """Calibrated, in full motion, with the IMU as kinematic source and all filters full."""
    stand = Rocking(robot, urdf, rock_rad, nod_rad)
    for sensor, name in enumerate(stand.sensors):
        stand.dynamics.bank.set_offset(sensor, stand.offsets[name])
    assert stand.ask("source", value="head_imu").ok
    for _ in stand.run_with_imu(600):
        pass
    return stand


def torque_errors(stand: Rocking) -> tuple[float, float]:
    """RMS over half a period of the torso's torque error, and without angular acceleration.

    The last is worked out with the service's own estimator from the same inputs.
    """
    dynamics = stand.dynamics
    torso = next(part for part in stand.body.parts if part.name == "torso")
    errors, without = [], []
    for _ in stand.run_with_imu(500):
        true = stand.true_tau_nm[1 + torso.start : 1 + torso.stop]
        sent = stand.bench.last(TORQUE_ESTIMATE["torso"]).tau_nm
        errors.append(np.array(sent) - true)
        motion = dynamics.source.motion
        assert motion is not None
        still = dynamics.estimator.estimate(
            dynamics.joints.q_rad,
            dynamics.joints.dq_rad_s,
            np.zeros(len(stand.q_rad)),
            dynamics.bank.compensated(),
            dynamics.bank.mask,
            replace(motion, domega_rad_s2=(0.0, 0.0, 0.0)),
        )
        without.append(still.tau_nm[torso.start : torso.stop] - true)
    return float(np.sqrt(np.mean(np.square(errors)))), float(np.sqrt(np.mean(np.square(without))))


def test_torques_of_a_robot_whose_base_accelerates_are_true(whole: RobotFile, rocker: Path) -> None:
    error_nm, without_nm = torque_errors(settled(whole, rocker, AMPLITUDE_RAD, 0.0))
    assert without_nm > 0.3
    assert error_nm < 0.2 * without_nm


def test_a_nod_of_the_head_does_not_turn_the_robot(whole: RobotFile, rocker: Path) -> None:
    error_nm, without_nm = torque_errors(settled(whole, rocker, 0.0, AMPLITUDE_RAD))
    assert without_nm > 0.1
    assert error_nm < 0.2 * without_nm


def test_rocking_is_no_touch_and_explained_by_the_filtered_model(
    whole: RobotFile, rocker: Path
) -> None:
    stand = settled(whole, rocker, AMPLITUDE_RAD, 0.0)
    before = len(stand.bench.sent(EXTERNAL))
    for _ in stand.run_with_imu(500):
        pass
    looks = stand.bench.sent(EXTERNAL)[before:]
    assert len(looks) == 50
    assert not any(contact.touching for look in looks for contact in look.contacts)
    for samples in stand.bench.sent(DYNAMICS_SAMPLES)[-50:]:
        for sensor in samples.sensors:
            force = np.subtract(sensor.measured, sensor.predicted)[:3]
            assert np.linalg.norm(force) < 0.3, sensor.name
