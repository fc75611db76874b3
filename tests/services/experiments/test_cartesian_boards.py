"""Random reaches: how they are drawn, how they are judged, and two of them through the boards."""

import math
from itertools import pairwise

import numpy as np
import pytest

from services.config import load_robot
from services.experiments.cartesian.arm import Arm
from services.experiments.cartesian.boards import (
    NEAR_M,
    SPEED_SHARE,
    TIME_S,
    random_course,
    reaches_of,
    rows_of,
)
from services.experiments.cartesian.can import Job, run_on_boards
from services.experiments.cartesian.controllers import CONTENDERS
from services.experiments.cartesian.figures import Run, judged
from services.experiments.cartesian.metrics import minimum_jerk


@pytest.fixture(scope="module")
def arm() -> Arm:
    return Arm(load_robot("icub:arms"), "left_arm", torso=True)


def test_random_reaches_keep_the_speed_limits_and_come_again_with_their_seed(arm: Arm) -> None:
    course = random_course(arm, 6, seed=3)
    again = random_course(arm, 6, seed=3)
    assert (course.q_rad == again.q_rad).all()
    assert len(course.moves) == 6
    postures = [course.q_start_rad, *course.q_rad[list(course.moves)]]
    for before, after in pairwise(postures):
        peak = 1.875 * np.abs(after - before) / TIME_S
        assert (peak <= SPEED_SHARE * np.array(arm.speed_limits_rad_s)).all()
        assert arm.limits.violation(after) < 0.0
        moved = arm.pose(after).position_m - arm.pose(before).position_m
        assert 0.12 < np.linalg.norm(moved) < 0.41


def run_of(arm: Arm, lasting_s: float, short_of_rad: float) -> Run:
    """One reach that lasts so long, and in which the elbow stays short of its goal."""
    course = random_course(arm, 1, seed=0)
    periods = course.periods
    share = minimum_jerk(np.arange(periods + 1, dtype=np.float64) * 0.01 / lasting_s)
    way = course.q_rad[0] - course.q_start_rad
    angles = course.q_start_rad + np.outer(share, way)
    angles[:, 6] -= share * short_of_rad
    return Run(
        controller="ulna",
        plant="boards",
        seed=0,
        arm=arm,
        course=course,
        references_rad=angles[1:],
        angles_rad=angles,
    )


def test_a_reach_that_lasts_its_time_and_ends_at_its_pose_is_on_time_and_near(arm: Arm) -> None:
    run = run_of(arm, TIME_S, 0.0)
    (reach,) = reaches_of(run)
    assert reach.figures.since_jump_s == pytest.approx(TIME_S, rel=0.04)
    assert reach.error_m < 1e-6
    assert reach.near_s <= TIME_S
    assert all(row.holds is not False for row in rows_of(run))


def test_a_reach_that_takes_longer_or_ends_short_fails_its_bar(arm: Arm) -> None:
    late = [row.name for row in rows_of(run_of(arm, 1.2 * TIME_S, 0.0)) if row.holds is False]
    assert any("duration over T, longest" in name for name in late)
    run = run_of(arm, TIME_S, math.radians(2.0))
    (reach,) = reaches_of(run)
    assert reach.error_m > NEAR_M
    assert math.isinf(reach.near_s)
    short = [row.name for row in rows_of(run) if row.holds is False]
    assert any("position error, largest" in name for name in short)


@pytest.fixture(scope="module")
def board_runs() -> dict[str, Run]:
    """A reach of each hand, and one of the left by VITE, on one emulated robot."""
    robot = load_robot("icub:arms")
    contenders = {contender.name: contender for contender in CONTENDERS}
    jobs = []
    for limb in ("right_arm", "left_arm"):
        arm = Arm(robot, limb, torso=True)
        course = random_course(arm, 1, seed=0)
        jobs.append(Job(arm=arm, course=course, contender=contenders["ulna"]))
    jobs.append(Job(arm=arm, course=course, contender=contenders["vite"]))
    told: list[str] = []
    runs = run_on_boards(robot, jobs, 0, lambda _, what: told.append(what))
    assert "ulna, random reaches, right arm, 10 DoF" in told
    return {f"{run.controller} {run.arm.limb.name}": run for run in runs}


@pytest.mark.slow
def test_both_hands_reach_through_boards_and_can(board_runs: dict[str, Run]) -> None:
    for name in ("ulna right_arm", "ulna left_arm"):
        failed = [row.name for row in rows_of(board_runs[name]) if row.holds is False]
        # Dry friction: near for good only when the boards' integrators have come round.
        assert [name for name in failed if "for good" not in name] == []


@pytest.mark.slow
def test_a_baseline_runs_on_the_boards_too_and_starts_with_a_jerk(
    board_runs: dict[str, Run],
) -> None:
    vite, ulna = board_runs["vite left_arm"], board_runs["ulna left_arm"]
    (reach,) = reaches_of(vite)
    assert reach.error_m < 0.003
    assert len(vite.angles_rad) == vite.course.periods + 1
    assert judged(vite)["jerk"] > 2.0 * judged(ulna)["jerk"]
