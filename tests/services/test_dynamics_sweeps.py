"""Pose sweeps: which samples count, which gains are believed, and what stays where one is not."""

import numpy as np
import pytest

from dforc.signals.identification import identify_gain
from services.config import load_robot
from services.core.clock import NS_PER_MS
from services.robotfile.robot_tables import RobotFile
from services.wholebody.pose_sweeps import trouble_with
from tests.services.whole_body import Stand, swing


@pytest.fixture(scope="module")
def arms() -> RobotFile:
    return load_robot("icub:arms")


def test_a_pose_sweep_finds_gain_and_offset(arms: RobotFile) -> None:
    stand = Stand(arms)
    gain = np.diag([0.6, 1.4, 1.1, 0.9, 1.2, 0.8])
    stand.gains = {"l_arm_ft": gain}
    stand.run(20)
    assert stand.ask("identify", "l_arm_ft", value="start").ok
    stand.path = swing(stand.q_rad, 0.8, 0.3)
    stand.run(6000)
    assert stand.health("l_arm_ft").task == "identifying"
    reply = stand.ask("identify", "l_arm_ft", value="solve")
    assert reply.ok, reply.reason
    assert "l_arm_ft: " in reply.reason
    assert stand.health("r_arm_ft").flags == ("uncalibrated",)
    stand.run(1000)  # the path goes on to other postures
    health = stand.health("l_arm_ft")
    assert health.ok
    assert len(health.gain) == 36
    # Up to 40 % of a limb's 15 N were wrong.
    assert np.abs(health.mean[:3]).max() < 0.1
    assert np.abs(health.std[:3]).max() < 0.15


def test_a_push_in_a_sweep_is_left_out_of_the_gain(arms: RobotFile) -> None:
    stand = Stand(arms, pushed="l_hand_dh_frame")
    stand.calibrate()
    stand.path = swing(stand.q_rad, 0.8, 0.3)
    assert stand.ask("identify", "l_arm_ft", value="start").ok
    stand.run(4000)
    stand.push_n = np.array([0.0, 15.0, 0.0])
    stand.run(1500)
    stand.push_n = np.zeros(3)
    stand.run(4000)
    reply = stand.ask("identify", "l_arm_ft", value="solve")
    assert reply.ok, reply.reason
    assert "samples in touch, fast or late left out" in reply.reason
    stand.run(1000)
    health = stand.health("l_arm_ft")
    assert np.abs(health.mean[:3]).max() < 0.1
    assert np.abs(health.std[:3]).max() < 0.15


def test_a_gain_from_a_sweep_that_was_pushed_unnoticed_is_refused(arms: RobotFile) -> None:
    stand = Stand(arms, pushed="l_hand_dh_frame")
    stand.run(20)  # no offset yet: a touch cannot be told
    before = stand.dynamics.bank.channels[0].matrix
    stand.path = swing(stand.q_rad, 0.8, 0.3)
    assert stand.ask("identify", "l_arm_ft", value="start").ok
    stand.run(3000)
    stand.push_n = np.array([0.0, 15.0, 0.0])
    stand.run(3000)
    reply = stand.ask("identify", "l_arm_ft", value="solve")
    assert not reply.ok
    assert "the gain would stretch wrenches by" in reply.reason
    assert (stand.dynamics.bank.channels[0].matrix == before).all()
    assert stand.health("l_arm_ft").flags == ("uncalibrated",)


@pytest.mark.parametrize(
    ("noise_n", "noise_nm", "unit"), [(0.2, 0.01, ""), (0.6, 0.01, "N"), (0.2, 0.06, "Nm")]
)
def test_a_gain_that_leaves_too_much_unexplained_is_not_believed(
    noise_n: float, noise_nm: float, unit: str
) -> None:
    """In three channels: 0.2 N is 0.35 N, and 0.6 N is 1.04 N; 0.06 Nm is 0.10 Nm."""
    random = np.random.default_rng(0)
    spread = np.array([8.0, 8.0, 8.0, 0.6, 0.6, 0.6])
    true = spread * random.standard_normal((2000, 6))
    noise = np.repeat([noise_n, noise_nm], 3) * random.standard_normal((2000, 6))
    trouble = trouble_with(identify_gain(true + noise, true))
    assert (f" {unit} would stay unexplained" in trouble) is (unit != "")
    assert bool(trouble) is (unit != "")


