"""Requests: modes and why a board refuses them, moves, stop, idle, and what excludes what."""

import math

import pytest

from hal.robot import Robot
from tests.hal.arm import ROLL
from tests.hal.scripted import MS, Script

BACK_HOME = [math.radians(angle) for angle in (-1.0, 44.0, 74.0, 5.0)]


@pytest.fixture
def script() -> Script:
    script = Script()
    script.ready()
    return script


@pytest.fixture
def robot(script: Script) -> Robot:
    return script.robot


def commands(sent: list[str]) -> list[str]:
    return [one for one in sent if one.startswith("00")]


def test_is_done_when_the_board_confirms_the_mode(script: Script, robot: Robot) -> None:
    task = robot.request("mode", ["roll"], "direct")

    assert script.tick()[0] == "001 8908"  # its impedance offset follows in the same millisecond
    assert not task.done
    script.status(0x113, 0x01, 0x08)
    script.tick()
    assert (task.done, task.ok) == (True, True)


def test_asks_for_the_mode_when_status_is_lost(script: Script, robot: Robot) -> None:
    task = robot.request("mode", ["roll"], "direct")

    assert "001 87" in script.tick(60)
    script.say("010 870800")
    script.tick()
    assert task.ok
    assert task.done


def test_says_that_no_answer_came(script: Script, robot: Robot) -> None:
    task = robot.request("mode", ["roll"], "direct")

    assert 195 <= script.finish(task) <= 205
    assert task.reason == (
        "roll did not enter direct mode: no answer, or settings missing on the board "
        "(position gains, protocol handshake)"
    )


def test_says_that_the_emergency_button_is_pressed(script: Script, robot: Robot) -> None:
    script.status(0x113, 0x00, 0x00, 0x04, 0x04)
    script.tick()

    task = robot.request("mode", ["roll"], "position")
    script.finish(task)

    assert task.reason == "roll did not enter position mode: emergency button pressed"


def test_says_that_the_board_refused_with_a_hardware_fault(script: Script, robot: Robot) -> None:
    task = robot.request("mode", ["roll"], "direct")
    script.status(0x113, 0x01, 0xA0)
    script.finish(task)

    assert task.reason.startswith("roll went into hardware fault: no answer, or settings missing")


def test_refuses_to_power_a_joint_that_is_not_calibrated() -> None:
    script = Script()
    script.open()

    task = script.robot.request("mode", ["roll"], "position")

    assert task.reason == "roll is not calibrated"


def test_leaves_a_hardware_fault_with_force_idle_only(script: Script, robot: Robot) -> None:
    script.status(0x113, 0x01, 0xA0, 0, 0x20)
    script.tick()

    refused = robot.request("mode", ["roll"], "position")
    script.tick()
    assert refused.reason == (
        "roll is in hardware fault (absolute encoder read error): request mode idle first"
    )
    robot.request("mode", ["roll"], "idle")
    assert commands(script.tick())[0] == "001 8909"


def test_refuses_torque_mode_without_torques(robot: Robot) -> None:
    assert robot.request("mode", ["roll"], "torque").reason == "roll: no fresh joint torques"
    assert "prosup has no torque source" in robot.request("mode", ["prosup"], "torque").reason


@pytest.mark.parametrize(
    ("action", "joints", "value", "reason"),
    [
        ("dance", [], "", "unknown action 'dance'; known: calibrate, move, mode, interaction"),
        ("mode", ["roll"], "fast", "unknown mode 'fast'; known: idle, position, direct"),
        ("interaction", ["roll"], "soft", "unknown interaction 'soft'; known: stiff, compliant"),
        ("mode", ["roll", "roll"], "idle", "a joint is named twice"),
        ("mode", ["knee"], "idle", "unknown joint 'knee'; known: pitch, roll, prosup, wrist"),
    ],
)
def test_lists_the_alternatives(
    robot: Robot, action: str, joints: list[str], value: str, reason: str
) -> None:
    task = robot.request(action, joints, value)

    assert task.done
    assert task.reason.startswith(reason)


def test_refuses_a_second_task_on_the_same_joint(robot: Robot) -> None:
    robot.request("mode", ["roll"], "direct")

    assert robot.request("mode", ["roll", "pitch"], "velocity").reason == (
        "busy: mode uses one of these joints"
    )
    assert robot.request("mode", ["pitch"], "direct").ok


