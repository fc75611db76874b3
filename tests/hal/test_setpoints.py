"""Set-points: what is sent, how often, and that nothing passes a limit."""

import math

import pytest

from hal.robot import Robot
from tests.hal.arm import PITCH, ROLL
from tests.hal.scripted import Script

TICK_PER_DEG = 11.375


@pytest.fixture
def script() -> Script:
    script = Script()
    script.ready(mode=0x08)
    return script


@pytest.fixture
def robot(script: Script) -> Robot:
    return script.robot


def deg(angle: float) -> float:
    return math.radians(angle)


def test_sends_a_reference_in_the_same_step(script: Script, robot: Robot) -> None:
    assert robot.set_positions([ROLL], [deg(44.0)])

    assert script.tick() == ["001 BE99030000"]  # 81.0 * 11.375 = 921.4


def test_sends_one_reference_per_axis_and_10_ms(script: Script, robot: Robot) -> None:
    sent = []
    for ms in range(40):
        robot.set_positions([ROLL], [deg(43.9 + 0.05 * ms)])
        sent += [ms for one in script.tick() if one.startswith("001 BE")]

    assert sent == [0, 10, 20, 30]


def test_sends_the_newest_of_the_references_of_a_cycle(script: Script, robot: Robot) -> None:
    robot.set_positions([ROLL], [deg(44.0)])
    script.tick()
    robot.set_positions([ROLL], [deg(44.2)])
    script.tick(5)
    robot.set_positions([ROLL], [deg(44.4)])

    assert script.tick(6) == ["001 BE9E030000"]  # 926 ticks


def test_repeats_an_unchanged_reference_each_100_ms(script: Script, robot: Robot) -> None:
    robot.set_positions([ROLL], [deg(44.0)])
    script.tick()

    assert script.tick(99) == []
    assert script.tick() == ["001 BE99030000"]


def test_clamps_a_reference_to_the_limits_and_counts_it(script: Script, robot: Robot) -> None:
    robot.set_positions([ROLL], [deg(200.0)])
    sent = script.tick(6000)

    assert sent[-1] == "001 BECC080000"  # 161 deg: 2252 ticks
    assert max(int.from_bytes(bytes.fromhex(one[6:14]), "little") for one in sent) == 2252
    assert dict(robot.status().clamped)["position"] == 1


def test_approaches_a_far_reference_at_the_maximal_velocity(script: Script, robot: Robot) -> None:
    robot.set_positions([ROLL], [deg(100.0)])
    sent = [int.from_bytes(bytes.fromhex(one[6:14]), "little") for one in script.tick(100)]

    steps = {after - before for before, after in zip([920, *sent], sent, strict=False)}
    assert steps == {6, 7}
    assert (len(sent), sent[-1]) == (10, 920 + 68)  # 60 deg/s is 682.5 ticks/s
    assert dict(robot.status().clamped)["speed of position"] == 10


@pytest.mark.parametrize("value", [math.nan, math.inf, -math.inf])
def test_refuses_what_is_not_finite_and_says_which_joint(
    script: Script, robot: Robot, value: float
) -> None:
    assert not robot.set_positions([PITCH, ROLL], [deg(-1.0), value])

    assert script.tick(10) == []
    assert robot.status().faults == ("refused positions not finite: roll",)
    assert robot.status().refused_commands == 1


def test_refuses_a_wrong_number_of_values(script: Script, robot: Robot) -> None:
    assert not robot.set_positions([PITCH, ROLL], [0.0])

    assert script.tick(10) == []
    assert robot.status().faults == ("refused positions: 1 values for 2 joints",)


def test_reports_a_stream_of_nans_once_a_second(script: Script, robot: Robot) -> None:
    for _ in range(500):
        robot.set_positions([ROLL], [math.nan])
        script.tick()

    assert robot.status().fault_count == 1
    assert robot.status().refused_commands == 500


