"""Force and torque frames: pairs, physical values (worked examples 26 to 28), saturation."""

import pytest

from tests.hal.scripted import Script, frame


@pytest.fixture
def script() -> Script:
    script = Script()
    script.open()
    script.bus.wrench = []
    script.tick()
    script.robot.take_samples("r_arm_ft")
    return script


def test_makes_a_sample_of_a_pair_in_physical_units(script: Script) -> None:
    script.say("3DA 00803A7F4183", "3DB C4832C7E2A81")
    script.tick()

    (sample,) = script.robot.take_samples("r_arm_ft")
    assert sample.force_n == pytest.approx((0.0, -10.0, 50.0), abs=0.03)
    assert sample.torque_nm == pytest.approx((1.0, -0.5, 0.2), abs=0.001)
    assert (sample.saturated, sample.arrival_ns) == (False, script.now_ns)


def test_hands_every_sample_out_once(script: Script) -> None:
    for _ in range(3):
        script.say("3DA 00803A7F4183", "3DB C4832C7E2A81")
        script.tick()

    stamps = [sample.arrival_ns for sample in script.robot.take_samples("r_arm_ft")]
    assert stamps == [script.now_ns - 2_000_000, script.now_ns - 1_000_000, script.now_ns]
    assert script.robot.take_samples("r_arm_ft") == []


def test_drops_and_counts_a_force_frame_without_its_torque_frame(script: Script) -> None:
    script.say("3DA 008000800080", "3DA 00803A7F4183", "3DB C4832C7E2A81")
    script.tick()

    assert len(script.robot.take_samples("r_arm_ft")) == 1
    assert script.robot.status().drops == (("force frame without its torque frame", 1),)


def test_drops_and_counts_a_torque_frame_without_its_force_frame(script: Script) -> None:
    script.say("3DB C4832C7E2A81")
    script.tick()

    assert script.robot.take_samples("r_arm_ft") == []
    assert script.robot.status().drops == (("torque frame without its force frame", 1),)


def test_never_pairs_frames_of_different_periods(script: Script) -> None:
    script.say("3DA 00803A7F4183")
    script.tick(2)
    script.say("3DB C4832C7E2A81")
    script.tick()

    assert script.robot.take_samples("r_arm_ft") == []
    assert script.robot.status().drops == (
        ("force and torque frames more than one period apart", 1),
    )


def test_marks_a_saturated_sample_and_says_which_channel(script: Script) -> None:
    script.say("3DA 00803A7F418305", "3DB C4832C7E2A8121")
    script.tick()

    (sample,) = script.robot.take_samples("r_arm_ft")
    assert sample.saturated
    assert sample.channels == (1, 0, 0, 0, 2, 0)
    assert script.robot.status().faults == ("r_arm_ft saturated: Fx low, Ty high",)


def test_drops_a_pair_whose_length_is_wrong(script: Script) -> None:
    script.say("3DA 0080", "3DB C4832C7E2A81", "3DA 00803A7F4183", "3DB C483")
    script.tick()

    assert script.robot.take_samples("r_arm_ft") == []
    assert dict(script.robot.status().drops) == {
        "FORCE of wrong length": 1,
        "torque frame without its force frame": 1,
        "TORQUE of wrong length": 1,
    }


def test_ignores_acknowledgements_and_counts_what_it_cannot_read(script: Script) -> None:
    script.say("2D0 ", "2D0 77425547")
    script.tick()

    assert script.robot.status().drops == (("undecodable reply of a sensor", 1),)


def test_reports_a_sensor_that_restarted(script: Script) -> None:
    script.say("2D0 000000010000")
    script.tick()

    assert script.robot.status().faults == ("board r_strain (bus 1, address 13) has restarted",)


def test_reports_a_silent_sensor(script: Script) -> None:
    script.tick(120)

    (fault,) = script.robot.status().faults
    assert fault.startswith("board r_strain (bus 1, address 13) silent for 0.09")


def test_starts_the_stream_again_when_the_sensor_has_restarted(script: Script) -> None:
    script.tick(120)
    sent: list[str] = []
    for _ in range(1200):
        sent += script.tick()
        if "20D 0700" in sent:
            script.bus.wrench = [frame("3DA 008000800080"), frame("3DB 008000800080")]

    assert "20D 1C0100" in sent
    assert len(script.robot.take_samples("r_arm_ft")) > 10
    assert "has restarted; it is configured again" in script.robot.status().faults[-1]
