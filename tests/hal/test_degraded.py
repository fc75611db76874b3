"""Robots that start, or go on, without some of their boards."""

import pytest
from msgspec.structs import replace

from hal.description import RobotDescription
from hal.readings import BoardReport
from tests.hal.arm import BUS, DESCRIPTION, PITCH, PROSUP
from tests.hal.emulated import EMULATED, Bench
from tests.hal.scripted import MS, Script, frame

FOREARM = "board r_forearm (bus 1, address 3)"


def optional(description: RobotDescription, *names: str) -> RobotDescription:
    boards = [replace(b, required=b.name not in names) for b in description.boards]
    return replace(description, boards=tuple(boards))


def report(script: Script, name: str) -> BoardReport:
    return next(board for board in script.robot.status().boards if board.name == name)


@pytest.fixture
def script() -> Script:
    """The forearm board is missing, and need not be there."""
    script = Script(optional(DESCRIPTION, "r_forearm"))
    del script.bus.answers[frame("003 5B0106")]
    script.bus.positions = {0x111: script.bus.positions[0x111]}
    return script


def test_starts_without_a_board_that_is_not_required(script: Script) -> None:
    script.open()

    status = script.robot.status()
    assert status.phase == "idle"
    assert status.faults == (
        f"{FOREARM} does not answer the handshake; the robot starts without prosup, wrist",
    )
    assert 1000 * MS <= script.now_ns <= 2000 * MS  # it gets a second


def test_says_why_an_axis_is_not_available(script: Script) -> None:
    script.open()

    task = script.robot.request("calibrate", ["prosup"])
    assert task.reason == f"prosup: {FOREARM} does not answer the handshake"
    assert script.robot.joints.fault[PROSUP] == f"{FOREARM} does not answer the handshake"
    assert script.robot.request("calibrate", ["pitch"]).ok


def test_reports_every_board(script: Script) -> None:
    script.open()

    shoulder, forearm, strain = script.robot.status().boards
    assert (shoulder.state, shoulder.reason) == ("needs calibration", "pitch, roll")
    assert (shoulder.found_type, shoulder.found_firmware, shoulder.build) == (4, (2, 0x50), 87)
    assert (shoulder.protocol, shoulder.firmware, shoulder.type) == ((1, 6), (2, 0x50), "bll_ie")
    assert (forearm.state, forearm.reason) == (
        "missing",
        f"{FOREARM} does not answer the handshake",
    )
    assert (forearm.found_type, forearm.found_firmware) == (None, None)
    assert (strain.state, strain.reason) == ("ok", "")


def test_starts_without_any_board_when_told_so() -> None:
    script = Script(replace(DESCRIPTION, allow_missing=True))
    script.bus.answers.clear()
    script.bus.positions = {}
    script.open()

    assert script.robot.phase == "idle"
    assert [board.state for board in script.robot.status().boards] == ["missing"] * 3


def test_starts_without_a_wrong_board_that_is_not_required() -> None:
    script = Script(optional(DESCRIPTION, "r_forearm"))
    script.bus.answers[frame("003 5B0106")] = frame("030 5B04021957010601")
    script.open()

    assert script.robot.phase == "idle"
    assert report(script, "r_forearm").state == "wrong"
    assert "is of type 4; the robot file says dc4" in report(script, "r_forearm").reason


def test_a_required_board_fails_with_the_name_of_each_that_is_missing() -> None:
    script = Script()
    del script.bus.answers[frame("003 5B0106")]
    script.open()

    assert script.robot.phase == "failed"
    assert report(script, "r_forearm").state == "missing"


def test_takes_a_board_in_that_is_plugged_later() -> None:
    bench = Bench(optional(EMULATED, "r_forearm"))
    board = bench.boards.board(BUS, 3)
    board.powered = False
    bench.open()
    assert bench.robot.phase == "idle"
    board.power_cycle()
    bench.tick(2500)

    assert (
        "r_forearm (bus 1, address 3) has restarted; it is configured again"
        in (bench.robot.status().faults[-1])
    )
    task = bench.robot.request("calibrate")
    bench.finish(task)
    assert task.ok, task.reason
    assert {board.state for board in bench.robot.status().boards} == {"ok"}
    bench.close()


def test_names_a_wrong_board_that_is_plugged_in_place_of_another() -> None:
    script = Script()
    script.ready()
    del script.bus.positions[0x111]
    script.bus.answers[frame("001 5B0106")] = frame("010 5B03021957010601")
    script.tick(1500)

    assert "is of type 3; the robot file says bll_ie" in script.robot.status().faults[-1]
    assert report(script, "r_shoulder").state == "wrong"


def test_a_board_passes_through_silent_and_restarted_to_ok(bench: Bench) -> None:
    def state() -> str:
        return bench.robot.status().boards[0].state

    bench.open()
    assert state() == "needs calibration"
    bench.calibrated()
    assert state() == "ok"
    bench.boards.board(BUS, 1).powered = False
    bench.tick(120)
    assert state() == "silent"
    bench.boards.board(BUS, 1).power_cycle()
    bench.tick(2000)
    assert state() == "restarted"
    task = bench.robot.request("calibrate", ["pitch", "roll"])
    bench.finish(task)
    assert state() == "ok"


def test_the_loss_of_a_board_leaves_the_streams_of_the_others_alone(ready: Bench) -> None:
    ready.robot.take_samples("r_arm_ft")
    ready.boards.board(BUS, 1).powered = False
    for _ in range(300):
        ready.tick(10)
        assert ready.robot.is_fresh(PROSUP, ready.now_ns)
        assert len(ready.robot.take_samples("r_arm_ft")) == 10
    assert not ready.robot.is_fresh(PITCH, ready.now_ns)


def test_finds_two_boards_at_one_address_while_it_opens() -> None:
    script = Script()
    script.tick(21)
    script.say("010 5B03021957010601")
    script.open()

    assert script.robot.phase == "failed"
    assert "two boards answer at one address" in script.robot.status().faults[-1]


def test_one_board_that_answers_twice_is_no_collision() -> None:
    """Questions that waited while no board had power leave all at once."""
    script = Script()
    script.tick(21)
    script.say("010 5B04025057010601", "010 5B04025057010601")
    script.open()

    assert script.robot.phase == "idle"


def test_opens_within_half_a_second() -> None:
    script = Script()
    script.open()

    assert script.now_ns < 400 * MS
