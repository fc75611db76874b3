"""Axes that are enabled, disabled and calibrated together (can-protocol 10.2 and 10.5)."""

import pytest

from hal.wire import motor
from hal.wire.modes import ControlMode
from hal.wire.motor_periodic import PRINT, STATUS
from tests.firmware_sim.boards.bench import Bench, coupled

PAIRS = {
    "waist": ("bll_ie", 2, 0x52, 0, 1),
    "neck": ("bll_dc", 1, 0x62, 0, 1),
    "wrist": ("dc4", 2, 0x19, 1, 2),
}
IDLE, POSITION, FAULT = ControlMode.IDLE, ControlMode.POSITION, ControlMode.HW_FAULT


@pytest.fixture(params=sorted(PAIRS))
def pair(request: pytest.FixtureRequest) -> tuple[Bench, int, int]:
    """A bench and the numbers of two coupled axes with absolute encoders."""
    kind, major, minor, one, other = PAIRS[request.param]
    return coupled(kind, major, minor), one, other


def calibrate(bench: Bench, axis: int, target: int = 2100) -> None:
    bench.do(motor.CALIBRATE_ENCODER, 3, target, 10, 0, axis=axis)


def modes(bench: Bench, *axes: int) -> list[int]:
    return [bench.axis(axis).mode for axis in axes]


def test_a_pair_is_powered_when_both_are_calibrated(pair: tuple[Bench, int, int]) -> None:
    bench, one, other = pair
    calibrate(bench, one)
    assert modes(bench, one, other) == [IDLE, IDLE]
    assert bench.ask(motor.GET_CALIBRATION_STATUS, axis=one) == (1, IDLE, 0)
    calibrate(bench, other, 1900)
    assert modes(bench, one, other) == [POSITION, POSITION]
    bench.tick(1100)
    assert [bench.axis(axis).reference.ticks for axis in (one, other)] == [2100, 1900]


def test_the_offset_of_the_first_is_stored_at_once(pair: tuple[Bench, int, int]) -> None:
    bench, one, _ = pair
    bench.do(motor.CALIBRATE_ENCODER, 3, 2100, 10, 300, axis=one)
    assert bench.ask(motor.GET_OFFSET_ABS_ENCODER, axis=one) == (300,)
    assert bench.axis(one).position == 1700


def test_a_pair_is_enabled_in_the_mode_that_one_asks_for(pair: tuple[Bench, int, int]) -> None:
    bench, one, other = pair
    calibrate(bench, one)
    calibrate(bench, other)
    bench.enter(IDLE, axis=other)
    assert modes(bench, one, other) == [IDLE, IDLE]
    bench.enter(ControlMode.DIRECT, axis=one)
    assert modes(bench, one, other) == [ControlMode.DIRECT] * 2
    assert all(bench.board.ports[axis].enabled for axis in (one, other))
    bench.enter(ControlMode.VELOCITY, axis=other)  # switched alone while both run
    assert modes(bench, one, other) == [ControlMode.DIRECT, ControlMode.VELOCITY]
    bench.enter(ControlMode.FORCE_IDLE, axis=one)
    assert modes(bench, one, other) == [IDLE, IDLE]


def test_the_partner_of_a_faulting_axis_drops_to_idle(pair: tuple[Bench, int, int]) -> None:
    bench, one, other = pair
    calibrate(bench, one)
    calibrate(bench, other)
    bench.board.ports[one].encoder_fault = True
    bench.tick()
    assert modes(bench, one, other) == [FAULT, IDLE]
    assert not bench.board.ports[other].enabled
    assert bench.axis(other).fault_entries == 0


def test_an_axis_does_not_run_beside_a_partner_in_fault(pair: tuple[Bench, int, int]) -> None:
    bench, one, other = pair
    calibrate(bench, one)
    calibrate(bench, other)
    bench.axis(one).fault()
    bench.enter(POSITION, axis=other)
    assert modes(bench, one, other) == [FAULT, IDLE]
    bench.enter(ControlMode.FORCE_IDLE, axis=one)
    bench.enter(POSITION, axis=other)
    assert modes(bench, one, other) == [POSITION, POSITION]


@pytest.mark.parametrize("name", ["waist", "neck"])
def test_an_uncalibrated_pair_is_really_refused(name: str) -> None:
    kind, major, minor, one, other = PAIRS[name]
    bench = coupled(kind, major, minor)
    bench.do(motor.SET_BCAST_POLICY, PRINT.mask_bit | STATUS.mask_bit)
    calibrate(bench, one)
    bench.send(motor.SET_CONTROL_MODE, POSITION, axis=one)
    assert bench.texts(10) == f"calib failed, axis {other}"
    assert modes(bench, one, other) == [IDLE, FAULT]
    assert not any(port.enabled for port in bench.board.ports)


def test_a_pair_lacks_gains_together() -> None:
    bench = coupled("dc4", 2, 0x15)
    bench.axis(3).pid_flags = 0x7E
    bench.enter(POSITION, axis=2)
    assert modes(bench, 2, 3) == [IDLE, FAULT]


def test_other_axes_of_the_board_are_not_concerned() -> None:
    bench = coupled("dc4", 2, 0x19)
    bench.enter(POSITION, axis=0)
    assert modes(bench, 0, 1, 2, 3) == [POSITION, IDLE, IDLE, IDLE]
    bench.enter(POSITION, axis=3)
    bench.axis(0).fault()
    assert modes(bench, 0, 3) == [FAULT, POSITION]


@pytest.mark.parametrize("major", [1, 2])
def test_eyes_are_enabled_together_on_axes_two_and_three(major: int) -> None:
    bench = coupled("dc4", major, 0x15)
    bench.enter(POSITION, axis=3)
    assert modes(bench, 0, 1, 2, 3) == [IDLE, IDLE, POSITION, POSITION]
