"""The IK service follows virtual points: answers, out of reach, and what it refuses."""

import msgspec
import numpy as np
import pytest

from services.config import load_robot
from services.core.testing import Bench
from services.ik import Ik
from services.messages import JointState, VirtualPoint
from services.reaching.limb import limb_joints, limb_limits, limb_models
from services.reaching.messages import LimbSetup, SetupInUse, TipOffset
from services.robotfile.robot_tables import RobotFile
from services.streams import (
    CARTESIAN_SETUP,
    CARTESIAN_STATUS,
    IK_SOLUTION,
    IK_STATUS,
    JOINT_STATE,
    VIRTUAL_POINT,
)
from tests.services.asking import heartbeat
from tests.services.postures import arms_at, point


def stand(bench: Bench, parts: dict[str, JointState]) -> None:
    """The measured posture arrives."""
    for part, state in parts.items():
        bench.put(JOINT_STATE[part], state)


@pytest.fixture
def bench(robot: RobotFile, home: dict[str, JointState]) -> Bench:
    bench = Bench(Ik(robot))
    stand(bench, home)
    return bench


@pytest.fixture(scope="module")
def arms() -> RobotFile:
    return load_robot("icub:arms")


@pytest.fixture
def both(arms: RobotFile) -> Bench:
    bench = Bench(Ik(arms))
    stand(bench, arms_at(arms))
    return bench


def use(bench: Bench, setup: LimbSetup) -> None:
    bench.put(CARTESIAN_SETUP, SetupInUse(stamp_ns=0, setup=setup))


def test_answer_reaches_the_point_within_all_limits(robot: RobotFile, bench: Bench) -> None:
    for i in range(1, 21):
        bench.put(VIRTUAL_POINT, point(robot, (-0.007 * i, -0.007 * i, 0.0), i))
    solution = bench.last(IK_SOLUTION)
    assert solution.status == "converged"
    assert solution.reason == ""
    assert solution.sequence == 20
    assert solution.limb == "right_arm"
    assert solution.position_error_m < 3e-4
    assert solution.orientation_error_rad < np.radians(0.3)
    assert limb_limits(robot).violation(np.array(solution.q_rad)) <= 1e-9


def test_no_joint_jumps_between_two_answers(robot: RobotFile, bench: Bench) -> None:
    for i in range(40):
        bench.put(VIRTUAL_POINT, point(robot, (-0.005 * i, 0.0, 0.0), i))
    postures = np.array([solution.q_rad for solution in bench.sent(IK_SOLUTION)])
    assert np.abs(np.diff(postures, axis=0)).max() <= np.radians(4.0) + 1e-9


def test_process_that_was_kept_waiting_catches_up_with_the_point(
    robot: RobotFile, bench: Bench
) -> None:
    bench.put(VIRTUAL_POINT, point(robot, (0.0, 0.0, 0.0), 0))
    bench.advance(0.1)
    bench.put(VIRTUAL_POINT, point(robot, (-0.05, -0.03, 0.05), 10))  # where it is by then
    before, after = bench.sent(IK_SOLUTION)
    assert after.status == "converged"
    assert np.abs(np.subtract(after.q_rad, before.q_rad)).max() > np.radians(4.0)
    bench.put(VIRTUAL_POINT, point(robot, (0.05, 0.03, -0.05), 11))  # a jump, and no wait
    jumped = bench.last(IK_SOLUTION)
    assert jumped.limited
    assert np.abs(np.subtract(jumped.q_rad, after.q_rad)).max() <= np.radians(4.0) + 1e-9


def test_out_of_reach_says_so_and_gives_the_nearest(robot: RobotFile, bench: Bench) -> None:
    for i in range(60):
        bench.put(VIRTUAL_POINT, point(robot, (-0.02 * i, 0.0, 0.0), i))
    solution = bench.last(IK_SOLUTION)
    assert solution.status == "infeasible"
    assert "nearest position is" in solution.reason
    assert solution.position_error_m > 0.1
    assert np.isfinite(solution.q_rad).all()
    assert limb_limits(robot).violation(np.array(solution.q_rad)) <= 1e-9


def test_point_that_is_not_finite_is_refused(robot: RobotFile, bench: Bench) -> None:
    bench.put(VIRTUAL_POINT, point(robot, (float("nan"), 0.0, 0.0)))
    assert bench.sent(IK_SOLUTION) == []
    assert isinstance(bench.service, Ik)
    assert bench.service.refused == 1


def test_is_silent_before_the_joints_are_known(robot: RobotFile) -> None:
    bench = Bench(Ik(robot))
    bench.put(VIRTUAL_POINT, point(robot, (0.0, 0.0, 0.0)))
    assert bench.sent(IK_SOLUTION) == []


