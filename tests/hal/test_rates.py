"""Open-loop set-points, and how fast set-points of any kind may change."""

import math

import pytest
from msgspec.structs import replace

from hal.wire.modes import ControlMode
from tests.hal.arm import DESCRIPTION, ROLL
from tests.hal.emulated import EMULATED, Bench
from tests.hal.scripted import Script

WRIST = 3


def in_mode(mode: int, **changes: float) -> Script:
    """A script whose roll is in a mode, its joint changed."""
    joints = [
        replace(joint, **changes) if joint.name == "roll" else joint for joint in DESCRIPTION.joints
    ]
    script = Script(replace(DESCRIPTION, joints=tuple(joints)))
    script.ready()
    script.status(0x113, 0x01, mode)
    script.tick()
    return script


def test_ramps_a_duty_cycle_in_percent_of_the_boards_full_scale() -> None:
    script = in_mode(0x50)  # 200 percent per second: 16 counts of 800 each 10 ms
    sent: list[str] = []
    for _ in range(4):
        assert script.robot.set_duties([ROLL], [5.0])
        sent += script.tick(10)

    assert sent == ["001 F21000", "001 F22000", "001 F22800", "001 F22800"]  # 16, 32, 40


def test_a_duty_cycle_stays_below_the_pwm_limit() -> None:
    script = in_mode(0x50, pwm_limit=40, max_duty_rate_percent_s=1e6)
    script.robot.set_duties([ROLL], [-50.0])

    assert script.tick() == ["001 F2D8FF"]
    assert dict(script.robot.status().clamped) == {"duty": 1}


def test_leaves_open_loop_when_the_set_points_stop() -> None:
    script = in_mode(0x01)
    task = script.robot.request("mode", ["roll"], "pwm")
    script.tick()
    script.status(0x113, 0x01, 0x50)
    script.tick(2)
    assert task.ok
    script.robot.set_duties([ROLL], [1.0])
    sent = script.tick(130)

    assert sent[-2:] == ["001 F400", "001 8901"]
    assert script.robot.status().faults == ("no pwm set-point for 0.1 s: roll to position mode",)


def test_refuses_duty_cycles_in_another_mode() -> None:
    script = in_mode(0x08)

    assert not script.robot.set_duties([ROLL], [1.0])
    assert not script.robot.set_duties([ROLL], [math.nan])


def test_refuses_open_loop_outside_the_limits() -> None:
    script = in_mode(0x01)
    script.bus.positions[0x111] = bytes.fromhex("D1070000") + (400).to_bytes(4, "little")
    script.tick(9)

    assert script.robot.request("mode", ["roll"], "pwm").reason == (
        "roll is outside its limits at -0.0320 rad"
    )


@pytest.fixture
def driven(ready: Bench) -> Bench:
    ready.finish(ready.robot.request("mode", ["wrist"], "pwm"))
    assert ready.axes[WRIST].mode == ControlMode.OPENLOOP
    return ready


def test_stops_before_the_limit_in_open_loop(driven: Bench) -> None:
    for _ in range(2000):
        driven.robot.set_duties([WRIST], [-15.0])  # 200 counts, 20 deg/s
        driven.tick()

    assert driven.axes[WRIST].mode == ControlMode.POSITION
    assert "wrist nears its limit in pwm mode: wrist to position mode" in (
        driven.robot.status().faults
    )
    assert (
        EMULATED.joints[WRIST].min_deg < driven.angles_deg[WRIST] < EMULATED.joints[WRIST].max_deg
    )


def test_limits_the_rate_of_torques() -> None:
    script = in_mode(0x03, max_torque_rate_nm_s=10.0)  # 0.1 Nm each 10 ms: 409.6 of 8/32768
    sent: list[str] = []
    for _ in range(3):
        script.torques()
        script.robot.set_torques([ROLL], [0.25])
        sent += [one for one in script.tick(10) if one.startswith("001")]

    assert sent == ["001 AC9A010000", "001 AC33030000", "001 AC00040000"]  # 410, 819, 1024


def test_limits_the_acceleration_of_velocities_but_not_of_braking() -> None:
    script = in_mode(0x02, max_acceleration_deg_s2=1000.0)  # 10 deg/s each 10 ms
    sent: list[str] = []
    for degrees in (25.0, 25.0, 25.0, 0.0):
        script.robot.set_velocities([ROLL], [math.radians(degrees)])
        sent += script.tick(10)

    # 10 deg/s is 113.75 ticks/s: 29 of 2^-8 ticks/ms
    assert sent == ["001 9C1D000100", "001 9C3A000100", "001 9C49000100", "001 9C00000100"]


def test_an_axis_with_nothing_to_do_is_not_looked_at() -> None:
    script = in_mode(0x08)
    script.robot.set_positions([ROLL], [math.radians(43.88)])
    script.tick(300)
    script.status(0x113, 0x01, 0x01)
    script.tick(2)
    due = [setpoints.due_ns for setpoints in script.robot._setpoints]

    assert min(due) > script.now_ns + 10**15
