"""What the protocol asks of every motor board: power-up, gate, commands (can-protocol 1, 2)."""

import pytest

from firmware_sim import registry
from firmware_sim.boards.board import RECEIVE_FIFO_FRAMES, Board
from hal.wire import motor
from hal.wire.message import AxisCommand
from hal.wire.modes import ControlMode
from hal.wire.motor_periodic import CanStatus
from tests.firmware_sim.boards.bench import PLAIN, PRINT_MASK, STATUS_MASK, VERSIONS, Bench

SINGLE_GAINS = (
    motor.SET_P_GAIN,
    motor.SET_D_GAIN,
    motor.SET_I_GAIN,
    motor.SET_ILIM_GAIN,
    motor.SET_OFFSET,
    motor.SET_SCALE,
    motor.SET_TLIM,
)


def test_every_registered_motor_board_is_examined_here() -> None:
    assert set(VERSIONS) == set(registry.MOTOR_BOARDS)


def test_satisfies_the_interface(bench: Bench) -> None:
    board: Board = bench.board
    assert len(board.ports) == len(board.axes) == 2 * len(board.addresses)
    assert board.raw_adc == []


def test_boots_silent_idle_and_uncalibrated(bench: Bench) -> None:
    assert bench.tick(6000) == []
    assert bench.ask(motor.GET_CONTROL_MODE) == (ControlMode.IDLE,)
    assert bench.ask(motor.GET_CALIBRATION_STATUS) == (0, 0, 0)
    assert not any(port.enabled for port in bench.board.ports)


def test_gains_before_configuration(bench: Bench) -> None:
    assert bench.ask(motor.GET_POS_PID) == (10, 0, 40, 3)
    assert bench.ask(motor.GET_POS_PIDLIMITS) == (0, 0, 0x7FFF)
    assert bench.ask(motor.GET_TORQUE_PID) == (0, 0, 0, 10)
    assert bench.ask(motor.GET_MIN_POSITION) + bench.ask(motor.GET_MAX_POSITION) == (-5000, 5000)
    assert bench.ask(motor.GET_PWM_LIMIT) == (1333,)
    assert bench.ask(motor.GET_MAX_VELOCITY) == (0x7FFF,)


def test_power_cycle_forgets_everything_but_the_label(bench: Bench) -> None:
    bench.ready(mask=STATUS_MASK)
    bench.do(motor.SET_ADDITIONAL_INFO, 2, *b"knee")
    bench.board.power_cycle()
    assert bench.tick(10) == []
    assert bench.ask(motor.GET_CALIBRATION_STATUS) == (0, 0, 0)
    assert bench.ask(motor.GET_POS_PID) == (10, 0, 40, 3)
    bench.enter(ControlMode.POSITION)
    assert bench.axis().mode == ControlMode.HW_FAULT  # handshake and PIDs are forgotten too
    label = bench.do(motor.GET_ADDITIONAL_INFO)
    assert len(label) == 8
    assert b"\x8c\x02knee" in [data for _, data in label]


def test_without_power_a_board_is_silent_and_drives_nothing(bench: Bench) -> None:
    bench.ready(mask=0x7)
    bench.board.powered = False
    bench.send(motor.GET_CONTROL_MODE)
    assert bench.tick(20) == []
    assert not bench.board.ports[PLAIN].enabled
    assert bench.board.ports[PLAIN].pwm == 0


@pytest.mark.parametrize(
    ("host", "accepted"), [((1, 6), 1), ((1, 5), 1), ((1, 7), 0), ((2, 0), 0), ((0, 6), 0)]
)
def test_handshake_needs_equal_major_and_no_newer_minor(
    bench: Bench, host: tuple[int, int], accepted: int
) -> None:
    reply = bench.ask(motor.GET_FIRMWARE_VERSION, *host, axis=0)
    axis = bench.axis()
    assert reply == (axis.hardware.board_type, *axis.node.version, 87, 1, 6, accepted)


