"""What a motor board does when something happens, row by row (can-protocol 10.3).

Rows that need other boards on the bus, a partner or a MAIS, stand in tests/firmware_sim/boards.
"""

import pytest

from hal.wire import motor
from hal.wire.modes import ControlMode
from hal.wire.motor_periodic import AxisFault, BoardStatus, CanStatus
from tests.firmware_sim.boards.bench import PLAIN, STATUS_MASK, Bench

IDLE, POSITION, FAULT = ControlMode.IDLE, ControlMode.POSITION, ControlMode.HW_FAULT
RUNNING = (0x01, 0x02, 0x03, 0x04, 0x05, 0x07, 0x08, 0x50)
FORCE_CONTROLLED = (0x03, 0x04, 0x05)
COMPLIANT_MODES = (0x01, 0x02, 0x07, 0x08)
# x.51 and x.54 stop POSITION while an absolute encoder fails.
HIDING = (0x51, 0x54)


def running(bench: Bench, mode: int = POSITION, mask: int = STATUS_MASK) -> Bench:
    """An axis that runs in a mode, whose STATUS was sent."""
    bench.ready(mask)
    bench.hear_torque()
    bench.do(motor.SET_CONTROL_MODE, mode)
    bench.hear_torque()
    bench.tick(12)
    assert bench.axis().mode == mode
    return bench


def told(bench: Bench, milliseconds: int = 12) -> set[tuple[int, int]]:
    """Fault byte and mode of the axis in the STATUS frames of some time."""
    return {(status[2], status[3]) for status in bench.statuses(milliseconds)}


def test_power_up(every: Bench) -> None:
    for axis in range(len(every.board.axes)):
        assert every.ask(motor.GET_CALIBRATION_STATUS, axis=axis) == (0, IDLE, 0)
        assert every.axis(axis).pid_flags == 0
    assert not every.axis().node.accepted
    assert every.tick(200) == []  # masks 0


@pytest.mark.parametrize("mode", RUNNING)
def test_emergency_button(bench: Bench, mode: int) -> None:
    running(bench, mode)
    port = bench.board.ports[PLAIN]
    port.external_fault = True
    assert told(bench) == {(AxisFault.EXTERNAL, IDLE)}
    assert not port.enabled
    port.external_fault = False
    assert told(bench, 200) == set()
    assert bench.axis().mode == IDLE


def test_over_current_by_i2t(bench: Bench) -> None:
    running(bench)
    bench.do(motor.SET_CURRENT_LIMIT, 100)
    bench.axis().i2t = bench.axis().hardware.i2t_trip
    bench.board.ports[PLAIN].current_ma = 500
    assert told(bench) == {(AxisFault.OVERCURRENT, FAULT)}
    assert told(bench, 100) == set()  # told once


def test_absolute_encoder_error(every: Bench) -> None:
    running(every, mask=0x5)
    every.board.ports[PLAIN].encoder_fault = True
    every.place(17)
    frames = every.tick(20)
    positions = [data[4:] for can_id, data in frames if can_id & 0xF == 1 and can_id < 0x200]
    hides = every.axis().node.version[1] in HIDING
    assert every.axis().mode == FAULT
    assert every.axis().position == 2000
    assert (positions == []) == hides
    assert told(every) == {(AxisFault.ENCODER, FAULT)}


@pytest.mark.parametrize("code", range(1, 8))
def test_hall_error(bench: Bench, code: int) -> None:
    running(bench)
    bench.board.ports[PLAIN].hall_fault = code
    bits = (code & 1) * 0x10 | (code >> 1 & 1) * 0x40 | (code >> 2 & 1) * 0x80
    assert told(bench) == {(bits, FAULT)}


@pytest.mark.parametrize("axis", [0, 1])
def test_over_temperature(bench: Bench, axis: int) -> None:
    running(bench)
    bench.board.ports[axis].overheated = True
    bits = {status[5] for status in bench.statuses(15)}
    assert bench.axis(axis).mode == FAULT
    assert (BoardStatus.OVERTEMPERATURE_0, BoardStatus.OVERTEMPERATURE_1)[axis] in bits


def test_bus_off(bench: Bench) -> None:
    running(bench)
    bench.board.bus_off = True
    bench.tick()
    assert {axis.mode for axis in bench.board.axes} == {FAULT}
    bench.board.bus_off = False
    assert CanStatus.BUS_OFF in {status[4] for status in bench.statuses(12)}


@pytest.mark.parametrize("mode", FORCE_CONTROLLED)
def test_torque_source_silent_in_a_force_controlled_mode(bench: Bench, mode: int) -> None:
    running(bench, mode)
    bench.hear_torque()
    bench.tick(199)
    assert bench.axis().mode == mode
    assert told(bench) == {(0, FAULT)}  # no dedicated bit


@pytest.mark.parametrize("mode", COMPLIANT_MODES)
def test_torque_source_silent_while_compliant(bench: Bench, mode: int) -> None:
    running(bench, mode).compliant()
    bench.hear_torque()
    bench.tick(199)
    assert bench.axis().mode == mode
    bench.tick(2)
    assert bench.axis().mode == FAULT


@pytest.mark.parametrize("mode", [*COMPLIANT_MODES, 0x50])
def test_torque_source_and_host_silent_while_stiff(bench: Bench, mode: int) -> None:
    running(bench, mode)
    bench.tick(2000)
    assert bench.axis().mode == mode
    assert bench.axis().reference.ticks == 2000


def test_host_silent_in_velocity_mode(bench: Bench) -> None:
    running(bench, ControlMode.VELOCITY)
    bench.do(motor.SET_VEL_TIMEOUT, 100)
    bench.do(motor.VELOCITY_MOVE, 16, 0x7FFF)
    bench.tick(50)
    assert bench.ask(motor.GET_VELOCITY_MOVE_REF) == (16,)
    bench.tick(60)
    assert bench.ask(motor.GET_VELOCITY_MOVE_REF) == (0,)
    assert bench.axis().mode == ControlMode.VELOCITY


def test_reference_outside_the_limits(bench: Bench) -> None:
    running(bench, ControlMode.DIRECT)
    for asked, taken in ((100_000, 3500), (-100_000, 500)):
        bench.do(motor.SET_COMMAND_POSITION, asked)
        assert bench.axis().reference.ticks == taken
    bench.place(3700)  # software does not stop an axis that is outside
    bench.tick()
    assert bench.axis().mode == ControlMode.DIRECT
    bench.enter(ControlMode.OPENLOOP)
    bench.do(motor.SET_OPENLOOP_PARAMS, 80)
    assert bench.axis().pwm == 0


@pytest.mark.parametrize("to", ["everybody", "the board"])
def test_discovery(every: Bench, to: str) -> None:
    every.ready(mask=0x37)
    every.give((0x70F if to == "everybody" else 0x700 | every.address, b"\xff"))
    every.tick()
    assert not any(port.enabled or port.pwm for port in every.board.ports)
    assert every.tick(100) == []  # masks 0, and no STATUS says so
    assert every.axis().mode == IDLE
