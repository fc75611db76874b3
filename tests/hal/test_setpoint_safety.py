"""Set-points near limits, out of date, or in the middle of a switch."""

import math
from itertools import pairwise

import pytest

from tests.hal.arm import PITCH, ROLL, WRIST
from tests.hal.scripted import Script

LOW_TICKS, HIGH_TICKS = 421, 2252  # roll: 0 and 161 deg
FASTEST_TICKS = 6.825  # 60 deg/s for 10 ms
BRAKING_CYCLES = 60  # 0.6 s


@pytest.fixture
def script() -> Script:
    script = Script()
    script.ready(mode=0x08)
    return script


def commands(sent: list[str]) -> list[str]:
    return [one for one in sent if one.startswith("00")]


def references(sent: list[str]) -> list[int]:
    direct = [one for one in sent if one.startswith("001 BE")]
    return [int.from_bytes(bytes.fromhex(one[6:14]), "little") for one in direct]


def roll_at(script: Script, ticks: int, mode: int) -> None:
    script.bus.positions[0x111] = bytes.fromhex("D1070000") + ticks.to_bytes(4, "little")
    script.tick(4)
    script.status(0x113, 0x01, 0x01)
    script.tick()
    script.status(0x113, mode, mode)
    script.tick()


def test_a_reference_brakes_towards_the_limit_and_reaches_it(script: Script) -> None:
    script.robot.set_positions([ROLL], [math.radians(161.0)])
    sent = references(script.tick(6000))

    assert sent[-1] == HIGH_TICKS
    for before, after in pairwise(sent):
        assert after - before <= (HIGH_TICKS - before) / BRAKING_CYCLES + 1.5  # rounded twice


def test_a_reference_leaves_a_limit_at_full_speed(script: Script) -> None:
    roll_at(script, LOW_TICKS, 0x08)
    script.robot.set_positions([ROLL], [math.radians(100.0)])
    sent = references(script.tick(100))

    assert sent[-1] - LOW_TICKS == pytest.approx(10 * FASTEST_TICKS, abs=1.0)


def test_a_velocity_towards_the_lower_limit_is_slowed_down(script: Script) -> None:
    roll_at(script, LOW_TICKS, 0x02)
    script.robot.set_velocities([ROLL], [math.radians(-30.0)])

    assert script.tick() == ["001 9C00000100"]


def test_no_reference_goes_out_while_the_mode_is_being_switched(script: Script) -> None:
    task = script.robot.request("mode", ["roll"], "position")
    script.tick()
    assert script.robot.set_positions([ROLL], [math.radians(44.0)])

    assert references(script.tick(20)) == []
    assert not task.done


def test_torque_mode_lasts_while_set_points_come(script: Script) -> None:
    script.torques()
    script.status(0x113, 0x03, 0x03)
    script.tick()
    sent: list[str] = []
    for ms in range(400):
        if ms % 50 == 0:
            script.robot.set_torques([PITCH, ROLL], [0.1, 0.1])
        script.torques()
        sent += commands(script.tick())

    assert {one[4:6] for one in sent} == {"2C", "AC"}
    assert script.robot.status().faults == ()


def test_a_torque_for_a_joint_without_torque_source_is_refused(script: Script) -> None:
    script.status(0x143, 0x03, 0x03)  # somebody else has put it there
    script.tick()

    assert not script.robot.set_torques([WRIST], [0.1])
    assert "refused torques: no torque source for wrist" in script.robot.status().faults


def test_a_torque_from_the_future_is_no_younger_than_now(script: Script) -> None:
    script.say("11C 10")
    script.robot.set_joint_torques([PITCH, ROLL], [0.0, 0.0], script.now_ns + 10**10)

    assert "001 F400" in script.tick(70)


def test_the_offset_follows_every_confirmed_switch(script: Script) -> None:
    script.robot.set_impedance_offsets([ROLL], [-0.5])
    script.say("11C 10")
    script.torques()
    script.tick(20)
    script.say("113 0008000100000000")  # the board's own change, so nothing went with a command
    script.torques()

    assert "001 D900F8" in commands(script.tick(2))
