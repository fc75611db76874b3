"""Torque set-points of a shoulder with coupled motors: what the drives then exert."""

from collections.abc import Iterator

import msgspec
import numpy as np
import pinocchio as pin
import pytest
from numpy.typing import NDArray

from benchmarks.whole_robot import WholeRobot
from firmware_sim.boards.motor_board import MotorBoard
from hal.decoupling import DUTIES, SPEEDS, Shoulder, shoulders

Vector = NDArray[np.float64]

SHOULDER = ("l_shoulder_pitch", "l_shoulder_roll", "l_shoulder_yaw")
HELD_NM = (-1.6, 1.5, -0.4, 0.7, 0.0)  # about gravity, elbow and prosup last
FELT = (*SHOULDER, "l_elbow", "l_wrist_prosup")


@pytest.fixture(scope="module")
def whole() -> Iterator[WholeRobot]:
    whole = WholeRobot("icub:left_arm")
    whole.calibrated()
    arm = whole.file.parts["left_arm"]
    posture = [float(np.radians(angle)) for angle in (-30.0, 40.0, 10.0, 50.0, 0.0, 0.0, 0.0)]
    whole.finish(whole.hal.request("move", arm, q_rad=posture, duration_s=2.0))
    whole.tick(500)
    yield whole
    whole.close()


def test_mixing_is_that_of_the_emulated_firmware(whole: WholeRobot) -> None:
    upper, lower = (whole.rig.board(1, address) for address in (1, 2))
    assert isinstance(upper, MotorBoard)
    assert isinstance(lower, MotorBoard)
    own, added = lower.firmware.coupling.motors[0], lower.firmware.coupling.partner_motors[0]
    assert np.array(upper.firmware.coupling.motors) == pytest.approx(DUTIES[:2, :2])
    assert [*added, own[0]] == SPEEDS[2].tolist()
    others = np.array(added) @ DUTIES[:2, :2]  # the duties applied to the other two motors
    added_up = np.array([*others.tolist(), 0.0]) + np.array([0.0, 0.0, own[0]])
    assert added_up == pytest.approx(DUTIES[2])


def shoulder_of(whole: WholeRobot) -> Shoulder:
    (shoulder,) = shoulders([(one.board, one.axes) for one in whole.hal._machine.boards])
    return shoulder


def test_loops_that_are_told_bent_torques_make_the_drives_exert_the_straight_ones(
    whole: WholeRobot,
) -> None:
    assert_straight(whole, shoulder_of(whole))


def test_gains_that_are_tuned_meanwhile_count(whole: WholeRobot) -> None:
    shoulder = shoulder_of(whole)
    old = whole.hal.description.joints[2].torque_pid
    assert old is not None
    whole.finish(whole.hal.tune(SHOULDER[2], msgspec.structs.replace(old, kp=-200, kff=-30)))
    assert_straight(whole, shoulder)
    whole.finish(whole.hal.tune(SHOULDER[2], msgspec.structs.replace(old, kp=0, kff=0)))
    assert shoulder.bent(HELD_NM[:3]) == list(HELD_NM[:3])
    whole.finish(whole.hal.tune(SHOULDER[2], old))


def assert_straight(whole: WholeRobot, shoulder: Shoulder) -> None:
    """What the firmware's law makes of the set-points, through the mixing, is what was wanted."""
    tau = np.array(HELD_NM[:3])
    duties = np.zeros(3)
    for i, axis in enumerate(whole.hal._machine.axes[:3]):
        pid = axis.joint.torque_pid
        assert pid is not None
        counts = 0x8000 / 8.0 / 2.0**pid.shift  # per Nm
        sent = shoulder.bent(tau.tolist())[i]
        duties[i] = counts * (pid.kff * sent + pid.kp * (sent - tau[i]))
    nm_per_count = np.array([4.7 * 36.0 / 1.0, 4.7 * 36.0 / 1.0, 3.0 * 36.0 / 1.2]) / 800.0
    pulls = SPEEDS.T @ (nm_per_count * (DUTIES @ duties))
    assert pulls == pytest.approx(-tau, abs=1e-9)  # all three motors are built in reversed


def gravity_nm(whole: WholeRobot) -> list[float]:
    plant, names = whole.rig.plant, whole.rig.joints
    model, q = plant.rigid._model, plant.rigid._posture(plant.q_rad)
    torques = pin.computeGeneralizedGravity(model, model.createData(), q)
    return [float(torques[plant.rigid.columns[names.index(name)]]) for name in FELT]


def test_an_arm_without_stiffness_stays_where_it_is(whole: WholeRobot) -> None:
    hal = whole.hal
    joints = [hal.joint_index(name) for name in FELT]
    hal.set_joint_torques(joints, HELD_NM, whole.now_ns)
    task = hal.request("mode", FELT, "torque")
    at = [whole.rig.joints.index(name) for name in SHOULDER]
    begin: Vector | None = None
    for _ in range(800):
        # The plant's own torques, so that nothing but the loops decides.
        gravity = gravity_nm(whole)
        hal.set_joint_torques(joints, gravity, whole.now_ns)
        if task.done:
            begin = whole.rig.plant.q_rad[at].copy() if begin is None else begin
            hal.set_torques(joints, gravity)
        whole.tick()
    assert task.ok, task.reason
    assert begin is not None
    assert np.degrees(np.abs(whole.rig.plant.q_rad[at] - begin)).max() < 1.0
