"""`ulna ik` without a stack: it solves the robot's model, and says what is no request."""

import pytest
from rich.console import Console

from services.cli.ik_client import solve_here
from services.cli.ik_tables import answer_table, status_table, verdict
from services.cli.main import main
from services.config import load_robot
from services.messages import ServiceStats
from services.reaching.messages import (
    IkAnswer,
    IkRequest,
    IkStatistics,
    IkStatusReport,
    PoseTarget,
    TipPose,
)

HERE = ("--position", "-0.3", "0.2", "0.05")
ASK = ("ik", "ask", "--robot", "icub")


def answer(status: str = "converged", reason: str = "") -> IkAnswer:
    return IkAnswer(
        q_rad=(),
        status=status,
        position_error_m=0.0123,
        orientation_error_rad=0.5,
        distance_rad=0.0,
        iterations=17,
        reason=reason,
    )


def shown(table: object) -> str:
    console = Console(width=100)
    with console.capture() as captured:
        console.print(table)
    return captured.get()


def test_a_pose_in_reach_is_answered_joint_by_joint(capsys: pytest.CaptureFixture[str]) -> None:
    assert main([*ASK, *HERE]) == 0
    said = capsys.readouterr().out
    assert "right_arm: icub's model, no stack" in said
    assert "r_wrist_yaw" in said
    assert "converged: position 0.0" in said


def test_a_pose_out_of_reach_is_status_1(capsys: pytest.CaptureFixture[str]) -> None:
    assert main([*ASK, "--position", "-3", "0", "0", "--dof", "7"]) == 1
    said = capsys.readouterr().out
    assert "m away; not reachable with all joints either" in said


def test_the_left_hand_is_asked_for_alone_or_with_the_right_one(
    capsys: pytest.CaptureFixture[str],
) -> None:
    left = ("--position", "-0.3", "-0.2", "0.05")
    assert main([*ASK, "--limb", "left_arm", *left]) == 0
    assert "r_elbow" not in capsys.readouterr().out
    second = ("--second-position", "-0.3", "0.2", "0.1")
    assert main([*ASK, "--limb", "both_arms", *left, *second]) == 0
    said = capsys.readouterr().out
    assert "l_elbow" in said
    assert "r_elbow" in said


@pytest.mark.parametrize(
    ("words", "expected"),
    [
        ((), "no pose is given: --position, --rotation or --axis-angle"),
        ((*HERE, "--limb", "tail"), "unknown limb 'tail'; among the parts in use: left_arm"),
        ((*HERE, "--dof", "0"), "--dof: 0 is outside 1..10"),
        ((*HERE, "--dof", "11"), "--dof: 11 is outside 1..10"),
        ((*HERE, "--hold", "l_elbow"), "--hold: unknown joint 'l_elbow'; known: torso_pitch"),
        ((*HERE, "--start", "1,2"), "start has shape (2,), expected (10,)"),
        ((*HERE, "--start", "1,x"), "--start: '1,x' is no list of angles such as 0,30,-45"),
        ((*HERE, "--deadline-ms", "-1"), "a deadline of -1.0 ms"),
        (("--axis-angle", "0", "0", "0", "1"), "about an axis of length 0"),
        (("--rotation", "0", "0", "0", "--axis-angle", "0", "0", "1", "0"), "not both"),
        (("--position", "nan", "0", "0"), "target position is not finite"),
        ((*HERE, "--second-position", "0", "0", "0"), "2 tips; the limb has 1"),
    ],
)
def test_what_cannot_be_asked_is_one_sentence(
    words: tuple[str, ...], expected: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main([*ASK, *words]) == 2
    said = capsys.readouterr().err.splitlines()
    assert len(said) == 1
    assert expected in said[0]


def test_an_unknown_robot_lists_the_known_ones(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["ik", "ask", "--robot", "coman", *HERE]) == 2
    assert "known robots: icub" in capsys.readouterr().err


def test_the_table_has_start_and_range_of_each_joint() -> None:
    robot = load_robot("icub")
    pose = PoseTarget(tips=(TipPose(position_m=(-0.3, 0.2, 0.05)),))
    reply, took_ms = solve_here(robot, IkRequest(poses=(pose,), limb="right_arm"))
    assert 0.0 < took_ms < 1000.0
    table = answer_table(robot, "right_arm", reply, "here")
    assert list(table.columns[0].cells) == list(robot.chain)
    assert list(table.columns[2].cells)[6] == "45.00"  # the elbow at home
    assert list(table.columns[4].cells)[6] == "105.00"  # 106 less two margins of half a degree


def test_a_held_joint_stays_at_its_start(capsys: pytest.CaptureFixture[str]) -> None:
    start = "0,0,0,-30,40,5,60,0,0,0"
    assert main([*ASK, *HERE, "--start", start, "--hold", "r_elbow"]) in (0, 1)
    (elbow,) = (line for line in capsys.readouterr().out.splitlines() if "r_elbow" in line)
    assert elbow.split()[:3] == ["r_elbow", "60.00", "60.00"]


def test_the_verdict_has_errors_cost_and_reason() -> None:
    assert verdict(answer(), 0.25) == (
        "converged: position 12.30 mm off, orientation 28.65 deg off, 17 iterations, 0.25 ms"
    )
    assert verdict(answer("infeasible", "too far"), None).endswith("17 iterations\ntoo far")


def test_the_status_has_points_and_requests() -> None:
    report = IkStatusReport(
        stamp_ns=0,
        limb="right_arm",
        solver="sqp",
        joints=(),
        status="infeasible",
        reason="",
        stream=IkStatistics(solves=123, converged=120, infeasible=3, iterations_p99=55.0),
        requests=IkStatistics(solves=7, missed=2),
        waiting=4,
    )
    stats = ServiceStats(
        stamp_ns=0,
        process="ik",
        steps=9,
        step_ms_p50=0.125,
        step_ms_p99=1.5,
        late_us_p50=0.0,
        late_us_p99=0.0,
        tick_slips=0,
    )
    said = shown(status_table(report, stats))
    assert "ik: right_arm, sqp; newest point: infeasible" in said
    assert "4 poses wait; a step takes 0.12 ms, 1 in 100 1.50" in said
    rows = {line[:30].strip(): line[30:].split() for line in said.splitlines()}
    assert rows["all"] == ["123", "7"]
    assert rows["used up their budget"] == ["0", "2"]


def test_status_needs_a_stack(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["ik", "status", "--stack", "nobody"]) == 2
    assert "start one with `ulna up`" in capsys.readouterr().err
