"""What only a BLL_IE does."""

from dataclasses import replace

import pytest

from firmware_sim.boards.board import BoardError
from firmware_sim.description import BoardSpec
from hal.wire import motor, motor_periodic
from hal.wire.modes import ControlMode
from hal.wire.motor_periodic import AxisFault
from tests.firmware_sim.boards.bench import Bench

RUNNING = ControlMode.POSITION


def spec(minor: int, address: int = 1) -> BoardSpec:
    return BoardSpec(bus=0, address=address, type="bll_ie", firmware=(2, minor))


@pytest.fixture
def bench() -> Bench:
    return Bench("bll_ie")


def test_handshake_of_the_sheet(bench: Bench) -> None:
    bench.give((0x001, bytes.fromhex("5b0106")))
    assert bench.tick() == [(0x010, bytes.fromhex("5b04025057010601"))]


def test_emergency_stop_of_the_sheet() -> None:
    bench = Bench("bll_ie", spec(0x50, address=3)).configure(mask=motor_periodic.STATUS.mask_bit)
    for port in bench.board.ports:
        port.external_fault = True
    frames = bench.tick(4)
    assert frames == [(0x133, bytes.fromhex("0400040000000000"))]


def test_position_and_pid_frames_come_every_four_milliseconds(bench: Bench) -> None:
    bench.configure(mask=0x3)
    bench.place(2104, axis=0)
    bench.place(3526)
    frames = bench.tick(40)
    positions = bench.heard(frames, motor_periodic.POSITION)
    assert positions[-1] == (0x111, bytes.fromhex("38080000c60d0000"))
    assert len(positions) == len(bench.heard(frames, motor_periodic.PID_VAL)) == 10


def test_the_bridge_ramps_in_steps_of_ten_up_to_760_counts(bench: Bench) -> None:
    bench.ready()
    bench.do(motor.SET_TLIM, 800)
    bench.enter(ControlMode.DIRECT)
    bench.send(motor.SET_COMMAND_POSITION, 3000)  # 1000 * 1000 >> 6, limited
    duties = []
    for _ in range(80):
        bench.tick()
        duties.append(bench.board.ports[1].pwm)
    assert duties[:3] == [10, 20, 30]
    assert duties[75:] == [760] * 5
    assert bench.axis().pwm == 760
    bench.enter(ControlMode.IDLE)
    assert bench.board.ports[1].pwm == 0


def test_pid_frame_carries_command_and_applied_duty(bench: Bench) -> None:
    bench.ready(mask=0x2).enter(ControlMode.DIRECT)
    bench.send(motor.SET_COMMAND_POSITION, 2010)  # 1000 * 10 >> 6 = 156
    frames = bench.tick()
    while bench.axis().node.ms % 4 != 1:
        frames = bench.tick()
    ((can_id, data),) = bench.heard(frames, motor_periodic.PID_VAL)
    assert can_id == 0x112
    pid0, pid1, duty0, duty1 = motor_periodic.PID_VAL.parse(data) or ()
    assert (pid0, pid1, duty0) == (0, 156, 0)
    assert duty1 == bench.board.ports[1].pwm < 50


def test_an_uncalibrated_single_axis_is_complained_about_and_runs_nevertheless(
    bench: Bench,
) -> None:
    bench.configure(mask=motor_periodic.PRINT.mask_bit)
    bench.send(motor.SET_CONTROL_MODE, RUNNING)
    assert bench.texts(10) == "calib failed, axis 1"
    assert bench.axis().mode == RUNNING
    assert bench.board.ports[1].enabled
    assert bench.axis().fault_entries == 0


def test_calibration_3_itself_is_complained_about(bench: Bench) -> None:
    bench.configure(mask=motor_periodic.PRINT.mask_bit)
    bench.send(motor.CALIBRATE_ENCODER, 3, 1706, 10, 348)
    assert bench.texts(10) == "calib failed, axis 1"
    assert bench.axis().calibrated


