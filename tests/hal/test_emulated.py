"""The HAL against emulated boards: whole procedures."""

import math

import pytest

from hal.robot import Robot
from hal.wire.modes import ControlMode
from hal.wire.motor import COMMANDS
from tests.hal.arm import BUS
from tests.hal.emulated import EMULATED, HOME, Bench
from tests.hal.scripted import MS

DIRECT = int(ControlMode.DIRECT)


def test_opens_without_a_fault_or_a_lost_frame(bench: Bench) -> None:
    bench.open()

    status = bench.robot.status()
    assert (status.phase, status.faults, status.frames_lost) == ("idle", (), 0)
    assert [bench.boards.board(BUS, address).dropped for address in (1, 3, 13)] == [{}, {}, {}]
    assert [axis.pid_flags for axis in bench.axes] == [0x7F] * 4


def test_reads_back_every_setting_as_written(bench: Bench) -> None:
    bench.open()
    probe = bench.buses[2]
    probe.receive_frames()
    answers: dict[str, tuple[int, ...]] = {}
    for name in ("GET_P_GAIN", "GET_TORQUE_PID", "GET_IMPEDANCE_PARAMS", "GET_MAX_POSITION"):
        command = next(c for c in COMMANDS.values() if c.name == name)
        probe.send_frames([command.request(1, 1)])
        bench.tick(3)
        for can_id, data, _ in probe.receive_frames():
            if can_id == 0x010 and data[0] & 0x7F == command.code:
                reply = command.parse_reply(data)
                assert reply is not None
                answers[name] = reply

    assert answers == {
        "GET_P_GAIN": (32000,),
        "GET_TORQUE_PID": (76, 0, 0, 14),
        "GET_IMPEDANCE_PARAMS": (144, 10803, 0),
        "GET_MAX_POSITION": (2252,),
    }


def test_calibrates_in_groups_and_ends_in_position_mode(bench: Bench) -> None:
    bench.open()
    task = bench.robot.request("calibrate")
    bench.tick()
    assert bench.robot.phase == "calibrating"
    bench.finish(task)

    assert task.ok
    joints = bench.robot.joints
    assert joints.calibrated == [True] * 4
    assert joints.control_mode == [ControlMode.POSITION] * 4
    assert joints.moving == [False] * 4
    assert bench.robot.phase == "ready"
    for q_rad, true_deg in zip(joints.q_rad, bench.angles_deg, strict=True):
        assert math.degrees(q_rad) == pytest.approx(true_deg, abs=0.2)


def test_limits_the_pwm_while_calibrating_and_restores_it(bench: Bench) -> None:
    bench.open()
    task = bench.robot.request("calibrate")
    bench.tick(40)
    assert bench.axes[0].pwm_limit == 120
    bench.finish(task)

    assert [axis.pwm_limit for axis in bench.axes] == [800, 800, 1333, 1333]


def test_waits_until_a_falling_joint_stands_still_before_it_calibrates(bench: Bench) -> None:
    bench.open()
    task = bench.robot.request("calibrate", ["roll"])
    for _ in range(700):
        bench.angles_deg[1] -= 0.05  # 50 deg/s
        bench.tick()
    assert not bench.axes[1].enabled
    bench.finish(task)

    assert task.ok, task.reason


def test_powers_a_joint_that_never_stands_still_after_two_seconds(bench: Bench) -> None:
    bench.open()
    bench.robot.request("calibrate", ["roll"])
    for _ in range(2020):
        bench.angles_deg[1] += 0.05 if bench.now_ns // MS % 20 < 10 else -0.05
        bench.tick()

    assert bench.axes[1].enabled


def test_a_calibration_that_does_not_end_is_given_up_with_the_reason(bench: Bench) -> None:
    bench.open()
    task = bench.robot.request("calibrate")
    bench.tick(1300)
    bench.axes[2].port.hall_fault = 1
    bench.finish(task, 30_000)

    assert task.reason == ("prosup failed while calibrating: hardware fault: Hall sensor error")
    assert bench.robot.joints.calibrated == [True, True, False, True]
    assert bench.axes[2].pwm_limit == 1333


