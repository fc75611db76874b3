"""Virtual torques: bytes, the age limit, and compliant mode."""

import math
from dataclasses import dataclass

import pytest

from hal.robot import Robot
from tests.hal.arm import BUS, DESCRIPTION, PITCH, PROSUP, ROLL
from tests.hal.scripted import MS, Script, ScriptedBus


@pytest.fixture
def script() -> Script:
    script = Script()
    script.ready()
    return script


def commands(sent: list[str]) -> list[str]:
    return [one for one in sent if one.startswith("00")]


def make_compliant(script: Script, name: str, confirmation: str) -> list[str]:
    script.torques()
    task = script.robot.request("interaction", [name], "compliant")
    sent = commands(script.tick())
    script.say(confirmation)
    script.torques()
    sent += commands(script.tick())
    assert task.ok
    assert task.done
    return sent


def test_sends_both_frames_at_every_update(script: Script) -> None:
    assert script.robot.set_joint_torques([PITCH, ROLL], [4.0, -2.0], script.now_ns)

    assert script.tick() == ["3CA FFBF01600080", "3CB 008000800080"]  # as in example 23
    assert script.tick() == []


def test_keeps_the_torques_for_the_joint_readings(script: Script) -> None:
    assert math.isnan(script.robot.joints.tau_nm[PITCH])
    script.robot.set_joint_torques([PITCH, PROSUP], [4.0, 0.1], script.now_ns)

    assert script.robot.joints.tau_nm[PITCH] == 4.0
    assert script.robot.joints.tau_nm[PROSUP] == 0.1


def test_clamps_a_torque_beyond_the_full_scale_and_counts_it(script: Script) -> None:
    script.robot.set_joint_torques([PITCH, ROLL], [9.0, -9.0], script.now_ns)

    assert script.tick() == ["3CA FFFF01000080", "3CB 008000800080"]
    assert dict(script.robot.status().clamped) == {"joint torque": 2}


def test_refuses_torques_that_are_not_finite(script: Script) -> None:
    assert not script.robot.set_joint_torques([PITCH, ROLL], [math.nan, 0.0], script.now_ns)

    assert script.tick() == []
    assert script.robot.status().faults == ("refused joint torques not finite: pitch",)


@dataclass
class Watch:
    """A clock for the one measurement that the HAL takes."""

    ns: int

    def now_ns(self) -> int:
        return self.ns


def test_measures_from_the_arrival_of_the_sample_to_the_end_of_sending() -> None:
    watch = Watch(ns=0)
    robot = Robot(DESCRIPTION, {BUS: ScriptedBus()}, watch.now_ns)
    robot.set_joint_torques([PITCH, ROLL], [0.0, 0.0], arrival_ns=5 * MS)
    watch.ns = 6 * MS + 250_000
    robot.step(6 * MS)

    assert robot.status().torque_loop_ms == (1.25,)
    assert robot.status().torque_loop_ms == ()


def test_switches_to_compliant_with_the_offset_in_the_same_millisecond(script: Script) -> None:
    script.robot.set_impedance_offsets([PITCH, ROLL], [1.0, -0.5])
    sent = make_compliant(script, "roll", "11C 10")

    assert sent[:2] == ["001 F401", "001 D900F8"]  # compliant, -2048


def test_asks_for_the_interaction_mode_when_the_confirmation_was_lost(script: Script) -> None:
    script.torques()
    task = script.robot.request("interaction", ["roll"], "compliant")
    assert "001 F5" not in script.tick(48)
    assert "001 F5" in script.tick(4)
    script.say("010 F50100")
    script.torques()
    script.tick()

    assert (task.done, task.ok) == (True, True)


def test_sends_spring_and_offset_again_once_the_board_has_confirmed(script: Script) -> None:
    script.robot.set_impedance_offsets([PITCH, ROLL], [1.0, -0.5])
    sent = make_compliant(script, "roll", "11C 10")

    assert sorted(sent[2:]) == ["001 D79000332A000000", "001 D900F8"]


def test_sends_the_offset_of_a_compliant_axis_once_per_10_ms(script: Script) -> None:
    make_compliant(script, "roll", "11C 10")
    sent: list[str] = []
    for ms in range(50):
        script.torques()
        script.robot.set_impedance_offsets([ROLL], [0.1 + ms / 1000])
        sent += commands(script.tick())

    assert len([one for one in sent if one.startswith("001 D9")]) == 5


def test_sends_no_offset_to_a_stiff_axis(script: Script) -> None:
    script.robot.set_impedance_offsets([PITCH, ROLL], [1.0, 1.0])

    assert script.tick(50) == []


def test_refuses_compliant_without_a_torque_source(script: Script) -> None:
    script.torques()

    task = script.robot.request("interaction", ["prosup"], "compliant")

    assert task.reason == (
        "prosup has no torque source, torque gains or impedance in the robot file"
    )


def test_refuses_compliant_while_torques_are_not_fresh(script: Script) -> None:
    script.torques()
    script.tick(62)

    task = script.robot.request("interaction", ["roll"], "compliant")

    assert (task.done, task.reason) == (True, "roll: no fresh joint torques")


def test_makes_compliant_axes_stiff_when_torques_are_60_ms_late(script: Script) -> None:
    make_compliant(script, "roll", "11C 10")

    assert "001 F400" not in script.tick(59)
    sent = script.tick(2)

    assert sent[:3] == ["001 F400", "3CA 008000800080", "3CB 008000800080"]
    assert script.robot.status().faults[-1] == "torques 0.061 s old: roll made stiff"


def test_repeats_the_last_torques_until_the_board_confirms(script: Script) -> None:
    make_compliant(script, "roll", "11C 10")
    script.tick(100)

    assert [one[:3] for one in script.tick(20)].count("3CA") == 2
    script.say("11C 00")
    script.tick()
    assert script.tick(50) == []


def test_says_once_that_torques_are_late(script: Script) -> None:
    make_compliant(script, "roll", "11C 10")
    script.tick(300)

    assert script.robot.status().fault_count == 1


def test_counts_a_torque_as_old_as_its_sample(script: Script) -> None:
    make_compliant(script, "roll", "11C 10")
    old_ns = script.now_ns
    sent: list[str] = []
    for _ in range(70):
        script.robot.set_joint_torques([PITCH, ROLL], [0.0, 0.0], old_ns)
        sent += script.tick()

    assert "001 F400" in sent
