"""The main job in virtual time, through every layer."""

import json
import re

import numpy as np
import pytest

from firmware_sim.rig import Rig
from services.cli.demo import COMPLIANT_BAR_M, STIFF_BAR_M, succeeded
from services.config import load_robot
from services.emulated.emulation import rig_spec
from services.reaching.limb import limb_model
from services.reaching.reach import ReachOptions
from services.reaching.reach_record import Report
from services.reaching.reach_virtual import run_virtual
from services.robotfile.robot_tables import RobotFile


def run(robot: RobotFile, options: ReachOptions, hop_ticks: int = 1) -> Report:
    return run_virtual(robot, options, hop_ticks).report


def clearance_mm(report: Report) -> float:
    value = report["min_clearance_mm"]
    assert isinstance(value, float)
    return value


def assert_clean(report: Report) -> None:
    for key in ("limit_violations", "board_faults", "frames_lost", "frames_dropped", "tick_slips"):
        assert report[key] == 0, key
    assert report["joints_not_held_to_limits"] == []


def test_compliant_arm_reaches_around_the_ball_and_again_byte_for_byte(robot: RobotFile) -> None:
    options = ReachOptions(seed=0, position_bar_m=COMPLIANT_BAR_M)
    report = run(robot, options)
    assert report["reached"]
    assert clearance_mm(report) >= 5.0
    assert_clean(report)
    assert succeeded(report)
    again = run(robot, options)
    del report["wall"], again["wall"]
    assert json.dumps(report) == json.dumps(again)


@pytest.mark.slow
def test_stiff_arm_reaches_around_the_ball(robot: RobotFile) -> None:
    report = run(robot, ReachOptions(seed=1, stiff=True, position_bar_m=STIFF_BAR_M))
    assert report["reached"]
    assert clearance_mm(report) >= 5.0
    assert_clean(report)


@pytest.mark.slow
def test_reaches_beside_an_arm_that_takes_no_part_and_is_not_calibrated() -> None:
    report = run(load_robot("icub:arms"), ReachOptions(seed=0, position_bar_m=COMPLIANT_BAR_M))
    assert report["failure"] == ""
    assert report["reached"]
    assert report["limit_violations"] == 0


@pytest.mark.slow
def test_reaches_with_twice_the_delay_between_processes(robot: RobotFile) -> None:
    report = run(robot, ReachOptions(seed=2, position_bar_m=COMPLIANT_BAR_M), hop_ticks=2)
    assert report["reached"]
    assert_clean(report)


@pytest.mark.slow
def test_target_out_of_reach_gets_the_nearest_position_and_says_so(robot: RobotFile) -> None:
    hand_m = limb_model(robot).tip_pose(np.radians(robot.reach.home_deg))[1]
    far = (float(hand_m[0]) - 0.5, float(hand_m[1]), float(hand_m[2]))
    nowhere = (1.0, 1.0, 1.0, 0.05)
    report = run(robot, ReachOptions(target_m=far, ball=nowhere, timeout_s=12.0))
    assert not report["reached"]
    assert report["field_state"] == "unreachable"
    said = re.match(r"at least (\d+) mm beyond the reach of right_arm", str(report["field_reason"]))
    assert said is not None
    assert report["failure"] == ""
    assert_clean(report)
    nearest, reached = report["field_distance_mm"], report["position_error_mm"]
    assert isinstance(nearest, float)
    assert isinstance(reached, float)
    assert nearest > float(said[1]) > 50.0
    assert reached == pytest.approx(nearest, abs=5.0)


def test_another_seed_is_another_robot(robot: RobotFile) -> None:
    first, second = (Rig(rig_spec(robot, seed)) for seed in (0, 1))
    assert not np.allclose(first.plant.wrenches[0], second.plant.wrenches[0])
