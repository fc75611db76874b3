"""Modes and references of every motor board (can-protocol 2.2, 10.2)."""

import pytest

from hal.wire import motor
from hal.wire.modes import ControlMode
from tests.firmware_sim.boards.bench import PLAIN, Bench


@pytest.mark.parametrize(
    "mode",
    [
        ControlMode.POSITION,
        ControlMode.VELOCITY,
        ControlMode.TORQUE,
        ControlMode.IMPEDANCE_POSITION,
        ControlMode.IMPEDANCE_VELOCITY,
        ControlMode.MIXED,
        ControlMode.DIRECT,
        ControlMode.OPENLOOP,
    ],
)
def test_idle_to_running_and_back(bench: Bench, mode: ControlMode) -> None:
    bench.ready().enter(ControlMode.IDLE)
    bench.hear_torque()
    bench.enter(mode)
    assert bench.ask(motor.GET_CONTROL_MODE) == (mode,)
    assert bench.board.ports[PLAIN].enabled
    bench.enter(ControlMode.IDLE)
    assert bench.ask(motor.GET_CONTROL_MODE) == (ControlMode.IDLE,)
    assert not bench.board.ports[PLAIN].enabled


def test_running_modes_switch_at_once_and_force_idle_stops(bench: Bench) -> None:
    bench.ready().enter(ControlMode.DIRECT).enter(ControlMode.VELOCITY)
    assert bench.axis().mode == ControlMode.VELOCITY
    bench.enter(ControlMode.FORCE_IDLE)
    assert bench.axis().mode == ControlMode.IDLE
    bench.enter(ControlMode.FORCE_IDLE)
    assert bench.axis().mode == ControlMode.IDLE


def test_only_force_idle_leads_out_of_a_fault(bench: Bench) -> None:
    bench.ready()
    bench.axis().fault()
    for mode in (ControlMode.IDLE, ControlMode.POSITION, ControlMode.OPENLOOP):
        bench.enter(mode)
        assert bench.axis().mode == ControlMode.HW_FAULT
    bench.do(motor.CALIBRATE_ENCODER, 3, 2000, 10, 0)
    assert bench.axis().mode == ControlMode.HW_FAULT
    bench.enter(ControlMode.FORCE_IDLE)
    assert bench.axis().mode == ControlMode.IDLE
    assert bench.axis().fault_entries == 1


@pytest.mark.parametrize("code", [0x06, 0x60, 0x20, 0xA0, 0xB2, 0x33])
def test_an_unsupported_mode_faults_one_millisecond_later(bench: Bench, code: int) -> None:
    bench.ready()
    bench.do(motor.SET_CONTROL_MODE, code)
    assert bench.axis().mode not in (ControlMode.HW_FAULT, ControlMode.POSITION)
    assert bench.board.ports[PLAIN].pwm == 0
    bench.tick()
    assert bench.axis().mode == ControlMode.HW_FAULT


def test_a_new_mode_starts_from_the_present_position(bench: Bench) -> None:
    bench.ready()
    bench.do(motor.SET_IMPEDANCE_OFFSET, 300)
    bench.do(motor.SET_DESIRED_TORQUE, 300)
    bench.do(motor.POSITION_MOVE, 2500, 100)
    bench.tick(100)
    bench.place(2055)
    bench.tick()
    bench.enter(ControlMode.OPENLOOP)
    bench.do(motor.SET_OPENLOOP_PARAMS, 80)
    bench.enter(ControlMode.POSITION)
    assert bench.ask(motor.GET_DESIRED_POSITION) == (2055,)
    assert bench.ask(motor.GET_IMPEDANCE_OFFSET) == (0,)
    assert bench.ask(motor.GET_DESIRED_TORQUE) == (0,)
    assert bench.ask(motor.GET_OPENLOOP_PARAMS) == (0,)
    assert bench.ask(motor.MOTION_DONE) == (1,)


def test_asking_for_the_present_mode_changes_nothing(bench: Bench) -> None:
    bench.ready()
    bench.do(motor.POSITION_MOVE, 2500, 100)
    bench.enter(ControlMode.POSITION)
    assert bench.ask(motor.MOTION_DONE) == (0,)


def test_an_interaction_switch_clears_reference_and_offset(bench: Bench) -> None:
    bench.ready()
    bench.do(motor.POSITION_MOVE, 2500, 100)
    bench.do(motor.SET_IMPEDANCE_OFFSET, 300)
    bench.tick(200)
    bench.compliant()
    assert bench.ask(motor.GET_DESIRED_POSITION) == (2000,)
    assert bench.ask(motor.GET_IMPEDANCE_OFFSET) == (0,)
    bench.do(motor.SET_IMPEDANCE_OFFSET, 300)
    bench.do(motor.SET_INTERACTION_MODE, 1)  # no change, so nothing is cleared
    assert bench.ask(motor.GET_IMPEDANCE_OFFSET) == (300,)


def test_an_offset_sent_behind_the_switch_stays(bench: Bench) -> None:
    bench.ready()
    bench.hear_torque()
    bench.send(motor.SET_INTERACTION_MODE, 1)
    bench.send(motor.SET_IMPEDANCE_OFFSET, 300)
    bench.tick()
    assert bench.ask(motor.GET_IMPEDANCE_OFFSET) == (300,)


def test_deprecated_impedance_modes_make_the_axis_compliant(bench: Bench) -> None:
    bench.ready()
    bench.hear_torque()
    bench.enter(ControlMode.IMPEDANCE_POSITION)
    assert bench.ask(motor.GET_INTERACTION_MODE) == (1,)
    assert bench.axis().force_controlled


