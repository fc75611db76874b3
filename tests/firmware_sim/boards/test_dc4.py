"""What only a 4DC does."""

import pytest

from firmware_sim.boards.board import BoardError
from firmware_sim.description import BoardSpec
from hal.wire import motor, motor_periodic
from hal.wire.can import source_of
from hal.wire.modes import ControlMode
from tests.firmware_sim.boards.bench import Bench

PROSUP, PITCH, YAW, FINGER = range(4)
CREEP_TICKS = -20
MARGIN_MS = 25


@pytest.fixture
def bench() -> Bench:
    return Bench("dc4")


def test_owns_two_addresses_but_is_discovered_at_the_first(bench: Bench) -> None:
    assert bench.board.addresses == (3, 4)
    assert bench.board.accepts(0x003)
    assert bench.board.accepts(0x004)
    assert bench.board.accepts(0x703)
    assert not bench.board.accepts(0x704)
    bench.give((0x70F, b"\xff"))
    assert bench.tick() == [(0x730, bytes.fromhex("ff03021957"))]


def test_handshake_at_the_second_address_answers_from_it(bench: Bench) -> None:
    bench.give((0x004, bytes.fromhex("5b0106")))
    assert bench.tick() == [(0x040, bytes.fromhex("5b03021957010601"))]


def test_bit_seven_selects_the_axis_of_the_address(bench: Bench) -> None:
    for axis in range(4):
        bench.do(motor.SET_P_GAIN, 100 + axis, axis=axis)
    assert [axis.position_pid.kp for axis in bench.board.axes] == [100, 101, 102, 103]
    bench.give((0x004, b"\x9f"))
    assert bench.tick() == [(0x040, b"\x9f\x67\x00")]


def test_the_first_mask_silences_the_second_address_too(bench: Bench) -> None:
    bench.do(motor.SET_BCAST_POLICY, 1, axis=YAW)
    assert bench.tick(20) == []
    bench.do(motor.SET_BCAST_POLICY, 2, axis=PITCH)
    sent = {(source_of(can_id), can_id & 0xF) for can_id, _ in bench.tick(20)}
    assert sent == {(3, 2), (4, 1)}


def test_broadcasts_come_every_five_milliseconds_without_duty(bench: Bench) -> None:
    bench.configure(mask=0x3).calibrate(YAW)
    bench.enter(ControlMode.DIRECT, axis=YAW)
    bench.send(motor.SET_COMMAND_POSITION, 2010, axis=YAW)
    frames = bench.tick(50)
    second = [frame for frame in frames if source_of(frame[0]) == 4]
    assert len(bench.heard(second, motor_periodic.POSITION)) == 10
    pid = bench.heard(second, motor_periodic.PID_VAL)
    assert pid[-1] == (0x142, bytes.fromhex("9c00000000000000"))


def test_runs_uncalibrated(bench: Bench) -> None:
    bench.configure().enter(ControlMode.POSITION, axis=PROSUP)
    assert bench.axis(PROSUP).mode == ControlMode.POSITION


def test_pwm_follows_at_once_up_to_1333_counts(bench: Bench) -> None:
    bench.ready().enter(ControlMode.OPENLOOP)
    bench.do(motor.SET_PWM_LIMIT, 0x7FFF)
    bench.do(motor.SET_OPENLOOP_PARAMS, 1500)
    assert bench.board.ports[1].pwm == 1333


def test_speed_is_the_last_millisecond_without_the_shift(bench: Bench) -> None:
    bench.tick()
    bench.board.ports[PROSUP].raw_encoder += 42
    bench.tick()
    assert bench.ask(motor.GET_ENCODER_VELOCITY, axis=PROSUP) == (42,)
    assert bench.ask(motor.GET_ENCODER_VELOCITY, axis=PROSUP) == (0,)


def test_an_incremental_encoder_counts_from_power_up_and_can_be_preset(bench: Bench) -> None:
    bench.tick()
    bench.board.power_cycle()
    bench.board.ports[PROSUP].raw_encoder += 10_000
    assert bench.ask(motor.GET_ENCODER_POSITION, axis=PROSUP)[0] == 10_000
    bench.do(motor.SET_ENCODER_POSITION, -300, axis=PROSUP)
    bench.board.ports[PROSUP].raw_encoder -= 1
    bench.tick()
    assert bench.ask(motor.GET_ENCODER_POSITION, axis=PROSUP)[0] == -301


