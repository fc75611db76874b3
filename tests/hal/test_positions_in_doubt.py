"""POSITION frames that say what no joint can do: one alone is not believed, and counted."""

import math

import pytest

from hal.boards.motor import IMPLAUSIBLE
from tests.hal.arm import ROLL
from tests.hal.scripted import Script

# roll: 11.375 ticks per degree, zero at 37 degrees; 1000 deg/s are 45.5 ticks in 4 ms.
AT_TICKS = 920
AT_DEG = 920 / 11.375 - 37.0


@pytest.fixture
def script() -> Script:
    script = Script()
    script.ready(mode=0x08)
    script.tick(40)
    assert math.degrees(script.robot.joints.q_rad[ROLL]) == pytest.approx(AT_DEG)
    return script


def say(script: Script, *ticks: int) -> None:
    """One POSITION frame of each."""
    for one in ticks:
        script.bus.positions[0x111] = bytes.fromhex("D1070000") + one.to_bytes(4, "little")
        script.tick(4)


def seen_deg(script: Script) -> float:
    return math.degrees(script.robot.joints.q_rad[ROLL])


def counted(script: Script) -> int:
    return dict(script.robot.status().drops).get(IMPLAUSIBLE, 0)


def test_a_single_jump_is_not_believed_and_counted(script: Script) -> None:
    say(script, AT_TICKS + 1024)  # one bit
    assert seen_deg(script) == pytest.approx(AT_DEG)
    say(script, AT_TICKS)

    assert seen_deg(script) == pytest.approx(AT_DEG)
    assert script.robot.joints.dq_rad_s[ROLL] == 0.0
    assert counted(script) == 1


def test_a_jump_that_lasts_is_believed_without_being_a_speed(script: Script) -> None:
    say(script, AT_TICKS + 1024, AT_TICKS + 1024)

    assert seen_deg(script) == pytest.approx(AT_DEG + 1024 / 11.375)
    assert script.robot.joints.dq_rad_s[ROLL] == 0.0
    assert counted(script) == 0


def test_jumps_to_and_fro_are_believed_nowhere_but_where_the_joint_was(script: Script) -> None:
    say(script, AT_TICKS + 512, AT_TICKS + 1024, AT_TICKS + 256, AT_TICKS)

    assert seen_deg(script) == pytest.approx(AT_DEG)
    assert counted(script) == 3


def test_the_fastest_joint_is_believed_at_once(script: Script) -> None:
    say(script, AT_TICKS + 45)
    assert seen_deg(script) == pytest.approx(AT_DEG + 45 / 11.375)

    say(script, AT_TICKS + 45 + 46)
    assert seen_deg(script) == pytest.approx(AT_DEG + 45 / 11.375)


def test_a_joint_may_have_gone_far_while_no_frame_came(script: Script) -> None:
    del script.bus.positions[0x111]
    script.tick(40)
    say(script, AT_TICKS + 450)  # in 44 ms, 500 at most

    assert seen_deg(script) == pytest.approx(AT_DEG + 450 / 11.375)
    assert counted(script) == 0
