"""SET_CONTROL_MODE, cell by cell (can-protocol 10.2)."""

import pytest

from hal.wire import motor
from hal.wire.modes import ControlMode
from tests.firmware_sim.boards.bench import PLAIN, Bench

RUNNING = (0x01, 0x02, 0x03, 0x04, 0x05, 0x07, 0x08, 0x50)
UNSUPPORTED = (0x06, 0x0A, 0x0B, 0x10, 0x20, 0x40, 0x41, 0x60, 0xA0, 0xB0, 0xB1, 0xB2, 0xFF)
IDLE, FORCE_IDLE, FAULT = ControlMode.IDLE, ControlMode.FORCE_IDLE, ControlMode.HW_FAULT
STOPS: tuple[int, ...] = (IDLE, FORCE_IDLE)
REQUESTS = (*STOPS, *RUNNING, *UNSUPPORTED)


def ask_for(bench: Bench, mode: int) -> int:
    """Command 9; the mode of the axis in the same millisecond, a torque having come."""
    bench.hear_torque()
    bench.do(motor.SET_CONTROL_MODE, mode)
    return bench.axis().mode


def settle(bench: Bench, mode: int) -> None:
    """Bring the axis to a mode, from wherever it is."""
    ask_for(bench, FORCE_IDLE)
    if mode == FAULT:
        bench.axis().fault()
    elif mode != IDLE:
        assert ask_for(bench, mode) == mode


def test_from_idle(bench: Bench) -> None:
    bench.ready()
    for request in STOPS:
        settle(bench, IDLE)
        assert ask_for(bench, request) == IDLE
    for request in RUNNING:
        settle(bench, IDLE)
        assert ask_for(bench, request) == request
        assert bench.board.ports[PLAIN].enabled


def test_from_hardware_fault(bench: Bench) -> None:
    bench.ready()
    for request in REQUESTS:
        settle(bench, FAULT)
        expected = IDLE if request == FORCE_IDLE else FAULT
        assert ask_for(bench, request) == expected, hex(request)
        assert not bench.board.ports[PLAIN].enabled


@pytest.mark.parametrize("start", RUNNING)
def test_from_a_running_mode(bench: Bench, start: int) -> None:
    bench.ready()
    for request in RUNNING:
        settle(bench, start)
        assert ask_for(bench, request) == request
        assert bench.board.ports[PLAIN].enabled
    for request in STOPS:
        settle(bench, start)
        assert ask_for(bench, request) == IDLE
        assert not bench.board.ports[PLAIN].enabled


@pytest.mark.parametrize("start", [IDLE, ControlMode.POSITION])
def test_an_unsupported_code_faults_one_cycle_later(bench: Bench, start: int) -> None:
    bench.ready()
    for request in UNSUPPORTED:
        settle(bench, start)
        assert ask_for(bench, request) not in (IDLE, FAULT, *RUNNING), hex(request)
        assert bench.board.ports[PLAIN].pwm == 0
        bench.tick()
        assert bench.axis().mode == FAULT


@pytest.mark.parametrize("request_mode", RUNNING)
def test_the_checks_in_front_of_the_bridge(bench: Bench, request_mode: int) -> None:
    assert ask_for(bench, request_mode) == FAULT  # neither handshake nor gains
    ask_for(bench, FORCE_IDLE)
    bench.do(motor.GET_FIRMWARE_VERSION, 1, 6)
    assert ask_for(bench, request_mode) == FAULT  # no gains
    bench.configure()
    ask_for(bench, FORCE_IDLE)
    assert ask_for(bench, request_mode) == request_mode


def test_a_different_mode_clears_references_and_a_request_for_the_same_does_not(
    bench: Bench,
) -> None:
    bench.ready()
    for mode, cleared in ((ControlMode.POSITION, False), (ControlMode.MIXED, True)):
        settle(bench, ControlMode.POSITION)
        bench.do(motor.SET_IMPEDANCE_OFFSET, 300)
        bench.do(motor.SET_DESIRED_TORQUE, 200)
        bench.do(motor.POSITION_MOVE, 2400, 100)
        bench.tick(100)
        bench.axis().position_pid.integral = 77
        bench.send(motor.SET_CONTROL_MODE, mode)
        bench.tick()
        assert (bench.ask(motor.GET_IMPEDANCE_OFFSET) == (0,)) == cleared
        assert (bench.ask(motor.GET_DESIRED_TORQUE) == (0,)) == cleared
        assert (bench.ask(motor.GET_DESIRED_POSITION) == (2000,)) == cleared
        assert (bench.axis().position_pid.integral == 0) == cleared


@pytest.mark.parametrize("mode", [0x04, 0x05])
def test_impedance_modes_set_compliant_too(bench: Bench, mode: int) -> None:
    bench.ready()
    settle(bench, mode)
    assert bench.ask(motor.GET_INTERACTION_MODE) == (1,)


@pytest.mark.parametrize("mode", RUNNING)
def test_with_the_emergency_button_a_mode_returns_to_idle(bench: Bench, mode: int) -> None:
    bench.ready()
    settle(bench, IDLE)
    bench.board.ports[PLAIN].external_fault = True
    assert ask_for(bench, mode) == mode
    assert not bench.board.ports[PLAIN].enabled
    bench.hear_torque()
    bench.tick()
    assert bench.axis().mode == IDLE


def test_calibration_modes_are_shown_as_one(bench: Bench) -> None:
    bench.ready()
    for internal in (0x10, 0x20, 0x40, 0x41):
        bench.axis().mode = internal
        bench.axis().enabled = False
        bench.send(motor.GET_CALIBRATION_STATUS)
        bench.send(motor.GET_CONTROL_MODE)
        answers = [data for _, data in bench.tick()]
        assert [answers[0][2], answers[1][1]] == [internal, 0x60]