def test_set_points_count_only_in_their_mode(bench: Bench) -> None:
    bench.ready()
    bench.do(motor.SET_COMMAND_POSITION, 2100)
    bench.do(motor.VELOCITY_MOVE, 100, 1)
    assert bench.ask(motor.GET_DESIRED_POSITION) == (2000,)
    bench.enter(ControlMode.DIRECT)
    bench.do(motor.POSITION_MOVE, 2100, 100)
    assert bench.ask(motor.GET_DESIRED_POSITION) == (2000,)
    assert bench.board.dropped["mode"] == 3


def test_a_direct_set_point_acts_in_its_millisecond_and_is_clamped(bench: Bench) -> None:
    bench.ready().enter(ControlMode.DIRECT)
    bench.do(motor.SET_COMMAND_POSITION, 2003)
    assert bench.axis().pwm == 1000 * 3 >> 6
    bench.do(motor.SET_COMMAND_POSITION, 9999)
    assert bench.ask(motor.GET_DESIRED_POSITION) == (3500,)
    bench.do(motor.SET_COMMAND_POSITION, -9999)
    assert bench.ask(motor.GET_DESIRED_POSITION) == (500,)
    assert bench.ask(motor.MOTION_DONE) == (1,)


def test_a_position_move_is_minimum_jerk_over_its_duration(bench: Bench) -> None:
    bench.ready()
    bench.do(motor.POSITION_MOVE, 2400, 100)  # 400 ticks at 1000 ticks/s: 400 ms
    bench.tick(99)
    # 10 s^3 - 15 s^4 + 6 s^5 = 0.103515625 at a quarter of the time
    assert bench.axis().reference.ticks == 2041
    bench.tick(100)
    assert bench.axis().reference.ticks == 2200
    bench.tick(200)
    assert bench.ask(motor.MOTION_DONE) == (1,)
    assert bench.axis().reference.ticks == 2400


def test_a_position_move_ends_inside_the_limits(bench: Bench) -> None:
    bench.ready()
    bench.do(motor.POSITION_MOVE, 100000, 32767)
    bench.tick(100)
    assert bench.ask(motor.GET_POSITION_MOVE_REF) == (3500,)


def test_velocity_integrates_fractions_of_a_tick(bench: Bench) -> None:
    bench.ready()
    bench.do(motor.SET_VEL_SHIFT, 8)
    bench.enter(ControlMode.VELOCITY)
    bench.do(motor.VELOCITY_MOVE, 29, 0x7FFF)  # 29/256 ticks/ms
    bench.tick(999)
    assert bench.axis().reference.ticks == 2000 + 29 * 1000 // 256


def test_velocity_ramps_with_its_acceleration(bench: Bench) -> None:
    bench.ready()
    bench.do(motor.SET_VEL_SHIFT, 8)
    bench.enter(ControlMode.VELOCITY)
    bench.do(motor.VELOCITY_MOVE, 29, 10)
    assert bench.axis().reference.velocity == 10
    bench.tick(2)
    assert bench.axis().reference.velocity == 29


def test_a_silent_host_stops_a_velocity_after_the_time_out(bench: Bench) -> None:
    bench.ready()
    bench.do(motor.SET_VEL_TIMEOUT, 100)
    bench.enter(ControlMode.VELOCITY)
    bench.do(motor.VELOCITY_MOVE, 16, 0x7FFF)  # 1 tick/ms at the default shift 4
    bench.tick(80)
    bench.do(motor.VELOCITY_MOVE, 16, 0x7FFF)  # restarts the time-out
    bench.tick(100)
    assert bench.ask(motor.GET_VELOCITY_MOVE_REF) == (0,)
    stopped = bench.axis().reference.ticks
    bench.tick(100)
    assert bench.axis().reference.ticks == stopped == 2000 + 181
    assert bench.axis().mode == ControlMode.VELOCITY


def test_a_silent_host_changes_nothing_else(bench: Bench) -> None:
    bench.ready().enter(ControlMode.DIRECT)
    bench.do(motor.SET_COMMAND_POSITION, 2100)
    bench.tick(5000)
    assert bench.axis().mode == ControlMode.DIRECT
    assert bench.axis().reference.ticks == 2100


def test_stop_trajectory_holds_where_the_axis_is(bench: Bench) -> None:
    bench.ready()
    bench.do(motor.POSITION_MOVE, 2400, 100)
    bench.tick(50)
    bench.place(2003)
    bench.tick()
    bench.do(motor.STOP_TRAJECTORY)
    assert bench.ask(motor.GET_DESIRED_POSITION) == (2003,)
    assert bench.ask(motor.MOTION_DONE) == (1,)


def test_open_loop_drives_and_stops_outside_the_limits(bench: Bench) -> None:
    bench.ready().enter(ControlMode.OPENLOOP)
    bench.do(motor.SET_OPENLOOP_PARAMS, 80)
    bench.tick(10)
    assert bench.board.ports[PLAIN].pwm == 80
    bench.place(3600)
    bench.tick(10)
    assert bench.board.ports[PLAIN].pwm == 0


@pytest.mark.parametrize(("pwm_limit", "driven"), [(120, 120), (0, 0), (-5, 0)])
def test_the_pwm_limit_is_the_last_clamp(bench: Bench, pwm_limit: int, driven: int) -> None:
    bench.ready().enter(ControlMode.DIRECT)
    bench.do(motor.SET_PWM_LIMIT, pwm_limit)
    bench.do(motor.SET_COMMAND_POSITION, 3500)
    bench.tick(100)
    assert bench.board.ports[PLAIN].pwm == driven