def test_a_strict_board_refuses_uncalibrated_axes_and_allows_their_calibration() -> None:
    strict = replace(spec(0x50), faithful=False, coupled=False)
    bench = Bench("bll_ie", strict).configure(mask=motor_periodic.PRINT.mask_bit)
    bench.send(motor.SET_CONTROL_MODE, RUNNING)
    assert bench.texts(10) == "calib failed, axis 1"
    assert bench.axis().mode == ControlMode.HW_FAULT
    assert not bench.board.ports[1].enabled
    bench.enter(ControlMode.FORCE_IDLE)
    bench.send(motor.CALIBRATE_ENCODER, 3, 1706, 10, 348)
    assert bench.texts(10) == ""
    assert bench.axis().mode == RUNNING


def test_speed_is_averaged_over_29_ms_and_scaled(bench: Bench) -> None:
    bench.tick()
    for _ in range(29):
        bench.board.ports[1].raw_encoder += 1
        bench.tick()
    assert bench.ask(motor.GET_ENCODER_VELOCITY) == (32,)  # 1 tick/ms
    bench.do(motor.SET_SPEED_ESTIM_SHIFT, 8, 8, 8, 8)
    bench.board.ports[1].raw_encoder -= 60
    bench.tick()
    assert bench.ask(motor.GET_ENCODER_VELOCITY) == (-300,)  # -34 * 256 / 29 = -300.1


def test_absolute_positions_wrap_at_a_turn(bench: Bench) -> None:
    bench.place(100)
    bench.do(motor.SET_OFFSET_ABS_ENCODER, 348)
    assert bench.ask(motor.GET_ENCODER_POSITION)[0] == 4096 - 248
    assert bench.ask(motor.GET_ENCODER_VELOCITY) == (0,)  # the jump is not a speed


