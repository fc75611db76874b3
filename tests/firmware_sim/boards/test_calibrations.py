"""Calibration types beside type 3 (can-protocol 10.5), firmware by firmware."""

import pytest

from hal.wire import motor
from hal.wire.modes import CalibrationType, ControlMode
from hal.wire.motor_periodic import PRINT
from tests.firmware_sim.boards.bench import SPECS, Bench, coupled

POSITION, HARD_STOP, INCREMENTAL = (
    ControlMode.POSITION,
    ControlMode.CALIB_HARD_STOP,
    ControlMode.CALIB_ABSOLUTE_INCREMENTAL,
)
# The types that each axis knows.
KNOWN = {
    0x11: ({0}, {0}, {0}, {0}),
    (1, 0x15): ({0}, {0}, {0}, {0}),
    (2, 0x15): ({3}, {3}, {0}, {0}),
    (1, 0x19): ({0}, {2}, {2}, {3, 7}),
    (2, 0x19): ({0}, {3}, {3}, {3, 7}),
    0x28: ({3, 7}, {4, 6}, {4, 6}, {4, 6}),
    0x30: ({4, 6}, {4, 6}, {4, 6}, {4, 6}),
}


@pytest.mark.parametrize("name", [name for name in SPECS if " " in name])
def test_types_that_a_firmware_has_not_are_silently_ignored(name: str) -> None:
    bench = Bench(name).configure(mask=PRINT.mask_bit)
    major, minor = SPECS[name].firmware
    known = KNOWN.get((major, minor), KNOWN.get(minor, ({3}, {3})))
    for axis, types in enumerate(known):
        for kind in (0, 1, 2, 3, 4, 5, 6, 7, 200):
            bench.do(motor.CALIBRATE_ENCODER, kind, 2000, 10, 10, axis=axis)
            started = bench.axis(axis).mode != ControlMode.IDLE
            assert started == (kind in types), (axis, kind)
            bench.enter(ControlMode.FORCE_IDLE, axis=axis)
    assert bench.board.dropped["calibration"] == sum(9 - len(types) for types in known)


def creep(bench: Bench, stops: dict[int, int], milliseconds: int) -> None:
    """Motors follow their references as far as their stops."""
    for _ in range(milliseconds):
        bench.tick()
        for number, stop in stops.items():
            port = bench.board.ports[number]
            port.raw_encoder = max(port.raw_encoder - 10, stop)


def test_an_eye_seeks_its_stop_while_the_other_holds() -> None:
    bench = coupled("dc4", 2, 0x15)
    bench.do(motor.CALIBRATE_ENCODER, 0, 200, -20, 0, axis=2)
    assert [bench.axis(axis).mode for axis in (2, 3)] == [HARD_STOP, POSITION]
    creep(bench, {2: 1001, 3: 1000}, 1300)
    version, vergence = bench.axis(2), bench.axis(3)
    assert version.mode == POSITION
    assert version.calibrated
    assert not vergence.calibrated
    assert bench.ask(motor.GET_ENCODER_POSITION, axis=2)[0] == 0
    assert abs(vergence.position - 1) <= 1  # 1001 - 1000 before; half a tick each way


def test_a_differential_wrist_seeks_its_stops_together() -> None:
    bench = coupled("dc4", 1, 0x19)
    bench.do(motor.CALIBRATE_ENCODER, 2, 150, -10, 0, axis=2)
    pitch, yaw = bench.axis(1), bench.axis(2)
    assert (pitch.mode, yaw.mode) == (HARD_STOP, HARD_STOP)
    assert bench.ask(motor.GET_CONTROL_MODE) == (ControlMode.CALIBRATION,)
    stops = {1: -20_000, 2: 1500}
    creep(bench, stops, 1500)
    assert (pitch.mode, yaw.mode) == (HARD_STOP, HARD_STOP)  # pitch still turns
    stops[1] = bench.board.ports[1].raw_encoder
    creep(bench, stops, 40)
    assert (pitch.mode, yaw.mode) == (POSITION, POSITION)
    assert pitch.calibrated
    assert yaw.calibrated
    assert (pitch.position, yaw.position) == (0, 0)
    assert (pitch.reference.ticks, yaw.reference.ticks) == (0, 0)


def test_hard_stop_pwm_is_limited_to_p1() -> None:
    bench = Bench("dc4 1.11").configure()
    bench.do(motor.CALIBRATE_ENCODER, 0, 90, -50, 0)
    pwms = []
    for _ in range(300):
        bench.tick()
        pwms.append(bench.board.ports[1].pwm)
    assert min(pwms) == -90