def test_refuses_to_run_without_handshake(bench: Bench) -> None:
    bench.configure(mask=STATUS_MASK | PRINT_MASK)
    bench.do(motor.GET_FIRMWARE_VERSION, 2, 0)
    bench.send(motor.SET_CONTROL_MODE, ControlMode.OPENLOOP)
    assert bench.texts(10) == "protocol not acknowledged, axis 1"
    assert bench.axis().mode == ControlMode.HW_FAULT
    assert not bench.board.ports[PLAIN].enabled


@pytest.mark.parametrize("missing", SINGLE_GAINS, ids=lambda command: command.name)
def test_refuses_to_run_until_all_seven_gains_came(bench: Bench, missing: AxisCommand) -> None:
    bench.do(motor.GET_FIRMWARE_VERSION, 1, 6)
    for command in SINGLE_GAINS:
        if command is not missing:
            bench.do(command, 1)
    assert bench.start() == ControlMode.HW_FAULT
    bench.do(missing, 1)
    bench.do(motor.SET_CONTROL_MODE, ControlMode.FORCE_IDLE)
    assert bench.start() == ControlMode.POSITION


def test_group_commands_raise_the_flags_of_the_sheet(bench: Bench) -> None:
    bench.do(motor.SET_POS_PID, 1, 1, 1, 1)
    assert bench.axis().pid_flags == 0x4F
    bench.do(motor.SET_POS_PIDLIMITS, 1, 1, 1)
    assert bench.axis().pid_flags == 0x7F


def test_wrong_lengths_are_dropped_without_an_answer(bench: Bench) -> None:
    bench.configure()
    address = bench.axis().pair.address
    for data in (b"\x1e\x00", b"\x1e\x00\x7d\x00", b"\x9e\x00", b"\x89", b"\x89\x01\x00"):
        bench.give((address, data))
    assert bench.tick() == []
    assert bench.board.dropped["length"] == 5
    assert bench.ask(motor.GET_P_GAIN) == (1000,)
    assert bench.axis().mode == ControlMode.IDLE


def test_commands_without_length_check_are_taken_at_any_length(bench: Bench) -> None:
    bench.ready()
    bench.hear_torque()
    address = bench.axis().pair.address
    bench.give((address, bytes((0x80 | 116, 1, 99))))
    assert bench.ask(motor.GET_INTERACTION_MODE) == (1,)
    bench.give((address, bytes((0x80 | 7, 1, 2, 3))))
    assert len(bench.tick()) == 1


def test_empty_and_foreign_frames_do_nothing(bench: Bench) -> None:
    bench.board.on_frame(bench.address, b"")
    bench.board.on_frame(0x00F, b"\x07")
    assert bench.tick() == []
    assert bench.board.dropped["address"] == 2
    assert not bench.board.accepts(0x00F)
    assert not bench.board.accepts(0x100 | bench.address)
    assert not bench.board.accepts(0x200 | bench.address)
    assert not bench.board.accepts(0x71F)  # class 7 from a board
    assert bench.board.accepts(0x3DA)
    assert bench.board.accepts(0x70F)


def test_an_unknown_command_ends_the_parsing_of_this_millisecond(bench: Bench) -> None:
    bench.give((bench.address, b"\x7f"))
    bench.send(motor.GET_CONTROL_MODE)
    assert bench.tick() == []
    assert len(bench.tick()) == 1
    assert bench.board.dropped["unknown"] == 1


def test_the_receive_fifo_holds_thirty_frames(bench: Bench) -> None:
    bench.configure(mask=STATUS_MASK)
    for number in range(RECEIVE_FIFO_FRAMES + 3):
        bench.send(motor.SET_MAX_VELOCITY, number)
    bench.tick()
    assert bench.axis().max_velocity == 29
    assert bench.board.dropped["overrun"] == 3
    assert [status[4] for status in bench.statuses(20)] == [CanStatus.RX_OVERRUN]


def test_replies_go_to_whoever_asked(bench: Bench) -> None:
    bench.board.on_frame(0x0E0 | bench.address, b"\x07")
    assert bench.tick() == [(bench.address << 4 | 0xE, b"\x07\x00\x00")]


