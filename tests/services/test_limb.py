"""Limbs of the robot file: which there are, their joints, limits, rows and models."""

import numpy as np
import pytest

from services.config import load_robot
from services.core.errors import ConfigError
from services.reaching.limb import (
    find_limb,
    limb_joints,
    limb_limits,
    limb_models,
    limb_problem,
    split,
)
from services.reaching.limb_setup import apply_setup
from services.reaching.messages import LimbSetup, TipOffset
from services.robotfile.robot_tables import RobotFile

FAR = TipOffset(position_m=(0.0, 1e9, 0.0))
NONE = TipOffset(position_m=(0.0, float("nan"), 0.0))
HOME_DEG = [0, 0, 0, -30, 30, 0, 45, 0, 0, 0]


@pytest.fixture(scope="module")
def arms() -> RobotFile:
    return load_robot("icub:arms")


def test_a_limb_exists_when_all_its_parts_are_in_use(robot: RobotFile, arms: RobotFile) -> None:
    assert list(robot.limbs) == ["right_arm"]
    assert list(arms.limbs) == ["left_arm", "right_arm", "both_arms"]
    assert list(load_robot("icub:lower_body").limbs) == []


def test_without_a_name_it_is_the_main_job_s_or_the_first(arms: RobotFile) -> None:
    assert find_limb(arms).name == "right_arm"
    left_only = load_robot("icub:reach_left")
    assert find_limb(left_only).name == "left_arm"


def test_unknown_limb_lists_those_there_are(robot: RobotFile) -> None:
    with pytest.raises(ConfigError, match="unknown limb 'left_arm'; among the parts in use: right"):
        find_limb(robot, "left_arm")
    with pytest.raises(ConfigError, match="unknown limb ''; among the parts in use: none"):
        find_limb(load_robot("icub:lower_body"))


def test_both_arms_share_the_torso(arms: RobotFile) -> None:
    joints = limb_joints(arms, "both_arms")
    assert joints == arms.parts["torso"] + arms.parts["left_arm"] + arms.parts["right_arm"]
    both = find_limb(arms, "both_arms")
    assert [tip.frame for tip in both.tips] == ["l_hand_dh_frame", "r_hand_dh_frame"]
    assert both.rest_weights == (1.0,) * 3 + (0.1,) * 14
    assert both.home_deg == tuple(HOME_DEG + HOME_DEG[3:])
    assert split(arms, tuple(range(17)), "both_arms") == {
        "torso": (0, 1, 2),
        "left_arm": (3, 4, 5, 6, 7, 8, 9),
        "right_arm": (10, 11, 12, 13, 14, 15, 16),
    }


def test_rows_of_a_limb_are_those_over_its_joints(robot: RobotFile, arms: RobotFile) -> None:
    assert len(robot.rows) == 7  # the left shoulder's went with its joints
    assert limb_limits(robot).rows.shape == (7, 10)
    both = limb_limits(arms, "both_arms").rows
    assert both.shape == (14, 17)
    assert not both[:7, 10:].any()
    assert not both[7:, 3:10].any()
    assert np.array_equal(both[:7, 3:10], both[7:, 10:])


def test_the_main_job_s_limits_stay_as_they_are(robot: RobotFile, arms: RobotFile) -> None:
    alone, among = limb_limits(robot), limb_limits(arms, "right_arm")
    assert np.array_equal(alone.lower, among.lower)
    assert np.array_equal(alone.C, among.C)
    # abduction: 100 degrees less the HAL's 1 degree of margin and the planner's half
    margin_deg = robot.joints["r_shoulder_roll"].limit_margin_deg + 0.5
    assert alone.upper[10 + 4] == pytest.approx(np.radians(100.0 - margin_deg))


def test_the_left_arm_mirrors_the_right_one(arms: RobotFile) -> None:
    left, right = limb_models(arms, "both_arms")
    q = np.radians(HOME_DEG + HOME_DEG[3:]) + np.radians([0, 0, 0] + [5, 20, 10, 8, 6, -9, 4] * 2)
    assert left.n == right.n == 17
    here, there = left.tip_pose(q)[1], right.tip_pose(q)[1]
    assert here == pytest.approx(there * [1.0, -1.0, 1.0], abs=1e-5)


