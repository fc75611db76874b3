"""`ulna joints` without a stack: its table, names, answers, and one sentence for what cannot be."""

import math

import msgspec
import pytest
from rich.console import Console

from services.cli.joint_names import able_to_comply, chosen_joints, in_fault
from services.cli.joint_requests import RefusedError, advice, is_done, progress_line
from services.cli.joint_tables import joint_table
from services.cli.main import main
from services.config import load_robot
from services.core.errors import ConfigError
from services.messages import JointState, Reply
from services.robot_messages import RobotRequest, RobotStatus

TORSO = ("torso_pitch", "torso_roll", "torso_yaw")
STATUS = RobotStatus(
    stamp_ns=0,
    phase="ready",
    calibrated=False,
    compliant=(),
    faults=(),
    fault_count=0,
    frames_received=0,
    frames_sent=0,
    frames_lost=0,
    frames_dropped=0,
    finished_task=6,
    failed_tasks=((5, "move: r_elbow is idle"),),
    calibration=(("torso_yaw", "done"), ("torso_roll", "pending"), ("torso_pitch", "done")),
)


def torso(*, valid: bool) -> JointState:
    return JointState(
        stamp_ns=0,
        q_rad=(math.pi / 6, 0.0, -math.pi / 4),
        dq_rad_s=(0.0, math.pi / 180, 0.0),
        tau_nm=(1.25, -2.0, math.nan),
        control_mode=(1, 0, 0xB7),
        compliant=(True, False, False),
        valid=valid,
    )


def rows(state: JointState, *joints: str) -> list[list[str]]:
    robot = load_robot("icub:torso")
    table = joint_table(robot, joints or TORSO, {"torso": state}, STATUS)
    return [list(row) for row in zip(*(column.cells for column in table.columns), strict=True)]


def test_each_joint_is_shown_in_degrees_with_torque_and_mode() -> None:
    assert rows(torso(valid=True)) == [
        ["torso", "", "", "", "", "", ""],
        ["  torso_pitch", "30.00", "0.00", "1.25", "position", "yes", "yes"],
        ["  torso_roll", "0.00", "1.00", "-2.00", "idle", "", "yes"],
        ["  torso_yaw", "-45.00", "0.00", "", "0xB7", "", "yes"],
    ]


def test_a_joint_that_is_not_valid_is_shown_with_its_calibration() -> None:
    assert [row[-1] for row in rows(torso(valid=False))] == ["", "no", "pending", "no"]


def test_only_the_joints_that_are_asked_for_are_shown() -> None:
    names = [row[0] for row in rows(torso(valid=True), "torso_roll")]
    assert names == ["torso", "  torso_roll"]


def test_parts_and_joints_are_named_alike_and_count_once() -> None:
    robot = load_robot("icub:reach")
    assert chosen_joints(robot, ("torso_roll", "torso")) == (
        "torso_roll",
        "torso_pitch",
        "torso_yaw",
    )
    assert set(robot.chain) <= set(chosen_joints(robot, ()))


def test_an_unknown_name_is_told_with_the_parts_and_joints_of_the_stack() -> None:
    with pytest.raises(
        ConfigError, match=r"'nose' here; parts: torso; joints: torso_pitch, torso_"
    ):
        chosen_joints(load_robot("icub:torso"), ("nose",))


def test_joints_in_hardware_fault_are_found_among_those_asked_for() -> None:
    robot = load_robot("icub:torso")
    state = msgspec.structs.replace(torso(valid=True), control_mode=(1, 0xA0, 0xA0))
    assert in_fault(robot, TORSO, {"torso": state}) == ("torso_roll", "torso_yaw")
    assert in_fault(robot, TORSO[:2], {"torso": state}) == ("torso_roll",)
    assert in_fault(robot, TORSO, {"torso": torso(valid=True)}) == ()


def test_of_a_part_those_joints_comply_that_have_torques_and_a_spring() -> None:
    robot = load_robot("icub:right_arm")
    arm = robot.parts["right_arm"]
    able = able_to_comply(robot, arm, ())
    assert "r_elbow" in able
    assert all(robot.joints[joint].impedance is not None for joint in able)
    assert able_to_comply(robot, arm[-1:], arm[-1:]) == arm[-1:]  # asked for by name: the HAL says
    head = load_robot("icub:head")
    with pytest.raises(ConfigError, match="no joint of head can be compliant"):
        able_to_comply(head, head.parts["head"], ("head",))


def test_a_task_is_done_when_every_task_up_to_it_has_ended() -> None:
    assert is_done("home", STATUS, 6)
    assert not is_done("home", STATUS, 7)


def test_a_task_that_has_failed_is_told_with_the_reason() -> None:
    with pytest.raises(RefusedError, match=r"^home failed: r_elbow is idle$"):
        is_done("home", STATUS, 5)


def test_a_calibration_shows_how_many_of_the_joints_asked_for_are_done() -> None:
    request = RobotRequest(action="calibrate", joints=("torso_yaw", "torso_roll"))
    assert progress_line("calibrate", request, STATUS) == "calibrate: 1 of 2 joints calibrated"


@pytest.mark.parametrize(
    ("reason", "verb"),
    [
        ("r_elbow is not calibrated", "ulna joints calibrate"),
        ("r_elbow is idle: request mode position first", "ulna joints calibrate"),
        ("r_elbow: no fresh joint torques", "ulna dynamics calibrate"),
    ],
)
def test_a_refusal_names_the_verb_that_mends_it(reason: str, verb: str) -> None:
    assert verb in advice(RobotRequest(action="move"), Reply(ok=False, reason=reason))


def test_a_terminal_of_80_columns_holds_the_table(capsys: pytest.CaptureFixture[str]) -> None:
    table = joint_table(load_robot("icub:torso"), TORSO, {"torso": torso(valid=True)}, STATUS)
    Console(width=80).print(table)
    lines = capsys.readouterr().out.splitlines()
    assert len(lines) == 7  # title, headings, rule, part, three joints: nothing is folded


@pytest.mark.parametrize(
    "word", ["status", "calibrate", "home", "direct", "compliant", "stiff", "park"]
)
def test_without_a_stack_every_verb_says_how_to_start_one(
    word: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["joints", word, "--stack", "nobody"]) == 2
    error = capsys.readouterr().err
    assert error.startswith("ulna: no stack named 'nobody' is up here")
    assert "start one with `ulna up`" in error