def test_a_gain_of_more_than_two_is_refused(arms: RobotFile) -> None:
    stand = Stand(arms)
    stand.gains = {"l_arm_ft": np.diag([3.0, 1.0, 1.0, 1.0, 1.0, 1.0])}
    stand.run(20)
    stand.path = swing(stand.q_rad, 0.8, 0.3)
    assert stand.ask("identify", "l_arm_ft", value="start").ok
    stand.run(6000)
    reply = stand.ask("identify", "l_arm_ft", value="solve")
    assert not reply.ok
    assert "the gain would stretch wrenches by" in reply.reason
    assert "l_arm_ft" in reply.reason
    assert not stand.health("l_arm_ft").gain


def test_a_sweep_leaves_fast_motion_out(arms: RobotFile) -> None:
    stand = Stand(arms)
    stand.run(200)
    stand.dq_rad_s = np.full(len(stand.q_rad), 2.5)
    stand.run(200)
    assert stand.ask("identify", "l_arm_ft", value="start").ok
    stand.run(300)
    assert stand.health("l_arm_ft").samples == 0
    assert "in touch, fast or late)" in stand.ask("identify", "l_arm_ft", value="solve").reason


def test_a_sweep_leaves_out_what_a_stall_has_mixed_up(arms: RobotFile) -> None:
    """Joints and readings that waited for the process are not of one and the same instant."""
    stand = Stand(arms)
    stand.calibrate()
    assert stand.ask("identify", "l_arm_ft", value="start").ok
    stand.run(400)
    before = stand.health("l_arm_ft").samples
    assert before > 20
    stand.bench.clock.advance_ns(20 * NS_PER_MS)
    stand.run(140)
    assert stand.health("l_arm_ft").samples <= before + 10  # up to the stall, since that health
    stand.run(200)
    assert before + 10 < stand.health("l_arm_ft").samples < before + 30


def test_a_sweep_does_not_begin_in_touch(arms: RobotFile) -> None:
    stand = Stand(arms, pushed="r_hand_dh_frame")
    stand.calibrate()
    stand.push_n = np.array([0.0, 10.0, 0.0])
    stand.run(200)
    assert "something touches" in stand.ask("identify", "r_arm_ft", value="start").reason
    assert stand.ask("identify", "l_arm_ft", value="start").ok


def test_a_new_gain_ends_a_calibration_that_still_had_the_old_one(arms: RobotFile) -> None:
    stand = Stand(arms)
    stand.gains = {"l_arm_ft": np.diag([0.6, 1.4, 1.1, 0.9, 1.2, 0.8])}
    stand.run(20)
    stand.path = swing(stand.q_rad, 0.8, 0.3)
    assert stand.ask("identify", "l_arm_ft", value="start").ok
    stand.run(6000)
    assert stand.ask("calibrate", "l_arm_ft", samples=5000).ok
    stand.run(100)
    assert stand.ask("identify", "l_arm_ft", value="solve").ok
    stand.run(100)
    assert stand.health("l_arm_ft").task == ""


def test_a_sweep_without_motion_is_refused_and_goes_on(arms: RobotFile) -> None:
    stand = Stand(arms)
    stand.calibrate()
    assert stand.ask("identify", "l_arm_ft", value="start").ok
    stand.run(1000)
    before = stand.dynamics.bank.channels[0].matrix
    reply = stand.ask("identify", "l_arm_ft", value="solve")
    assert not reply.ok
    assert "move the limb through more postures" in reply.reason
    assert (stand.dynamics.bank.channels[0].matrix == before).all()
    assert stand.health("l_arm_ft").task == "identifying"
    assert stand.ask("identify", "l_arm_ft", value="discard").ok
    stand.run(110)
    assert stand.health("l_arm_ft").task == ""
