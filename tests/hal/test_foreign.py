"""Another host on the bus."""

import pytest

from tests.hal.scripted import Script


@pytest.fixture
def script() -> Script:
    script = Script()
    script.ready()
    return script


def test_counts_and_reports_a_frame_that_imitates_the_host(script: Script) -> None:
    script.say("001 1E0000")
    script.tick()

    status = script.robot.status()
    assert status.foreign_frames == 1
    assert status.faults == (
        "foreign host: 1 frames, the last on bus 1: host to board 1: SET_P_GAIN axis 0 kp=0",
    )
    assert status.drops == ()


def test_reports_once_per_second(script: Script) -> None:
    for _ in range(1500):
        script.say("001 1E0000")
        script.tick()

    assert script.robot.status().foreign_frames == 1500
    assert script.robot.status().fault_count == 2


def test_writes_the_settings_of_that_axis_again(script: Script) -> None:
    script.say("001 1E0000")
    sent = script.tick(60)

    assert sent[0] == "001 1E007D"
    assert "001 4977000000" in sent
    assert not [one for one in sent if one.startswith("001 9") or one.startswith("003")]


def test_writes_at_most_once_per_second(script: Script) -> None:
    sent: list[str] = []
    for _ in range(900):
        script.say("001 1E0000")
        sent += script.tick()

    assert sent.count("001 1E007D") == 1


def test_writes_nothing_when_the_foreign_host_only_asks(script: Script) -> None:
    script.say("001 14", "20D 1800", "001 5B0106")

    assert script.tick(60) == []
    assert script.robot.status().foreign_frames == 3


def test_starts_a_sensor_again_that_a_foreign_host_has_stopped(script: Script) -> None:
    script.say("20D 0701")

    assert script.tick(60) == ["20D 0801", "20D 0700"]


def test_wakes_every_board_after_a_foreign_discovery(script: Script) -> None:
    script.say("70F FF")
    sent = script.tick(80)

    assert {"001 4977000000", "003 4975000000", "004 4975000000", "20D 0700"} <= set(sent)
    assert {"001 07", "001 87", "003 07", "004 07"} <= set(sent)  # are they still powered?


def test_notices_torques_that_are_not_ours(script: Script) -> None:
    script.say("3CA 008000800080", "3CB 008000800080")
    script.tick()

    assert script.robot.status().foreign_frames == 2


def test_writes_again_what_a_foreign_handshake_with_another_protocol_spoils(script: Script) -> None:
    script.say("001 5B0209")

    assert "001 5B0106" in script.tick(60)