@pytest.mark.parametrize("minor", [0x19, 0x28])
def test_an_analog_axis_holds_where_it_is(minor: int) -> None:
    axis = 3 if minor == 0x19 else 0
    bench = coupled("dc4", 2, minor)
    for kind in (CalibrationType.DIGITAL_ABSOLUTE, CalibrationType.HALL):
        bench.do(motor.CALIBRATE_ENCODER, kind, 2291, 100, 0, axis=axis)
        finger = bench.axis(axis)
        assert finger.calibrated
        assert finger.mode == POSITION
        bench.tick(500)
        assert finger.reference.ticks == finger.position == 2000
        bench.board.power_cycle()
        bench.configure()


@pytest.mark.parametrize(("kind", "axis"), [(3, 0), (4, 1), (6, 2)])
def test_a_calibration_without_speed_faults_and_prints(kind: int, axis: int) -> None:
    bench = Bench("dc4 2.28").configure(mask=PRINT.mask_bit)
    bench.send(motor.CALIBRATE_ENCODER, kind, 100, 0, 500, axis=axis)
    assert bench.texts(10) == f"calib failed: speed 0, axis {axis % 2}"
    assert bench.axis(axis).mode == ControlMode.HW_FAULT


def test_type_four_shows_its_mode_until_its_trajectory_ends() -> None:
    bench = Bench("dc4 2.30").configure()
    bench.do(motor.SET_MIN_POSITION, 0)
    bench.place(20)
    bench.tick()
    bench.do(motor.CALIBRATE_ENCODER, 4, 220, 20, 900)  # 200 ticks at 200 ticks/s
    axis = bench.axis()
    bench.tick(990)
    assert axis.mode == INCREMENTAL
    assert bench.ask(motor.GET_CONTROL_MODE) == (ControlMode.CALIBRATION,)
    assert bench.ask(motor.GET_CALIBRATION_STATUS) == (0, 0x41, 0)
    bench.tick(10)
    assert axis.mode == POSITION
    assert axis.calibrated


@pytest.mark.parametrize(
    ("name", "axis", "p3", "low", "high"),
    [
        ("dc4 2.28", 1, 700, -1800, 700),  # thumb proximal
        ("dc4 2.28", 2, 700, -3000, 700),  # distal joints
        ("dc4 2.28", 2, -700, -700, 3000),
        ("dc4 2.28", 3, 700, -300, 700),  # proximal joints
        ("dc4 2.30", 3, 700, 0, 700),  # ring and little
    ],
)
def test_type_four_leaves_the_motor_between_p3_and_a_fixed_limit(
    name: str, axis: int, p3: int, low: int, high: int
) -> None:
    bench = Bench(name).configure()
    bench.do(motor.CALIBRATE_ENCODER, 4, 2000, 100, p3, axis=axis)
    bench.tick(3)
    assert bench.axis(axis).mode == POSITION
    port = bench.board.ports[axis]
    here = port.raw_encoder
    bench.enter(ControlMode.OPENLOOP, axis=axis)
    for pwm, limit in ((60, high), (-60, low)):
        bench.do(motor.SET_OPENLOOP_PARAMS, pwm, axis=axis)
        port.raw_encoder = here + limit
        bench.tick()
        assert port.pwm == 0
        port.raw_encoder = here + limit - (1 if pwm > 0 else -1)
        bench.tick()
        assert port.pwm == pwm


def test_motor_limits_can_be_set() -> None:
    bench = Bench("dc4 2.30")
    bench.board.power_cycle()
    bench.place(2000)
    bench.configure()
    bench.do(motor.SET_MAX_MOTOR_POS, 50)
    bench.do(motor.SET_MIN_MOTOR_POS, -50)
    bench.enter(ControlMode.OPENLOOP)
    bench.do(motor.SET_OPENLOOP_PARAMS, 60)
    assert bench.board.ports[1].pwm == 60
    bench.board.ports[1].raw_encoder += 50
    bench.tick()
    assert bench.board.ports[1].pwm == 0


def test_motor_limits_are_unknown_to_other_boards() -> None:
    bench = Bench("bll_ie 2.51").configure()
    bench.do(motor.SET_MAX_MOTOR_POS, 50)
    assert bench.board.dropped["unknown"] == 1