def test_a_second_host_finds_the_boards_calibrated(ready: Bench) -> None:
    ready.robot = Robot(EMULATED, {BUS: ready.buses[1]})
    ready.open()

    assert ready.robot.status().calibrated
    assert ready.robot.status().faults == ()
    assert ready.robot.joints.control_mode == [ControlMode.IDLE] * 4


def test_a_second_host_finds_compliant_joints_and_no_board_faults(ready: Bench) -> None:
    ready.compliant("roll")
    ready.robot = Robot(EMULATED, {BUS: ready.buses[1]})
    ready.fed = False
    ready.open()
    ready.tick(300)

    assert not any(axis.compliant for axis in ready.axes)
    assert sum(axis.fault_entries for axis in ready.axes) == 0


def test_moves_together_and_settles(ready: Bench) -> None:
    task = ready.robot.request("move", q_rad=HOME, duration_s=2.0)
    ready.finish(task)

    assert task.ok
    assert ready.robot.joints.q_rad == pytest.approx(HOME, abs=math.radians(0.3))


def test_follows_position_direct_references(ready: Bench) -> None:
    ready.finish(ready.robot.request("mode", value="direct"))
    start = ready.robot.joints.q_rad[1]
    for ms in range(1500):
        if ms % 10 == 0:
            ready.robot.set_positions([1], [start - math.radians(min(ms, 1000) / 100)])
        ready.tick()

    assert ready.robot.joints.q_rad[1] == pytest.approx(start - math.radians(10.0), abs=0.005)
    assert ready.robot.status().clamped == ()


def test_follows_velocities_up_to_the_limit_and_no_further(ready: Bench) -> None:
    ready.finish(ready.robot.request("mode", ["wrist"], "velocity"))
    for ms in range(4000):
        if ms % 10 == 0:
            ready.robot.set_velocities([3], [math.radians(20.0)])
        ready.tick()

    assert 24.0 < ready.angles_deg[3] < 25.2
    assert dict(ready.robot.status().clamped)["velocity"] > 0


def test_stands_still_100_ms_after_the_last_velocity(ready: Bench) -> None:
    ready.finish(ready.robot.request("mode", ["roll"], "velocity"))
    for _ in range(30):
        ready.robot.set_velocities([1], [math.radians(10.0)])
        ready.tick(10)
    ready.tick(600)
    there = ready.angles_deg[1]
    ready.tick(300)

    assert ready.angles_deg[1] == pytest.approx(there, abs=0.1)


def test_makes_only_the_named_joints_compliant(ready: Bench) -> None:
    ready.compliant("roll")

    assert [axis.compliant for axis in ready.axes] == [False, True, False, False]
    assert ready.robot.joints.control_mode[1] == DIRECT
    assert ready.robot.status().compliant == ("roll",)


def test_the_offset_survives_the_switch(ready: Bench) -> None:
    ready.robot.set_impedance_offsets([0, 1], [1.0, -0.5])
    ready.compliant("pitch", "roll")
    ready.tick(5)

    assert [axis.impedance.offset for axis in ready.axes[:2]] == [4096, -2048]


def test_holds_where_it_is_after_the_switch(ready: Bench) -> None:
    before = list(ready.robot.joints.q_rad)
    ready.compliant("pitch", "roll")
    ready.tick(500)

    assert ready.robot.joints.q_rad == pytest.approx(before, abs=math.radians(0.2))


def test_stop_brings_the_limbs_down_and_switches_them_off(ready: Bench) -> None:
    ready.compliant("roll")
    task = ready.robot.request("stop", q_rad=[*HOME[:2], math.radians(60.0), 0.0])
    began_ns = ready.now_ns
    ready.finish(task, 3100)

    assert task.ok, task.reason
    assert ready.now_ns - began_ns <= 3000 * MS
    assert [axis.enabled for axis in ready.axes] == [False] * 4
    assert ready.angles_deg == pytest.approx([-30.0, 30.0, 60.0, 0.0], abs=0.6)
    assert ready.robot.phase == "idle"


def test_close_leaves_every_axis_idle_and_the_bus_silent(ready: Bench) -> None:
    ready.robot.close(ready.now_ns)
    ready.running = False
    ready.tick(5)
    ready.buses[1].receive_frames()
    ready.tick(50)

    assert [axis.enabled for axis in ready.axes] == [False] * 4
    assert ready.buses[1].receive_frames() == []
