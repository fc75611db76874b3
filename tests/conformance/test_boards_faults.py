"""Torque sources and faults of every motor board (can-protocol 6, 10.3)."""

import pytest

from firmware_sim.boards.motor_board import MotorBoard
from hal.wire import management, motor, motor_periodic
from hal.wire.can import source_of
from hal.wire.modes import ControlMode
from hal.wire.motor_periodic import AxisFault, BoardStatus, CanStatus
from tests.firmware_sim.boards.bench import PLAIN, STATUS_MASK, Bench


def test_torques_silent_for_200_ms_fault_a_compliant_axis(bench: Bench) -> None:
    bench.ready().compliant()
    bench.tick(150)
    bench.hear_torque()
    bench.tick(199)
    assert bench.axis().mode == ControlMode.POSITION
    bench.tick()
    assert bench.axis().mode == ControlMode.HW_FAULT
    assert not bench.board.ports[PLAIN].enabled


def test_torques_may_be_silent_while_stiff(bench: Bench) -> None:
    bench.ready().compliant()
    bench.do(motor.SET_INTERACTION_MODE, 0)
    bench.tick(1000)
    assert bench.axis().mode == ControlMode.POSITION
    bench.enter(ControlMode.OPENLOOP)
    bench.do(motor.SET_INTERACTION_MODE, 1)
    bench.tick(1000)
    assert bench.axis().mode == ControlMode.OPENLOOP
    bench.enter(ControlMode.IDLE)
    bench.tick(1000)
    assert bench.axis().mode == ControlMode.IDLE


def test_an_axis_without_a_torque_source_faults_when_force_controlled(bench: Bench) -> None:
    bench.ready()
    bench.do(motor.SET_TORQUE_SOURCE, 12, 255)
    bench.send(motor.SET_INTERACTION_MODE, 1)
    bench.tick()
    assert bench.axis().mode == ControlMode.HW_FAULT


def test_a_torque_source_can_be_chosen(bench: Bench) -> None:
    bench.ready().enter(ControlMode.TORQUE)
    bench.enter(ControlMode.FORCE_IDLE)
    bench.do(motor.SET_TORQUE_SOURCE, 9, 4)
    bench.give((0x39B, bytes.fromhex("008064800080")))  # channel 4: 100 units
    bench.enter(ControlMode.TORQUE)
    assert bench.axis().torque_loop.pid.error == -100
    assert bench.axis().pwm == -100  # 64 * -100 >> 6


def test_torque_mode_runs_on_the_desired_torque(bench: Bench) -> None:
    bench.ready()
    bench.hear_torque(50)
    bench.enter(ControlMode.TORQUE)
    bench.do(motor.SET_DESIRED_TORQUE, 250)
    assert bench.axis().pwm == 200


def test_a_compliant_axis_is_a_spring_with_an_offset(bench: Bench) -> None:
    bench.ready()
    bench.do(motor.SET_IMPEDANCE_PARAMS, 10, 0)
    bench.compliant()
    bench.do(motor.SET_IMPEDANCE_OFFSET, 30)
    bench.place(2005)
    bench.hear_torque(-40)
    bench.tick()
    assert bench.axis().pwm == -10 * 5 + 30 + 40


def test_the_emergency_button_idles_and_is_told_in_every_status_slot(bench: Bench) -> None:
    bench.ready(mask=STATUS_MASK)
    bench.tick(10)
    for port in bench.board.ports:
        port.external_fault = True
    bench.tick()
    assert bench.axis().mode == ControlMode.IDLE
    assert not bench.board.ports[PLAIN].enabled
    slots = bench.axis().hardware.slots
    assert bench.statuses(5 * slots) == [(4, 0, 4, 0, 0, 0, 0, 0)] * 5
    for port in bench.board.ports:
        port.external_fault = False
    bench.tick(100)
    assert bench.axis().mode == ControlMode.IDLE  # no automatic restart
    assert bench.axis().fault_entries == 0


def test_under_the_emergency_button_a_mode_lasts_one_millisecond(bench: Bench) -> None:
    bench.ready().enter(ControlMode.IDLE)
    bench.board.ports[PLAIN].external_fault = True
    bench.enter(ControlMode.POSITION)
    assert bench.axis().mode == ControlMode.POSITION
    assert not bench.board.ports[PLAIN].enabled
    bench.tick()
    assert bench.axis().mode == ControlMode.IDLE


def test_an_encoder_error_faults_and_keeps_the_position(bench: Bench) -> None:
    bench.ready(mask=STATUS_MASK)
    bench.tick(10)
    bench.board.ports[PLAIN].encoder_fault = True
    bench.place(17)
    bench.tick()
    assert bench.axis().mode == ControlMode.HW_FAULT
    assert bench.ask(motor.GET_ENCODER_POSITION)[0] == 2000
    assert bench.statuses(10)[-1][2:4] == (AxisFault.ENCODER, ControlMode.HW_FAULT)


def test_a_hall_error_is_told_once(bench: Bench) -> None:
    bench.ready(mask=STATUS_MASK)
    bench.tick(10)
    bench.board.ports[PLAIN].hall_fault = 0b101
    told = bench.statuses(40)
    assert told == [(0, 0, AxisFault.HALL_A | AxisFault.HALL_C, ControlMode.HW_FAULT, 0, 0, 0, 0)]