@pytest.mark.parametrize(
    ("store", "read", "values"),
    [
        (motor.SET_P_GAIN, motor.GET_P_GAIN, (-32000,)),
        (motor.SET_SCALE, motor.GET_SCALE, (13,)),
        (motor.SET_POS_PID, motor.GET_POS_PID, (-3, 2, 1, 31)),
        (motor.SET_POS_PIDLIMITS, motor.GET_POS_PIDLIMITS, (-1, 800, 799)),
        (motor.SET_TORQUE_PID, motor.GET_TORQUE_PID, (-76, 0, 5, 14)),
        (motor.SET_TORQUE_PIDLIMITS, motor.GET_TORQUE_PIDLIMITS, (1, 2, 3)),
        (motor.SET_POS_STICTION_PARAMS, motor.GET_POS_STICTION_PARAMS, (4, -4)),
        (motor.SET_TORQUE_STICTION_PARAMS, motor.GET_TORQUE_STICTION_PARAMS, (4, 5)),
        (motor.SET_MOTOR_PARAMS, motor.GET_MOTOR_PARAMS, (18460, 7, -1, 2)),
        (motor.SET_MODEL_PARAMS, motor.GET_MODEL_PARAMS, (19, 3)),
        (motor.SET_TCFILTER_TYPE, motor.GET_TCFILTER_TYPE, (3,)),
        (motor.SET_IMPEDANCE_OFFSET, motor.GET_IMPEDANCE_OFFSET, (-1234,)),
        (motor.SET_MIN_POSITION, motor.GET_MIN_POSITION, (-70000,)),
        (motor.SET_PWM_LIMIT, motor.GET_PWM_LIMIT, (120,)),
        (motor.SET_DESIRED_TORQUE, motor.GET_DESIRED_TORQUE, (4096,)),
        (motor.SET_OFFSET_ABS_ENCODER, motor.GET_OFFSET_ABS_ENCODER, (4095,)),
        (motor.SET_DEBUG_PARAM, None, (7, 300)),
    ],
    ids=lambda row: row.name if isinstance(row, AxisCommand) else None,
)
def test_settings_are_kept_per_axis(
    bench: Bench,
    store: AxisCommand,
    read: AxisCommand | None,
    values: tuple[int, ...],
) -> None:
    if read is None:
        bench.do(store, *values)
        assert bench.ask(motor.GET_DEBUG_PARAM, values[0]) == (values[1],)
        return
    other = bench.ask(read, axis=0)
    bench.do(store, *values)
    assert bench.ask(read) == values
    assert bench.ask(read, axis=0) == other


def test_impedance_is_read_back_with_its_offset(bench: Bench) -> None:
    bench.do(motor.SET_IMPEDANCE_PARAMS, 144, 10803)
    bench.do(motor.SET_IMPEDANCE_OFFSET, 500)
    assert bench.ask(motor.GET_IMPEDANCE_PARAMS) == (144, 10803, 500)


def test_current_limit_is_refused_beyond_the_boards_maximum(bench: Bench) -> None:
    most_ma = bench.axis().hardware.max_current_limit_ma
    bench.configure(mask=PRINT_MASK)
    for refused in (0, most_ma + 1, 0xFFFFFFFF):
        bench.send(motor.SET_CURRENT_LIMIT, refused)
        assert bench.texts(8) == "current limit refused, axis 1"
    assert bench.axis().current_limit_ma == most_ma
    bench.do(motor.SET_CURRENT_LIMIT, 500)
    assert bench.axis().current_limit_ma == 500


def test_no_bytes_can_break_a_board(bench: Bench) -> None:
    bench.ready(mask=0xFFFF)
    bench.hear_torque()
    for code in range(256):
        for fill in (0x00, 0xFF, 0x80, 0x7F):
            for length in range(8):
                bench.board.on_frame(bench.address, bytes((code, *[fill] * length)))
            bench.tick(2)
    assert bench.board.dropped["length"] > 1000