def test_calibration_3_moves_from_the_sensed_position_to_p1(bench: Bench) -> None:
    bench.configure()
    bench.place(2300)
    bench.do(motor.CALIBRATE_ENCODER, 3, 1706, 10, 348)
    axis = bench.axis()
    assert (axis.mode, axis.calibrated, axis.compliant) == (RUNNING, True, False)
    assert axis.position == 1952
    assert bench.ask(motor.GET_CALIBRATION_STATUS) == (1, RUNNING, 0)
    bench.tick(100 * (1952 - 1706) // 10 // 2 - 2)
    assert axis.reference.ticks == (1952 + 1706) // 2
    bench.tick(1300)
    assert axis.reference.ticks == 1706


def test_calibration_3_without_speed_faults(bench: Bench) -> None:
    bench.configure(mask=motor_periodic.PRINT.mask_bit)
    bench.send(motor.CALIBRATE_ENCODER, 3, 1706, 0, 348)
    assert bench.texts(10) == "calib failed: speed 0, axis 1"
    assert bench.axis().mode == ControlMode.HW_FAULT


@pytest.mark.parametrize("offset", [-1, 4096])
def test_calibration_3_keeps_the_old_offset_when_the_new_one_is_out_of_range(
    bench: Bench, offset: int
) -> None:
    bench.configure()
    bench.do(motor.SET_OFFSET_ABS_ENCODER, 348)
    bench.do(motor.CALIBRATE_ENCODER, 3, 1706, 10, offset)
    assert bench.ask(motor.GET_OFFSET_ABS_ENCODER) == (348,)
    assert bench.axis().calibrated


@pytest.mark.parametrize("kind", [0, 1, 2, 4, 6, 7, 200])
def test_other_calibrations_are_ignored(bench: Bench, kind: int) -> None:
    bench.configure().do(motor.CALIBRATE_ENCODER, kind, 100, 10, 10)
    assert bench.axis().mode == ControlMode.IDLE
    assert not bench.axis().calibrated


def test_twenty_five_amperes_trip_at_once(bench: Bench) -> None:
    bench.ready(mask=motor_periodic.STATUS.mask_bit)
    bench.tick(8)
    bench.board.ports[1].current_ma = -25_000
    bench.tick()
    bench.board.ports[1].current_ma = 0
    assert bench.axis().mode == ControlMode.HW_FAULT
    assert [status[2:4] for status in bench.statuses(40)] == [
        (AxisFault.OVERCURRENT, ControlMode.HW_FAULT)
    ]


@pytest.mark.parametrize(("minor", "address", "sent"), [(0x54, 5, 0), (0x51, 6, 0), (0x50, 1, 5)])
def test_some_firmwares_withhold_position_while_an_encoder_fails(
    minor: int, address: int, sent: int
) -> None:
    bench = Bench("bll_ie", spec(minor, address)).configure(mask=0x1)
    bench.board.ports[0].encoder_fault = True
    assert len(bench.heard(bench.tick(20), motor_periodic.POSITION)) == sent


@pytest.mark.parametrize(
    ("minor", "address", "sources"),
    [
        (0x50, 1, ((12, 0), (12, 1))),
        (0x57, 2, ((12, 2), (12, 3))),
        (0x54, 5, ((12, 0), None)),
        (0x52, 6, ((12, 1), (12, 2))),
        (0x51, 9, ((11, 0), (11, 1))),
    ],
)
def test_torque_sources_are_compiled_in(
    minor: int, address: int, sources: tuple[tuple[int, int] | None, ...]
) -> None:
    bench = Bench("bll_ie", spec(minor, address))
    assert tuple(axis.wiring.torque_source for axis in bench.board.axes) == sources


@pytest.mark.parametrize(("minor", "address"), [(0x19, 1), (0x51, 1)])
def test_unknown_firmware_is_refused(minor: int, address: int) -> None:
    with pytest.raises(
        BoardError, match=r"known: 1\.50, 1\.51, .*2\.57; x\.51 at addresses 5 to 10 only"
    ):
        Bench("bll_ie", spec(minor, address))


def compliant_shoulder() -> Bench:
    """Torque gains that leave the compensation terms alone."""
    bench = Bench("bll_ie").ready()
    bench.do(motor.SET_TORQUE_PID, 0, 0, 0, 6)
    return bench.compliant()


def test_back_emf_is_compensated_with_the_measured_speed() -> None:
    bench = compliant_shoulder()
    bench.do(motor.SET_MOTOR_PARAMS, 18460, 7, 0, 0)
    for _ in range(40):
        bench.board.ports[1].raw_encoder += 1
        bench.tick()
    assert bench.axis().pwm == 144


def test_friction_follows_the_commanded_velocity_and_is_zero_at_standstill() -> None:
    bench = compliant_shoulder()

    def run(milliseconds: int) -> None:
        for _ in range(milliseconds // 10):
            bench.hear_torque()
            bench.tick(10)

    bench.do(motor.SET_TORQUE_STICTION_PARAMS, 4, 5)
    run(40)
    assert bench.axis().pwm == 0
    bench.do(motor.POSITION_MOVE, 2030, 10)  # 300 ms
    run(150)
    assert bench.axis().pwm == 4
    run(220)
    assert bench.axis().pwm == 0
    bench.do(motor.POSITION_MOVE, 2000, 10)
    run(150)
    assert bench.axis().pwm == -5


def test_a_compliant_axis_outside_its_range_is_not_driven_further_out() -> None:
    bench = compliant_shoulder()
    bench.do(motor.SET_TORQUE_PIDLIMITS, 50, 700, 0)  # a constant push towards higher ticks
    assert bench.axis().pwm == 50
    bench.place(3501)
    bench.tick()
    assert bench.axis().pwm == 0
    bench.place(499)
    bench.tick()
    assert bench.axis().pwm == 50


def test_the_torque_limit_is_behind_the_compensation() -> None:
    bench = compliant_shoulder()
    bench.do(motor.SET_TORQUE_PIDLIMITS, 50, 20, 0)
    bench.tick()
    assert bench.axis().pwm == 20


def test_the_filtered_torque_loop_takes_over_the_holding_pwm() -> None:
    bench = Bench("bll_ie").ready()
    bench.do(motor.SET_TCFILTER_TYPE, 3)
    bench.do(motor.SET_TORQUE_PID, 0, 0, 0, 6)
    bench.enter(ControlMode.DIRECT)
    bench.do(motor.SET_COMMAND_POSITION, 2010)
    bench.tick(100)
    assert bench.axis().pwm == 156
    bench.compliant()
    assert bench.axis().pwm == 153  # decays with the filter: 156 * (1 - 0.0187)