def test_heat_faults_with_a_board_bit(bench: Bench) -> None:
    bench.ready(mask=STATUS_MASK)
    bench.tick(10)
    bench.board.ports[PLAIN].overheated = True
    status = bench.statuses(12)[0]
    assert bench.axis().mode == ControlMode.HW_FAULT
    assert status[5] == BoardStatus.OVERTEMPERATURE_1


def test_i2t_trips_when_the_integral_is_full(bench: Bench) -> None:
    bench.ready(mask=STATUS_MASK)
    hardware = bench.axis().hardware
    bench.do(motor.SET_CURRENT_LIMIT, 1000)
    bench.board.ports[PLAIN].current_ma = -9000
    per_ms = 8000**2 >> hardware.i2t_shift
    until_trip = hardware.i2t_trip // per_ms
    bench.tick(until_trip)
    assert bench.axis().mode == ControlMode.POSITION
    told = bench.statuses(20)
    assert bench.axis().mode == ControlMode.HW_FAULT
    assert [status[2] for status in told if status[2]] == [AxisFault.OVERCURRENT]


def test_i2t_cools_below_the_limit(bench: Bench) -> None:
    bench.ready()
    bench.do(motor.SET_CURRENT_LIMIT, 1000)
    port = bench.board.ports[PLAIN]
    port.current_ma = 1400
    bench.tick(10)
    assert bench.axis().i2t == 10 * (400**2 >> bench.axis().hardware.i2t_shift)
    port.current_ma = 0
    bench.tick(10)
    assert bench.axis().i2t == 0


def test_bus_off_faults_every_axis_and_is_told_afterwards(bench: Bench) -> None:
    bench.ready(mask=STATUS_MASK)
    bench.tick(10)
    bench.board.bus_off = True
    bench.send(motor.GET_CONTROL_MODE)
    assert bench.tick(10) == []
    assert {axis.mode for axis in bench.board.axes} == {ControlMode.HW_FAULT}
    bench.board.bus_off = False
    status = bench.statuses(10)[0]
    assert status[1] == status[3] == ControlMode.HW_FAULT
    assert status[4] == CanStatus.BUS_OFF
    assert [axis.fault_entries for axis in bench.board.axes] == [1] * len(bench.board.axes)


def test_a_discovery_switches_everything_off_without_a_word(bench: Bench) -> None:
    bench.ready(mask=0x37)
    bench.tick(10)
    bench.give((0x70F, b"\xff"))
    axis = bench.axis()
    version = axis.node.version
    assert bench.tick() == [
        (0x700 | bench.address << 4, bytes((0xFF, axis.hardware.board_type, *version, 87)))
    ]
    assert axis.mode == ControlMode.IDLE
    assert not bench.board.ports[PLAIN].enabled
    assert bench.tick(6000) == []


def test_class_7_labels_and_pings(bench: Bench) -> None:
    bench.do(motor.SET_ADDITIONAL_INFO, 0, *b"left")
    bench.give(management.GET_ADDITIONAL_INFO.request(bench.address))
    frames = bench.tick()
    assert len(frames) == 8
    assert frames[0] == (0x700 | bench.address << 4, b"\x0c\x00left")
    bench.give((0x700 | bench.address, b"\x04"))
    assert bench.tick() == [(0x700 | bench.address << 4, b"\x04\x01")]


def test_a_loop_overrun_is_told_once(bench: Bench) -> None:
    bench.configure(mask=STATUS_MASK)
    bench.tick(10)
    assert isinstance(bench.board, MotorBoard)
    bench.board.loop_overrun = True
    assert [status[5] for status in bench.statuses(30)] == [BoardStatus.LOOP_OVERRUN]


def test_bus_off_of_idle_axes_is_told_at_once_at_the_second_address_only(bench: Bench) -> None:
    bench.configure(mask=STATUS_MASK)
    for axis in bench.board.axes:
        axis.fault()
    bench.tick(20)  # the fault is told
    bench.board.bus_off = True
    bench.tick(3)
    bench.board.bus_off = False
    frames = bench.heard(bench.tick(10), motor_periodic.STATUS)
    sources = [source_of(can_id) for can_id, _ in frames]
    assert sources == list(bench.board.addresses[1:])


@pytest.mark.parametrize(
    ("bit", "flags"),
    [(CanStatus.TX_OVERRUN, b"\x01\x00"), (CanStatus.RX_OVERRUN, b"\x00\x01")],
)
def test_error_flags_stand_in_the_status_of_every_five_seconds_only(
    bench: Bench, bit: CanStatus, flags: bytes
) -> None:
    bench.configure(mask=STATUS_MASK)
    for until_ms, expected in ((100, b"\x00\x00"), (4999, flags)):  # the slot at 5002 is due
        bench.tick(until_ms - bench.axis().node.ms)
        bench.axis().pair.can_status = int(bit)
        (frame,) = (
            (can_id, data)
            for can_id, data in bench.heard(bench.tick(5), motor_periodic.STATUS)
            if source_of(can_id) == bench.address
        )
        assert frame[1][4:] == bytes((bit, 0)) + expected
