"""Silent boards and lost buses."""

import can
import pytest

from tests.hal.arm import PITCH
from tests.hal.scripted import Script, frame

SHOULDER = "board r_shoulder (bus 1, address 1)"


@pytest.fixture
def script() -> Script:
    script = Script()
    script.ready()
    return script


def to_shoulder(sent: list[str]) -> list[str]:
    return [one for one in sent if one.startswith("001")]


def test_names_a_silent_board_within_100_ms(script: Script) -> None:
    del script.bus.positions[0x111]
    script.tick(85)
    assert script.robot.status().faults == ()
    script.tick(15)

    (fault,) = script.robot.status().faults
    assert fault.startswith(f"{SHOULDER} silent for 0.09")
    assert not script.robot.is_fresh(PITCH, script.now_ns)
    assert script.robot.joints.fault[PITCH] == "board silent"


def test_shows_the_last_frames_of_a_silent_board(script: Script) -> None:
    del script.bus.positions[0x111]
    script.tick(120)

    frames = script.robot.fault_events[-1].frames
    assert any("POSITION position0=2001 tick, position1=920 tick" in line for line in frames)


def test_sends_a_silent_board_nothing_but_a_handshake(script: Script) -> None:
    del script.bus.positions[0x111]
    del script.bus.answers[frame("001 5B0106")]
    script.tick(120)

    assert not script.robot.request("mode", ["pitch"], "direct").ok
    assert set(to_shoulder(script.tick(1500))) == {"001 5B0106"}


def test_counts_commands_to_a_silent_board(script: Script) -> None:
    del script.bus.positions[0x111]
    script.tick(120)
    script.finish(script.robot.request("mode", ["pitch"], "idle"))

    # At once, with its impedance offset behind it, and three times the question for the mode.
    assert dict(script.robot.status().refusals)["command to a silent board"] >= 3


def test_takes_a_board_back_that_talks_again(script: Script) -> None:
    positions = script.bus.positions.pop(0x111)
    script.tick(150)
    script.bus.positions[0x111] = positions
    script.tick(50)

    assert script.robot.status().faults[-1] == f"{SHOULDER} is back; it has kept its settings"
    assert script.robot.is_fresh(PITCH, script.now_ns)


def test_configures_a_board_again_that_has_restarted(script: Script) -> None:
    positions = script.bus.positions.pop(0x111)
    script.bus.answers[frame("001 38")] = frame("010 38000000")  # calibration lost
    sent: list[str] = []
    while "001 4977000000" not in sent:  # its mask
        sent = to_shoulder(script.tick())
    script.bus.positions[0x111] = positions
    script.tick(100)

    assert script.robot.status().faults[-1] == (
        f"{SHOULDER} has restarted; it is configured again, its axes are idle"
    )
    assert not script.robot.joints.calibrated[PITCH]


def test_tells_missing_positions_from_a_silent_board(script: Script) -> None:
    del script.bus.positions[0x111]
    for _ in range(120):
        script.status(0x113, 0xA0, 0x01, 0x20)
        script.tick()

    assert script.robot.status().faults[-1].startswith(f"{SHOULDER} sends no POSITION for 0.09")
    assert script.robot.status().faults[-1].endswith("(it has an absolute encoder error)")


def test_reports_lost_frames_once_per_second(script: Script) -> None:
    for _ in range(50):
        script.bus.lost += 1
        script.tick(10)

    assert script.robot.status().frames_lost == 50
    assert script.robot.status().faults == ("bus 1 lost 1 frames (1 in all)",)


def test_sends_nothing_while_the_bus_is_off_and_says_so(script: Script) -> None:
    script.bus.bus_state = can.BusState.ERROR
    script.tick(10)

    script.robot.request("mode", ["pitch"], "direct")
    assert script.tick(50) == []
    assert script.robot.status().faults == ("bus 1 is off: no frame gets through",)
    script.bus.bus_state = can.BusState.ACTIVE
    script.tick(10)
    assert script.robot.status().faults[-1] == "bus 1 is back"


def test_counts_set_points_for_a_silent_board(script: Script) -> None:
    script.status(0x113, 0x08, 0x08)
    script.tick()
    del script.bus.positions[0x111]
    script.tick(120)
    before = dict(script.robot.status().refusals).get("command to a silent board", 0)
    script.robot.set_positions([PITCH], [-0.02])

    assert to_shoulder(script.tick(5)) == []
    assert dict(script.robot.status().refusals)["command to a silent board"] == before + 1


def test_sends_nothing_on_a_bus_that_is_off_and_counts_every_frame(script: Script) -> None:
    script.bus.bus_state = can.BusState.ERROR
    script.tick(15)
    script.torques()

    assert script.tick() == []
    assert dict(script.robot.status().refusals) == {"frame while bus 1 is off": 2}


def test_reports_a_silence_right_after_the_emergency_button(script: Script) -> None:
    script.say("113 0400040000000000")
    script.tick()
    del script.bus.positions[0x111]
    script.tick(120)

    assert script.robot.status().faults[-1].startswith(f"{SHOULDER} silent for 0.09")


def test_takes_the_answers_to_two_handshakes_for_those_of_one_board(script: Script) -> None:
    del script.bus.positions[0x111]
    script.bus.answers[frame("001 38")] = frame("010 38000000")
    script.tick(1500)

    assert not [text for text in script.robot.status().faults if "two boards" in text]
