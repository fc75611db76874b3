"""Axes that no reference keeps from a limit, and references that a board took beyond one."""

import pytest

from hal.limiting import SPRING_S, spring_ahead_s
from hal.wire.modes import ControlMode
from tests.hal.arm import ROLL
from tests.hal.scripted import Script

# roll: 0 to 161 deg are 421 to 2252 ticks, 11.375 ticks per degree.
OUTSIDE_TICKS = 415  # -0.52 deg
FAR_TICKS = 360  # -5.35 deg: nobody overshoots that much
SETTLED_MS = 40


def commands(sent: list[str]) -> list[str]:
    return [one for one in sent if one.startswith("00")]


def stand(script: Script, ticks: int) -> None:
    script.bus.positions[0x111] = bytes.fromhex("D1070000") + ticks.to_bytes(4, "little")
    for _ in range(SETTLED_MS):
        script.torques()
        script.tick()


def script_in(mode: int, ticks: int = 920) -> Script:
    script = Script()
    script.ready(mode=0x08)
    stand(script, ticks)
    script.status(0x113, 0x01, mode)
    script.tick()
    return script


def compliant(script: Script) -> None:
    script.torques()
    task = script.robot.request("interaction", ["roll"], "compliant")
    script.tick()
    script.say("11C 10")
    script.torques()
    script.tick()
    assert task.ok


def test_a_compliant_axis_that_leaves_its_limits_is_made_stiff() -> None:
    script = script_in(0x01)
    compliant(script)
    stand(script, OUTSIDE_TICKS)

    assert "roll nears its limit while compliant: roll made stiff" in script.robot.status().faults
    script.torques()
    assert "001 F400" in script.tick(10)  # until the board confirms it


@pytest.mark.parametrize(
    ("offset_nm", "ticks", "stiff"),
    [
        (7.9, 675, False),
        (7.9, 668, True),  # 250 ticks in 0.25 s: an offset that may beat the spring
        (2.0, 475, False),
        (2.0, 468, True),  # 50 ticks in 0.05 s: a weight, and the spring brakes
    ],
)
def test_a_compliant_axis_is_made_stiff_before_it_runs_into_a_limit(
    offset_nm: float, ticks: int, stiff: bool
) -> None:
    script = script_in(0x01, ticks)
    compliant(script)
    assert script.robot.set_impedance_offsets([ROLL], [offset_nm])
    script.say("117 0000E0FF00000000")  # -1 tick/ms, 1.5 rad/s
    sent: list[str] = []
    for _ in range(5):
        script.torques()
        sent += script.tick()

    assert ("001 F400" in sent) is stiff


def test_a_compliant_axis_may_stand_one_tick_outside() -> None:
    script = script_in(0x01)
    compliant(script)
    for ticks in range(920, 419, -20):  # 5 ticks/ms would be too fast; here none is reported
        stand(script, ticks)

    assert not [text for text in script.robot.status().faults if "nears its limit" in text]


@pytest.mark.parametrize(
    ("action", "value", "ticks", "reason"),
    [  # 477 ticks are 4.93 deg, 478 5.02; 443 ticks 1.95 deg, 444 2.03
        ("mode", "torque", 477, "roll is 4.93 deg from its limit, nearer than 5: move it first"),
        ("mode", "torque", 478, ""),
        (
            "interaction",
            "compliant",
            443,
            "roll is 1.95 deg from its limit, nearer than 2: move it first",
        ),
        ("interaction", "compliant", 444, ""),
    ],
)
def test_force_control_begins_with_room_to_brake(
    action: str, value: str, ticks: int, reason: str
) -> None:
    script = script_in(0x01, ticks)
    script.torques()

    assert script.robot.request(action, ["roll"], value).reason == reason


def test_an_axis_in_torque_mode_leaves_it_at_a_limit() -> None:
    script = script_in(0x01)
    script.torques()
    task = script.robot.request("mode", ["roll"], "torque")
    script.tick()
    script.status(0x113, 0x01, 0x03)
    script.tick()
    assert task.ok
    script.bus.positions[0x111] = bytes.fromhex("D1070000") + OUTSIDE_TICKS.to_bytes(4, "little")
    sent: list[str] = []
    for _ in range(8):
        script.torques()
        assert script.robot.set_torques([ROLL], [-1.0])
        sent += commands(script.tick())

    assert sent[-2:] == ["001 F400", "001 8901"]
    assert sent.count("001 F400") == 1
    assert script.robot.status().faults[-1] == (
        "roll nears its limit in torque mode: roll to position mode"
    )


@pytest.mark.parametrize(("action", "value"), [("mode", "torque"), ("interaction", "compliant")])
def test_refuses_force_control_outside_the_limits(action: str, value: str) -> None:
    script = script_in(0x01, OUTSIDE_TICKS)
    script.torques()

    assert script.robot.request(action, ["roll"], value).reason == (
        "roll is outside its limits at -0.0090 rad"
    )


def test_a_reference_taken_beyond_a_limit_is_moved_back() -> None:
    script = script_in(0x02, OUTSIDE_TICKS)
    script.status(0x113, 0x01, ControlMode.POSITION)

    assert commands(script.tick()) == ["001 9BA50100000100"]  # to 421, 6 ticks in half a second


def test_a_direct_reference_taken_beyond_a_limit_is_moved_back() -> None:
    script = script_in(0x02, OUTSIDE_TICKS)
    script.status(0x113, 0x01, ControlMode.DIRECT)

    assert commands(script.tick(20))[-1] == "001 BEA5010000"


def test_an_axis_that_stands_far_outside_is_left_there() -> None:
    script = script_in(0x02, FAR_TICKS)
    script.status(0x113, 0x01, ControlMode.POSITION)

    assert commands(script.tick(20)) == []


def test_a_velocity_brings_an_axis_back_that_has_overshot() -> None:
    script = script_in(0x02, OUTSIDE_TICKS)
    script.robot.set_velocities([ROLL], [-0.5])

    # 0.516 deg in 0.6 s: 0.861 deg/s * 11.375 / 1000 * 256 = 2.5
    assert commands(script.tick()) == ["001 9C03000100"]


def test_a_spring_that_only_carries_weight_is_trusted_to_brake() -> None:
    assert spring_ahead_s(1.65, 0.28) == SPRING_S  # as fast as a push of 20 N makes an elbow
    assert spring_ahead_s(1.65, -0.28) == SPRING_S


def test_a_spring_whose_offset_may_beat_it_is_watched_further_ahead_the_faster_it_is() -> None:
    assert spring_ahead_s(0.0, 1.0) == pytest.approx(0.1)
    assert spring_ahead_s(0.5, -1.0) == pytest.approx(0.2)
    assert spring_ahead_s(1.65, 1.0) == pytest.approx(0.25)