def test_counts_references_for_a_joint_in_another_mode(script: Script, robot: Robot) -> None:
    script.status(0x113, 0x01, 0x01)
    script.tick()

    assert not robot.set_positions([ROLL], [0.0])
    assert robot.status().refusals == (("positions: a joint is not in direct mode", 1),)
    assert robot.status().faults == ()


def test_forgets_a_reference_when_the_mode_changes(script: Script, robot: Robot) -> None:
    robot.set_positions([ROLL], [deg(60.0)])
    script.tick()
    script.status(0x113, 0x08, 0x01)
    script.tick()
    script.status(0x113, 0x08, 0x08)

    assert script.tick(50) == []


def velocity(script: Script) -> Robot:
    script.status(0x113, 0x02, 0x02)
    script.tick()
    return script.robot


def test_sends_a_velocity_scaled_by_the_velocity_shift(script: Script) -> None:
    robot = velocity(script)
    robot.set_velocities([ROLL], [deg(10.0)])

    assert script.tick() == ["001 9C1D000100"]


def test_never_repeats_a_velocity(script: Script) -> None:
    robot = velocity(script)
    robot.set_velocities([ROLL], [deg(10.0)])
    script.tick()

    assert script.tick(300) == []


def test_limits_a_velocity_to_the_maximal_one(script: Script) -> None:
    robot = velocity(script)
    robot.set_velocities([ROLL], [deg(500.0)])

    assert script.tick() == ["001 9CAF000100"]  # 60 deg/s
    assert dict(robot.status().clamped) == {"velocity": 1}


def test_slows_a_velocity_that_would_reach_the_limit_within_its_time_out(script: Script) -> None:
    robot = velocity(script)
    script.bus.positions[0x111] = bytes.fromhex("D1070000CD080000")
    script.tick(8)
    robot.set_velocities([ROLL], [deg(30.0)])

    assert script.tick() == ["001 9C00000100"]


def test_lets_a_velocity_lead_away_from_a_limit(script: Script) -> None:
    robot = velocity(script)
    script.bus.positions[0x111] = bytes.fromhex("D1070000CC080000")
    script.tick(4)
    robot.set_velocities([ROLL], [deg(-10.0)])

    assert script.tick() == ["001 9CE3FF0100"]


def torque(script: Script) -> Robot:
    script.torques()
    script.status(0x113, 0x03, 0x03)
    script.tick()
    return script.robot


def commands(sent: list[str]) -> list[str]:
    return [one for one in sent if one.startswith("00")]


def test_sends_a_torque_in_torque_units(script: Script) -> None:
    robot = torque(script)
    robot.set_torques([PITCH], [1.0])

    assert commands(script.tick()) == ["001 2C00100000"]  # example 21


def test_clamps_a_torque_to_the_full_scale(script: Script) -> None:
    robot = torque(script)
    robot.set_torques([PITCH], [-20.0])

    assert commands(script.tick()) == ["001 2C0080FFFF"]
    assert dict(robot.status().clamped) == {"torque": 1}


def test_leaves_torque_mode_when_set_points_stop(script: Script) -> None:
    script.torques()
    task = script.robot.request("mode", ["pitch", "roll"], "torque")
    script.tick()
    robot = torque(script)
    script.tick()
    assert task.ok
    sent: list[str] = []
    for _ in range(120):
        script.torques()
        sent += commands(script.tick())

    assert sent[:4] == ["001 7400", "001 0901", "001 F400", "001 8901"]
    assert robot.status().faults[0] == "no torque set-point for 0.1 s: pitch to position mode"


def test_switches_off_an_axis_in_torque_mode_that_it_has_not_switched_on(script: Script) -> None:
    torque(script)
    sent: list[str] = []
    for _ in range(120):
        script.torques()
        sent += commands(script.tick())

    # Position mode would switch it on, should the board's word be wrong.
    assert sent[:4] == ["001 7400", "001 0900", "001 F400", "001 8900"]