@pytest.mark.parametrize("size_rad", [float("nan"), float("inf"), 1e200, 1e160])
def test_rotation_that_is_none_is_refused(robot: RobotFile, bench: Bench, size_rad: float) -> None:
    good = point(robot, (0.0, 0.0, 0.0))
    bad = msgspec.structs.replace(good, rotation_rad=(size_rad, 0.0, 0.0))
    bench.put(VIRTUAL_POINT, bad)
    assert bench.sent(IK_SOLUTION) == []
    bench.put(VIRTUAL_POINT, good)
    assert bench.last(IK_SOLUTION).status == "converged"


@pytest.mark.parametrize("q_rad", [(0.1,), (float("nan"),) * 7])
def test_posture_that_is_none_is_not_started_from(
    robot: RobotFile, home: dict[str, JointState], q_rad: tuple[float, ...]
) -> None:
    bench = Bench(Ik(robot))
    wrong = msgspec.structs.replace(home["right_arm"], q_rad=q_rad)
    stand(bench, {**home, "right_arm": wrong})
    bench.put(VIRTUAL_POINT, point(robot, (0.0, 0.0, 0.0)))
    assert bench.sent(IK_SOLUTION) == []
    stand(bench, home)
    bench.put(VIRTUAL_POINT, point(robot, (0.0, 0.0, 0.0)))
    assert bench.last(IK_SOLUTION).status == "converged"


def test_position_alone_leaves_the_orientation_free(robot: RobotFile, bench: Bench) -> None:
    turned = msgspec.structs.replace(
        point(robot, (0.0, 0.0, 0.0)), rotation_rad=(3.0, 0.0, 0.0), position_only=True
    )
    bench.put(VIRTUAL_POINT, turned)
    solution = bench.last(IK_SOLUTION)
    assert solution.status == "converged"
    assert solution.orientation_error_rad == 0.0


def test_the_point_names_the_limb(arms: RobotFile, both: Bench) -> None:
    right = point(arms, (0.0, 0.0, 0.02))
    x, y, z = right.position_m
    home_left = limb_models(arms, "left_arm")[0].tip_pose(np.radians(arms.reach.home_deg))[1]
    assert (x, -y, z - 0.02) == pytest.approx(tuple(home_left), abs=1e-5)
    left = msgspec.structs.replace(
        right, limb="left_arm", position_m=(x, -y, z), position_only=True, sequence=7
    )
    both.put(VIRTUAL_POINT, left)
    solution = both.last(IK_SOLUTION)
    assert (solution.limb, solution.status, solution.sequence) == ("left_arm", "converged", 7)
    hand = limb_models(arms, "left_arm")[0].tip_pose(np.array(solution.q_rad))[1]
    assert hand == pytest.approx([x, -y, z], abs=2e-4)


def test_both_arms_go_to_two_points_at_once(arms: RobotFile, both: Bench) -> None:
    x, y, z = point(arms, (0.0, 0.0, 0.0)).position_m
    for i in range(1, 11):
        pair = VirtualPoint(
            stamp_ns=0,
            sequence=i,
            position_m=(x, -y, z + 0.004 * i),
            velocity_m_s=(0.0, 0.0, 0.0),
            rotation_rad=(0.0, 0.0, 0.0),
            limb="both_arms",
            position_only=True,
            second_position_m=(x - 0.004 * i, y, z),
        )
        both.put(VIRTUAL_POINT, pair)
    solution = both.last(IK_SOLUTION)
    assert solution.status == "converged"
    assert len(solution.q_rad) == len(limb_joints(arms, "both_arms")) == 17
    left, right = (
        model.tip_pose(np.array(solution.q_rad))[1] for model in limb_models(arms, "both_arms")
    )
    assert left == pytest.approx([x, -y, z + 0.04], abs=2e-4)
    assert right == pytest.approx([x - 0.04, y, z], abs=2e-4)


def test_second_tip_of_a_limb_with_one_is_refused(robot: RobotFile, bench: Bench) -> None:
    good = point(robot, (0.0, 0.0, 0.0))
    bench.put(VIRTUAL_POINT, msgspec.structs.replace(good, second_position_m=(0.0, 0.0, 0.0)))
    bench.put(VIRTUAL_POINT, msgspec.structs.replace(good, limb="left_leg"))
    assert bench.sent(IK_SOLUTION) == []
    assert isinstance(bench.service, Ik)
    assert bench.service.refused == 2


def test_the_next_answer_honours_a_setup(robot: RobotFile, bench: Bench) -> None:
    bench.put(VIRTUAL_POINT, point(robot, (0.0, 0.0, 0.0), 1))
    before = bench.last(IK_SOLUTION)
    use(bench, LimbSetup(limb="", free=(False,) * 3 + (True,) * 7))
    for i in range(2, 12):
        bench.put(VIRTUAL_POINT, point(robot, (0.0, -0.004 * i, 0.0), i))
    solution = bench.last(IK_SOLUTION)
    assert solution.status == "converged"
    assert solution.q_rad[:3] == pytest.approx(before.q_rad[:3], abs=1e-12)


