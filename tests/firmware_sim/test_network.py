"""Boards of a network: one bank for all motor boards, frames between them, addresses."""

import pytest

from firmware_sim.boards.board import Board
from firmware_sim.description import AxisSpec, BoardSpec
from firmware_sim.network import Network
from firmware_sim.registry import make_board
from hal.wire import motor, motor_periodic
from hal.wire.analog import FORCE, ZERO_WORD
from hal.wire.can import Frame, Received
from hal.wire.message import AxisCommand
from hal.wire.modes import ControlMode

SPECS = (
    BoardSpec(bus=3, address=6, type="bll_ie", firmware=(2, 0x51)),
    BoardSpec(bus=3, address=7, type="bll", firmware=(2, 0x51)),
    BoardSpec(bus=5, address=3, type="dc4", firmware=(2, 0x19), coupled=False),
)
GAINS = (1000, 0, 50, 6)
LIMITS = (0, 700, 700)


@pytest.fixture
def network() -> Network:
    return Network(SPECS, ())


def requests(axis: int, now_ms: int) -> list[tuple[AxisCommand, tuple[int, ...]]]:
    """What a host asks of an axis in a millisecond: set-up, calibration, modes, set-points."""
    match now_ms:
        case 1:
            return [(motor.GET_FIRMWARE_VERSION, (1, 6))]
        case 2:
            return [
                (motor.SET_POS_PID, GAINS),
                (motor.SET_POS_PIDLIMITS, LIMITS),
                (motor.SET_BCAST_POLICY, (0xFF,)),
            ]
        case 3:
            return [(motor.CALIBRATE_ENCODER, (3, 2000, 10, 0))]
        case 50:
            mode = (ControlMode.POSITION, ControlMode.IMPEDANCE_POSITION)[axis % 2]
            return [(motor.SET_CONTROL_MODE, (mode,))]
        case 60:
            return [(motor.POSITION_MOVE, (2100, 200))]
        case 400:
            return [(motor.SET_CONTROL_MODE, (0x60,))]  # the board has no such mode
    return []


def frames_for(spec: BoardSpec, axes: int, now_ms: int) -> list[Frame]:
    """Requests to every axis of a board, and torques."""
    frames = [
        command.request(spec.address + axis // 2, axis % 2, *values)
        for axis in range(axes)
        for command, values in requests(axis, now_ms)
    ]
    if now_ms % 10 == 0 and now_ms < 300:  # they fall silent
        frames.append(FORCE.frame(12, ZERO_WORD, ZERO_WORD + now_ms, ZERO_WORD - 50))
    return frames


def encoder(row: int, now_ms: int) -> int:
    return 2000 + (now_ms * (row + 1) >> 4) % 200


def received(frames: list[Frame]) -> list[Received]:
    return [(can_id, data, 0) for can_id, data in frames]


def test_boards_in_one_bank_behave_as_each_does_alone(network: Network) -> None:
    alone = [make_board(spec) for spec in SPECS]
    modes = set()
    for now_ms in range(1, 600):
        asked = [
            frames_for(spec, len(board.axes), now_ms)
            for spec, board in zip(SPECS, alone, strict=True)
        ]
        expected: dict[int, list[Frame]] = {3: [], 5: []}
        row = 0
        for spec, board in zip(SPECS, alone, strict=True):
            for port in board.ports:
                port.raw_encoder = encoder(row, now_ms)
                row += 1
            # what others ask reaches a board's filter too
            heard = [
                frame
                for one, bus in zip(asked, SPECS, strict=True)
                if bus.bus == spec.bus
                for frame in one
            ]
            for frame in heard:
                if board.accepts(frame[0]):
                    board.on_frame(*frame)
            expected[spec.bus] += board.tick()
        network.bank.raw_encoder[:] = [encoder(number, now_ms) for number in range(row)]
        network.deliver({3: received(asked[0] + asked[1]), 5: received(asked[2])})
        assert network.tick() == expected
        modes |= {axis.mode for board in alone for axis in board.axes}
    assert modes >= {ControlMode.POSITION, ControlMode.IMPEDANCE_POSITION, ControlMode.HW_FAULT}


def test_a_row_of_the_bank_is_the_axis(network: Network) -> None:
    wired = AxisSpec(bus=5, address=4, axis=1, joint=None, motor=None)
    row = network.row(wired)
    assert row == 2 + 2 + 3
    network.bank.raw_encoder[row] = 1234
    network.bank.current_ma[row] = -56
    port = network.axis(wired).port
    assert (port.raw_encoder, port.current_ma) == (1234, -56)
    port.pwm, port.enabled = -7, True
    assert (network.bank.port_pwm[row], network.bank.port_enabled[row]) == (-7, 1)


def test_a_board_answers_at_the_address_that_it_was_given(network: Network) -> None:
    def ask(address: int) -> list[Frame]:
        network.deliver({3: received([motor.GET_CONTROL_MODE.request(address, 0)])})
        return network.tick()[3]

    assert ask(6) == [(0x060, b"\x07\x00\x00")]
    network.deliver({3: received([motor.SET_BOARD_ID.request(6, 0, 9)])})
    network.tick()
    assert ask(6) == []
    assert ask(9) == [(0x090, b"\x07\x00\x00")]
    assert network.row(AxisSpec(bus=3, address=6, axis=1, joint=None, motor=None)) == 1


def test_a_mask_that_is_set_late_tells_the_mode_in_its_first_status_slot(network: Network) -> None:
    board: Board = network.board(3, 6)
    board.axes[0].fault()
    for _ in range(20):
        network.deliver({})
        assert network.tick()[3] == []
    board.axes[0].pair.mask = motor_periodic.STATUS.mask_bit
    sent = []
    for _ in range(4):
        network.deliver({})
        sent += network.tick()[3]
    assert sent == [(0x163, b"\x00\xa0\x00\x00\x00\x00\x00\x00")]