def test_moves_with_the_speed_that_the_duration_asks_for(script: Script, robot: Robot) -> None:
    task = robot.request("move", ["roll"], q_rad=[math.radians(54.0)], duration_s=1.0)

    assert commands(script.tick()) == ["001 9B0B0400000C00"]  # 115 ticks to 1035
    assert robot.joints.moving[ROLL]
    script.bus.positions[0x111] = bytes.fromhex("D10700000B040000")
    assert 1058 <= script.finish(task) <= 1065  # 100 * 115 / 12 ms, and 100 ms at rest
    assert task.ok
    assert not robot.joints.moving[ROLL]


def test_moves_no_faster_than_the_joint_may(script: Script, robot: Robot) -> None:
    robot.request("move", ["roll"], q_rad=[math.radians(54.0)], duration_s=0.01)

    # 10.12 deg with a peak of 60 deg/s takes 0.316 s: 115 ticks at 364 ticks/s
    assert commands(script.tick()) == ["001 9B0B0400002400"]


def test_says_how_far_a_move_fell_short(script: Script, robot: Robot) -> None:
    task = robot.request("move", ["roll"], q_rad=[math.radians(54.0)], duration_s=0.5)
    script.finish(task)

    assert task.reason == "roll stopped 0.176 rad short of its target"


def test_ends_a_move_when_the_joint_leaves_position_mode(script: Script, robot: Robot) -> None:
    task = robot.request("move", ["roll"], q_rad=[math.radians(54.0)], duration_s=5.0)
    script.tick(10)
    script.status(0x113, 0x01, 0x00, 0, 0x04)
    script.tick()

    assert task.reason == "roll left position mode during the move: emergency button pressed"


@pytest.mark.parametrize(
    ("q_rad", "reason"),
    [
        ([1.0, 2.0], "2 angles for 1 joints"),
        ([math.nan], "roll: nan rad is outside 0.0000 to 2.8100"),
        ([3.0], "roll: 3.0000 rad is outside 0.0000 to 2.8100"),
    ],
)
def test_refuses_a_posture_that_cannot_be_taken(
    robot: Robot, q_rad: list[float], reason: str
) -> None:
    assert robot.request("move", ["roll"], q_rad=q_rad, duration_s=1.0).reason == reason


def test_refuses_to_move_an_idle_joint(script: Script, robot: Robot) -> None:
    script.status(0x113, 0x01, 0x00)
    script.tick()

    assert robot.request("move", ["roll"], q_rad=[1.0]).reason == (
        "roll is idle: request mode position first"
    )


def test_stops_within_three_seconds_even_when_no_board_confirms(
    script: Script, robot: Robot
) -> None:
    task = robot.request("stop", q_rad=BACK_HOME)
    assert robot.phase == "stopping"

    assert script.finish(task) <= 3000
    assert "did not enter idle mode" in task.reason


def test_stops_by_moving_and_then_switching_off(script: Script, robot: Robot) -> None:
    task = robot.request("stop", ["roll"], q_rad=[math.radians(44.0)])
    moved = commands(script.tick(200))
    script.status(0x113, 0x01, 0x00)
    script.finish(task)

    assert moved[0] == "001 9B990300002400"
    assert moved[1] == "001 8909"
    assert task.ok


def test_stops_where_it_is_when_the_posture_is_wrong(script: Script, robot: Robot) -> None:
    robot.request("stop", ["roll"], q_rad=[9.0])

    assert commands(script.tick()) == ["001 8909", "001 D90000"]
    assert robot.status().faults == (
        "stop without moving: roll: 9.0000 rad is outside 0.0000 to 2.8100",
    )


def test_switches_off_at_once_and_ends_every_task(script: Script, robot: Robot) -> None:
    move = robot.request("move", ["roll"], q_rad=[1.0], duration_s=5.0)
    script.tick(5)
    robot.request("idle")

    assert move.reason == "ended by idle"
    assert commands(script.tick())[:4] == ["001 0909", "001 8909", "003 0909", "004 0909"]


def test_closes_with_every_axis_idle_and_every_board_silent(script: Script, robot: Robot) -> None:
    script.bus.sent.clear()
    robot.close(script.now_ns + MS)

    sent = [f"{can_id:03X} {data.hex().upper()}" for can_id, data in script.bus.sent]
    assert sent == [
        "001 0909",
        "001 8909",
        "001 4900000000",
        "003 0909",
        "004 0909",
        "003 4900000000",
        "20D 0701",
    ]