def test_a_tip_frame_is_attached_between_two_answers(robot: RobotFile, bench: Bench) -> None:
    bench.put(VIRTUAL_POINT, point(robot, (0.0, 0.0, 0.0), 1))
    use(bench, LimbSetup(limb="right_arm", tip_offsets=(TipOffset(position_m=(0.0, 0.0, 0.03)),)))
    for i in range(2, 12):
        bench.put(VIRTUAL_POINT, point(robot, (0.0, 0.0, 0.0), i))
    solution = bench.last(IK_SOLUTION)
    assert solution.status == "converged"
    R, p = limb_models(robot)[0].tip_pose(np.array(solution.q_rad))
    assert p + 0.03 * R[:, 2] == pytest.approx(point(robot, (0.0, 0.0, 0.0)).position_m, abs=2e-4)


def test_limits_narrowed_past_the_present_posture_are_kept_at_once(
    robot: RobotFile, bench: Bench
) -> None:
    bench.put(VIRTUAL_POINT, point(robot, (0.0, 0.0, 0.0), 1))
    upper = (9.0,) * 6 + (float(np.radians(30.0)),) + (9.0,) * 3
    use(bench, LimbSetup(limb="", upper_rad=upper))
    bench.put(VIRTUAL_POINT, point(robot, (0.0, 0.0, 0.0), 2))
    assert bench.last(IK_SOLUTION).q_rad[6] <= np.radians(30.0) + 1e-9


def test_a_setup_that_does_not_fit_is_refused_and_the_one_before_stays(
    robot: RobotFile, bench: Bench
) -> None:
    use(bench, LimbSetup(limb="", free=(False,) * 10))
    use(bench, LimbSetup(limb="", free=(True,)))
    bench.clock.sleep_until(1_000_000_000)
    bench.put(CARTESIAN_STATUS, heartbeat())
    expected = "free has 1 values; the limb has 10 joints"
    assert bench.last(IK_STATUS).setup_refused == expected
    stand(bench, arms_at(robot))
    bench.put(VIRTUAL_POINT, point(robot, (0.05, 0.0, 0.0)))
    assert bench.last(IK_SOLUTION).q_rad == pytest.approx(np.radians(robot.reach.home_deg))
    use(bench, LimbSetup(limb="", solver="magic"))
    use(bench, LimbSetup(limb="tail"))
    use(bench, LimbSetup(limb="", iterations=-1))
    bench.put(VIRTUAL_POINT, point(robot, (0.05, 0.0, 0.0)))
    assert len(bench.sent(IK_SOLUTION)) == 2


def test_a_blocked_joint_that_something_else_moves_is_taken_as_it_is(
    robot: RobotFile, bench: Bench
) -> None:
    use(bench, LimbSetup(limb="", free=(False,) * 3 + (True,) * 7))
    bench.put(VIRTUAL_POINT, point(robot, (0.0, 0.0, 0.0), 1))
    leaning = arms_at(robot, torso_deg=(5.0, 0.0, 0.5))
    stand(bench, leaning)
    bench.put(VIRTUAL_POINT, point(robot, (0.0, 0.0, 0.0), 2))
    torso = np.degrees(bench.last(IK_SOLUTION).q_rad[:3])
    assert torso == pytest.approx([5.0, 0.0, 0.0], abs=1e-9)  # half a degree is no move


def test_after_a_pause_it_starts_from_the_measured_posture_again(
    robot: RobotFile, bench: Bench
) -> None:
    bench.put(VIRTUAL_POINT, point(robot, (0.0, 0.0, 0.0), 1))
    bench.advance(1.0)
    stand(bench, arms_at(robot, torso_deg=(8.0, 0.0, 0.0)))
    use(bench, LimbSetup(limb="", free=(False,) * 10))
    bench.put(VIRTUAL_POINT, point(robot, (0.0, 0.0, 0.0), 2))
    assert np.degrees(bench.last(IK_SOLUTION).q_rad[0]) == pytest.approx(8.0)


def test_status_counts_ten_times_a_second(robot: RobotFile, bench: Bench) -> None:
    for i in range(1, 101):
        bench.put(VIRTUAL_POINT, point(robot, (0.0, -0.0005 * i, 0.0), i))
        bench.put(JOINT_STATE["torso"], arms_at(robot)["torso"])
        bench.advance(0.01)
    bench.put(VIRTUAL_POINT, point(robot, (float("inf"), 0.0, 0.0), 101))
    reports = bench.sent(IK_STATUS)
    assert len(reports) == 11
    assert (reports[-1].limb, reports[-1].solver, reports[-1].status) == (
        "right_arm",
        "sqp",
        "converged",
    )
    stream = reports[-1].stream
    assert (stream.solves, stream.converged, stream.refused, stream.missed) == (100, 100, 1, 0)
    assert 1 <= stream.iterations_p50 <= stream.iterations_p99 < 100
