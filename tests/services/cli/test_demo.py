"""The demo's command line: what it refuses, and what it says of a result."""

from pathlib import Path

import pytest

from services.cli.demo import succeeded, table, verdict
from services.cli.main import main
from services.reaching.reach_record import Report

GOOD: Report = {
    "reached": True,
    "board_faults": 0,
    "frames_lost": 0,
    "min_arm_clearance_mm": 6.0,
    "min_clearance_mm": 12.0,
    "failure": "",
    "ik_status": "converged",
    "ik_position_error_mm": 0.1,
    "field_mode": "ulna",
    "field_state": "arrived",
    "field_reason": "",
    "field_distance_mm": 0.1,
    "wall": {
        "ik_ms_p50": 0.3,
        "ik_ms_p99": 0.5,
        "torque_loop_ms_p50": None,
        "torque_loop_ms_p99": None,
        "tick_late_us_p50": None,
        "tick_late_us_p99": None,
        "realtime_factor": 5.0,
    },
}


@pytest.mark.parametrize(
    ("arguments", "expected"),
    [
        (["--virtual", "--can", "zenoh"], "--virtual uses the memory bus"),
        (["--virtual", "--target", "1,2"], "--target: expected X,Y,Z in metres, got '1,2'"),
        (["--virtual", "--target", "nan,0,0"], "--target: expected X,Y,Z"),
        (["--virtual", "--obstacle", "0,0,0"], "--obstacle: expected X,Y,Z,R"),
        (["--virtual", "--obstacle", "0,0,0,-1"], "the radius must be positive"),
        (["--virtual", "--hop-ms", "0"], "--hop-ms: 0 is outside 1..20"),
        (["--virtual", "--robot", "coman"], "known robots: icub"),
        (["--can", "memory"], "unknown transport 'memory'; allowed: zenoh, socketcan"),
        (["--virtual", "--one-process"], "--one-process runs by the wall clock"),
    ],
)
def test_wrong_arguments_are_one_sentence_and_status_2(
    arguments: list[str], expected: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["demo", "reach", *arguments]) == 2
    assert expected in capsys.readouterr().err


def test_negative_coordinates_are_no_options(capsys: pytest.CaptureFixture[str]) -> None:
    arguments = ["--virtual", "--target", "-0.4,0.1,0.0", "--obstacle", "-0.4"]
    assert main(["demo", "reach", *arguments]) == 2
    assert "--obstacle: expected X,Y,Z,R in metres, got '-0.4'" in capsys.readouterr().err


def test_success_needs_no_fault_no_loss_and_no_contact() -> None:
    assert succeeded(GOOD)
    for spoilt in (
        {"reached": False},
        {"board_faults": 1},
        {"frames_lost": 1},
        {"min_clearance_mm": 0.0},
        {"min_arm_clearance_mm": -1.0},
    ):
        assert not succeeded(GOOD | spoilt)
    assert succeeded(GOOD | {"min_arm_clearance_mm": -1.0, "field_mode": "dforc"})


def test_verdict_says_why_not() -> None:
    assert "out of reach" in verdict(
        GOOD | {"reached": False, "ik_status": "infeasible", "ik_position_error_mm": 31.4}
    )
    reason = "no posture has the hand there within the limits"
    unreachable = {"field_state": "unreachable", "field_reason": reason, "field_distance_mm": 52.3}
    assert f"{reason}; 52.3 mm" in verdict(GOOD | {"reached": False} | unreachable)
    assert "board x silent" in verdict(GOOD | {"reached": False, "failure": "board x silent"})


def test_table_shows_missing_figures_as_dashes() -> None:
    cells = [list(column.cells) for column in table(GOOD).columns]
    assert cells[1][cells[0].index("torque loop, median / p99")] == "- / -"


def test_a_bus_that_cannot_be_opened_is_named(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    text = (Path(__file__).parents[3] / "robots" / "icub" / "robot.toml").read_text("utf-8")
    robot = tmp_path / "robot.toml"
    robot.write_text(text.replace('"vcan0"', '"nocan0"').replace('"vcan2"', '"nocan2"'), "utf-8")
    arguments = ["--can", "socketcan", "--one-process", "--robot", str(robot)]
    assert main(["demo", "reach", *arguments]) == 2
    assert "nocan0" in capsys.readouterr().err


def test_refuses_a_robot_without_the_reaching_arm(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["demo", "reach", "--virtual", "--robot", "icub:left_leg"]) == 2
    assert "reaching needs torso, right_arm, too" in capsys.readouterr().err


def test_refuses_a_robot_with_real_boards(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["demo", "reach", "--robot", "icub@real"]) == 2
    assert "neck is no emulated board" in capsys.readouterr().err


def test_refuses_a_report_in_a_missing_folder(
    capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    assert main(["demo", "reach", "--virtual", "--json", str(tmp_path / "no" / "r.json")]) == 2
    assert "there is no folder" in capsys.readouterr().err