def test_position_stiction_is_added_inside_the_limit(bench: Bench) -> None:
    bench.ready().enter(ControlMode.DIRECT)
    bench.do(motor.SET_POS_STICTION_PARAMS, 20, 30)
    assert bench.axis().pwm == 0
    bench.do(motor.SET_COMMAND_POSITION, 2001)
    assert bench.axis().pwm == 15 + 20
    bench.do(motor.SET_COMMAND_POSITION, 1999)
    assert bench.axis().pwm == -15 - 30
    bench.do(motor.SET_COMMAND_POSITION, 3000)
    assert bench.axis().pwm == 700


def test_calibration_0_creeps_to_the_stop_and_calls_it_zero(bench: Bench) -> None:
    bench.configure()
    port = bench.board.ports[PROSUP]
    stop = port.raw_encoder - 9000
    bench.send(motor.CALIBRATE_ENCODER, 0, 90, CREEP_TICKS, 0, axis=PROSUP)
    pwms = set()
    for _ in range(1000):  # follows the reference, then stands at the stop
        bench.tick()
        port.raw_encoder = max(port.raw_encoder + CREEP_TICKS, stop)
        pwms.add(port.pwm)
    axis = bench.axis(PROSUP)
    assert min(pwms) == -90  # limited to p1
    assert axis.mode == ControlMode.CALIB_HARD_STOP
    assert bench.ask(motor.GET_CONTROL_MODE, axis=PROSUP) == (ControlMode.CALIBRATION,)
    assert bench.ask(motor.GET_CALIBRATION_STATUS, axis=PROSUP) == (0, 0x20, 0)
    assert axis.reference.ticks == axis.position + 9000 + 1002 * CREEP_TICKS
    bench.tick(1200 - 1002)
    assert axis.mode == ControlMode.CALIB_HARD_STOP  # not before 1200 ms
    bench.tick(MARGIN_MS)
    assert axis.mode == ControlMode.POSITION
    assert axis.calibrated
    assert axis.position == axis.reference.ticks == 0


def test_calibration_0_waits_until_the_axis_stands(bench: Bench) -> None:
    bench.configure()
    bench.send(motor.CALIBRATE_ENCODER, 0, 90, 0, 0, axis=PROSUP)
    for _ in range(3000):
        bench.tick()
        bench.board.ports[PROSUP].raw_encoder += 1
    axis = bench.axis(PROSUP)
    assert axis.creep == 1  # 0 counts as 1
    assert axis.mode == ControlMode.CALIB_HARD_STOP
    bench.tick(2 * MARGIN_MS)
    assert axis.mode == ControlMode.POSITION


def test_calibration_types_are_per_axis(bench: Bench) -> None:
    bench.configure()
    bench.do(motor.CALIBRATE_ENCODER, 3, 2000, 10, 0, axis=PROSUP)
    bench.do(motor.CALIBRATE_ENCODER, 0, 90, 10, 0, axis=PITCH)
    assert bench.axis(PROSUP).mode == bench.axis(PITCH).mode == ControlMode.IDLE
    bench.do(motor.CALIBRATE_ENCODER, 3, 2200, 10, 300, axis=FINGER)
    finger = bench.axis(FINGER)
    assert finger.calibrated
    assert finger.reference.ticks == finger.position == 2000  # holds here, whatever p1 and p3


def test_torques_of_the_wrist_come_from_sensor_eleven(bench: Bench) -> None:
    sources = [axis.wiring.torque_source for axis in bench.board.axes]
    assert sources == [(12, 4), (11, 0), (11, 1), None]


def test_unknown_firmware_is_refused() -> None:
    with pytest.raises(BoardError, match=r"4DC firmware 3\.28 at address 5 is not emulated; known"):
        Bench("dc4", BoardSpec(bus=5, address=5, type="dc4", firmware=(3, 0x28)))
