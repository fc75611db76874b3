"""Axes that no reference keeps from a limit, and references that a board took beyond one."""

import pytest

from hal.limiting import speed_ahead
from hal.units import AxisUnits
from hal.wire.modes import ControlMode
from tests.hal.arm import DESCRIPTION, ROLL
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


def run_down(script: Script, ticks: int, step: int) -> list[str]:
    """POSITION frames, 4 ms apart, of a steady motion that ends at `ticks`."""
    sent: list[str] = []
    for at in range(ticks + 40 * step, ticks - 1, -step):
        script.bus.positions[0x111] = bytes.fromhex("D1070000") + at.to_bytes(4, "little")
        for _ in range(4):
            script.torques()
            sent += script.tick()
    return sent


@pytest.mark.parametrize(
    ("ticks", "stiff"),
    # 8 ticks per frame, less a tick in 24 ms, are 1958 ticks/s: 156.7 ticks in 0.08 s.
    [(420 + 160, False), (420 + 152, True)],
)
def test_a_compliant_axis_is_made_stiff_before_it_runs_into_a_limit(
    ticks: int, stiff: bool
) -> None:
    script = script_in(0x01, ticks + 320)
    compliant(script)

    assert ("001 F400" in run_down(script, ticks, 8)) is stiff


def test_a_compliant_axis_may_stand_one_tick_outside() -> None:
    script = script_in(0x01)
    compliant(script)
    for ticks in (*range(920, 640, -10), *range(640, 430, -2), *range(430, 419, -1)):
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


ROLL_UNITS = AxisUnits(DESCRIPTION.joints[ROLL], velocity_shift=8)


def recent(*ticks: int) -> tuple[tuple[int, int], ...]:
    return tuple((tick, 4_000_000 * k) for k, tick in enumerate(ticks))


def ticks_per_s(frames: tuple[tuple[int, int], ...]) -> float:
    return speed_ahead(ROLL_UNITS, frames) * ROLL_UNITS.ticks_per_rad


def test_a_steady_axis_keeps_its_speed_less_a_tick_of_noise() -> None:
    assert ticks_per_s(recent(0, 8, 16, 24, 32, 40, 48)) == pytest.approx(47 / 0.024)


def test_an_axis_that_gains_speed_is_taken_for_as_fast_as_it_will_be_when_it_is_braked() -> None:
    # 500 ticks/s, then 2000: 1500 - 2 / 0.012 gained in 12 ms, and 12 + 15 ms more to go.
    gained = (1500 - 2 / 0.012) * 27 / 12
    assert ticks_per_s(recent(0, 2, 4, 6, 14, 22, 30)) == pytest.approx(29 / 0.024 + gained)


def test_an_axis_that_loses_speed_is_not_credited_with_it() -> None:
    assert ticks_per_s(recent(0, 8, 16, 24, 26, 28, 30)) == pytest.approx(29 / 0.024)


@pytest.mark.parametrize(
    "ticks", [(0, 0, 0, 0, 0, 0, -1), (0, 0, 0, -1, 0, 0, -1), (5, 4, 4, 4, 4)]
)
def test_an_axis_that_shows_a_tick_of_noise_stands(ticks: tuple[int, ...]) -> None:
    assert ticks_per_s(recent(*ticks)) == 0.0


def test_frames_that_were_held_up_and_come_together_make_no_axis_much_faster() -> None:
    ms = (0, 4, 8, 28, 28, 28, 29)
    frames = tuple((8 * k, 1_000_000 * at) for k, at in enumerate(ms))

    # 24 ticks in what must have been 12 ms; before, 24 in 28: 40 ms in all.
    gained = 24 / 0.012 - 24 / 0.028 - 2 / 0.012
    assert ticks_per_s(frames) == pytest.approx(47 / 0.040 + gained * 35 / 20)


def test_nothing_is_known_of_the_speed_before_the_third_frame() -> None:
    assert ticks_per_s(recent()) == 0.0
    assert ticks_per_s(recent(0, 8)) == 0.0
    assert ticks_per_s(recent(0, 8, 16)) == pytest.approx(15 / 0.008)
