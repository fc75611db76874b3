"""Couplings of can-protocol 9.4: motors and encoders that act on several joints."""

import pytest

from firmware_sim.boards.couplings import identity
from hal.wire import motor
from hal.wire.modes import ControlMode
from tests.firmware_sim.boards.bench import Bench, coupled, spec_of

FAR = 100_000


def wanted(bench: Bench, *pwm: int) -> list[int]:
    """PWM of the motors when the axes ask for these in open loop."""
    for axis in range(len(pwm)):
        bench.do(motor.SET_MIN_POSITION, -FAR, axis=axis)
        bench.do(motor.SET_MAX_POSITION, FAR, axis=axis)
        bench.do(motor.SET_CONTROL_MODE, ControlMode.OPENLOOP, axis=axis)
    for axis, counts in enumerate(pwm):
        bench.send(motor.SET_OPENLOOP_PARAMS, counts, axis=axis)
    bench.tick()
    return [axis.pwm for axis in bench.board.axes]


def shown(bench: Bench, *encoders: int) -> list[int]:
    """Positions of the joints when the encoders have moved by these ticks."""
    for axis, ticks in enumerate(encoders):
        bench.board.ports[axis].raw_encoder += ticks
    bench.tick()
    return [axis.position for axis in bench.board.axes]


def calibrated(bench: Bench) -> Bench:
    """Type 3 on both axes of a pair."""
    for axis in (0, 1):
        bench.do(motor.CALIBRATE_ENCODER, 3, 2000, 10, 0, axis=axis)
    return bench


@pytest.mark.parametrize("major", [1, 2])
@pytest.mark.parametrize("kind", ["bll", "bll_ie"])
def test_the_second_shoulder_motor_follows_both_joints(kind: str, major: int) -> None:
    bench = coupled(kind, major, 0x50)
    assert wanted(bench, 100, 50) == [100, -82]  # 1.6455 * (50 - 100) = -82.3


@pytest.mark.parametrize("major", [1, 2])
def test_the_third_shoulder_motor_follows_the_partners_duties(major: int) -> None:
    bench = coupled("bll_ie", major, 0x57)
    bench.hear_partner(duties=(40, 10))
    assert wanted(bench, 20, 33) == [-16, 33]  # 1.6455 * (-40 + 10 + 20) = -16.5


def test_firmware_1_57_takes_the_partners_positions_out_of_its_motor_encoder() -> None:
    bench = coupled("bll", 1, 0x57)
    bench.hear_partner(positions=(300, 100))
    assert shown(bench, -1000, 0) == [815, 2000]  # 1000 * 40 / 65 + 300 - 100 = 815.4


def test_firmware_2_57_reads_the_joint() -> None:
    bench = coupled("bll", 2, 0x57)
    bench.hear_partner(positions=(300, 100))
    assert shown(bench, -1000, 0) == [1000, 2000]


@pytest.mark.parametrize("major", [1, 2])
def test_the_waist_is_a_differential(major: int) -> None:
    bench = calibrated(coupled("bll_ie", major, 0x52))
    assert wanted(bench, 100, 31) == [34, 65]  # 69 / 2 and 131 / 2, towards zero
    assert shown(bench, 7, -5) == [2007, 1995]


@pytest.mark.parametrize("minor", [0x62, 0x63])
def test_the_neck_is_a_differential(minor: int) -> None:
    bench = calibrated(coupled("bll_dc", 1, minor))
    assert wanted(bench, 100, 31) == [-34, 65]
    assert shown(bench, 7, -5) == [2007, 1995]


@pytest.mark.parametrize(("major", "first"), [(1, 0), (2, 2)])
def test_the_eyes_turn_by_version_and_vergence(major: int, first: int) -> None:
    bench = coupled("dc4", major, 0x15)
    asked = [0, 0, 0, 0]
    asked[first : first + 2] = 100, 31
    assert wanted(bench, *asked)[first : first + 2] == [65, 34]
    moved = [0, 0, 0, 0]
    moved[first : first + 2] = 120, -20
    before = [axis.position for axis in bench.board.axes]
    after = shown(bench, *moved)
    assert [new - old for new, old in zip(after, before, strict=True)][first : first + 2] == [
        100,
        140,
    ]


@pytest.mark.parametrize(("major", "yaw"), [(1, 22), (2, -8)])
def test_the_wrist_subtracts_its_motors_and_an_old_one_adds_its_encoders(
    major: int, yaw: int
) -> None:
    bench = coupled("dc4", major, 0x19)
    for axis in (1, 2):
        bench.do(motor.CALIBRATE_ENCODER, 3, 2000, 10, 0, axis=axis)
    assert wanted(bench, 10, 20, 50, 7) == [10, 20, 30, 7]
    before = [axis.position for axis in bench.board.axes]
    after = shown(bench, 0, 30, -8, 0)
    assert [new - old for new, old in zip(after, before, strict=True)] == [0, 30, yaw, 0]


@pytest.mark.parametrize(("kp", "proximal"), [(500, 70), (-500, 30)])
def test_the_sign_of_kp_tells_a_thumb_its_hand(kp: int, proximal: int) -> None:
    bench = coupled("dc4", 2, 0x28)
    bench.do(motor.SET_P_GAIN, kp, axis=0)
    assert wanted(bench, 20, 50, 0, 0) == [20, proximal, 0, 0]


@pytest.mark.parametrize(("major", "minor"), [(1, 0x28), (1, 0x30), (2, 0x30), (1, 0x11)])
def test_other_boards_of_head_and_hand_are_not_coupled(major: int, minor: int) -> None:
    bench = coupled("dc4", major, minor)
    assert bench.unit.firmware.coupling == identity(4)


def test_couplings_can_be_left_out() -> None:
    bench = Bench("", spec_of("bll_ie", 2, 0x50)).configure()
    assert wanted(bench, 100, 50) == [100, 50]
    assert bench.unit.firmware.partner is None


def test_debug_parameters_change_the_decoupling_of_the_shoulder() -> None:
    bench = coupled("bll_ie", 2, 0x50)
    assert bench.ask(motor.GET_DEBUG_PARAM, 10) == (-1645,)
    bench.do(motor.SET_DEBUG_PARAM, 10, -500)
    bench.do(motor.SET_DEBUG_PARAM, 11, 2000)
    assert bench.ask(motor.GET_DEBUG_PARAM, 11) == (2000,)
    assert wanted(bench, 100, 50) == [100, 50]  # -0.5 * 100 + 2 * 50
    lower = coupled("bll_ie", 2, 0x57)
    lower.hear_partner(duties=(40, 10))
    for index, value in ((12, 1000), (13, 3000), (14, -1000)):
        lower.do(motor.SET_DEBUG_PARAM, index, value)
    assert wanted(lower, 20, 0) == [50, 0]  # 40 + 3 * 10 - 20


def test_a_new_decoupling_is_forgotten_at_power_up() -> None:
    bench = coupled("bll_ie", 2, 0x50)
    bench.do(motor.SET_DEBUG_PARAM, 10, 0)
    bench.board.power_cycle()
    bench.configure()
    assert wanted(bench, 100, 50) == [100, -82]