def test_problem_has_the_robot_file_s_rest_posture(arms: RobotFile) -> None:
    problem = limb_problem(arms, "left_arm")
    assert np.degrees(problem.rest_rad) == pytest.approx([0, 0, 0, -30, 30, 0, 50, 0, 0, 0])
    assert problem.beta == 0.01
    assert problem.free.all()
    assert [tip.name for tip in limb_problem(arms, "both_arms").tips] == ["left_arm", "right_arm"]


def test_an_empty_setup_changes_nothing(robot: RobotFile) -> None:
    problem = limb_problem(robot)
    same = apply_setup(problem, LimbSetup(limb=""))
    assert same.limits is problem.limits
    assert np.array_equal(same.rest_rad, problem.rest_rad)
    assert same.free.all()


def test_setup_blocks_joints_and_moves_the_tip(robot: RobotFile) -> None:
    offset = TipOffset(position_m=(0.0, 0.0, 0.1), rotation_rad=(0.0, 0.0, np.pi / 2))
    setup = LimbSetup(limb="", free=(False,) * 3 + (True,) * 7, tip_offsets=(offset,))
    problem, changed = limb_problem(robot), apply_setup(limb_problem(robot), setup)
    assert changed.free.tolist() == [False] * 3 + [True] * 7
    q = np.radians(HOME_DEG)
    R, p = problem.tips[0].pose(q)
    R_moved, p_moved = changed.tips[0].pose(q)
    assert p_moved == pytest.approx(p + 0.1 * R[:, 2])
    assert R_moved[:, 0] == pytest.approx(R[:, 1])


def test_limits_of_a_setup_only_narrow(robot: RobotFile) -> None:
    problem = limb_problem(robot)
    upper = [9.0] * 10
    upper[6] = 1.0
    changed = apply_setup(
        problem, LimbSetup(limb="", lower_rad=(-9.0,) * 10, upper_rad=tuple(upper))
    )
    assert np.array_equal(changed.limits.lower_rad, problem.limits.lower_rad)
    assert changed.limits.upper_rad[6] == 1.0
    assert np.array_equal(changed.limits.upper_rad[:6], problem.limits.upper_rad[:6])
    assert np.array_equal(changed.limits.upper[10:], problem.limits.upper[10:])


@pytest.mark.parametrize(
    ("setup", "expected"),
    [
        (LimbSetup(limb="", free=(True,)), "free has 1 values; the limb has 10 joints"),
        (LimbSetup(limb="", rest_rad=(float("nan"),) * 10), "rest posture is not finite"),
        (LimbSetup(limb="", rest_weights=(-1.0,) * 10), "rest weights must not be negative"),
        (LimbSetup(limb="", lower_rad=(9.0,) * 10), "joint 0: lower limit 9.0 above upper"),
        (LimbSetup(limb="", upper_rad=(float("nan"),) * 10), "joint 0: lower limit"),
        (LimbSetup(limb="", tip_offsets=(TipOffset(),) * 2), "2 tip offsets; the limb has 1 tips"),
        (LimbSetup(limb="", tip_offsets=(FAR,)), "a tip offset of more than 10 m"),
        (LimbSetup(limb="", tip_offsets=(NONE,)), "a tip offset of more than 10 m"),
        (LimbSetup(limb="", priority="speed"), "unknown priority 'speed'; known: position, orien"),
        (LimbSetup(limb="", position_tolerance_m=-1.0), "position_tolerance_m must be a positive"),
        (LimbSetup(limb="", rest_beta=float("inf")), "beta must be a positive number"),
    ],
)
def test_setup_that_does_not_fit_is_refused(
    robot: RobotFile, setup: LimbSetup, expected: str
) -> None:
    with pytest.raises(ConfigError, match=expected):
        apply_setup(limb_problem(robot), setup)
