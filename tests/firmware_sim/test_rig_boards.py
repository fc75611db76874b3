"""The rig with the emulated boards, driven by frames as a host would send them."""

from collections.abc import Iterable
from dataclasses import replace

import numpy as np
import pytest

from firmware_sim.description import RigSpec
from firmware_sim.rig import Rig
from hal.wire import motor
from hal.wire.can import Frame
from hal.wire.modes import ControlMode
from hal.wire.motor_periodic import POSITION

ARM_BUS = 2
ELBOW, PROSUP = 6, 7
ELBOW_WIRE, PROSUP_WIRE = (2, 1), (3, 0)  # address, axis


def send(rig: Rig, frames: Iterable[Frame]) -> None:
    """One frame a millisecond, as a careful host would."""
    for can_id, data in frames:
        rig.step({ARM_BUS: [(can_id, data, 0)]})


def run(rig: Rig, ticks: int) -> list[Frame]:
    sent: list[Frame] = []
    for _ in range(ticks):
        sent += rig.step({})[ARM_BUS]
    return sent


def configure(
    rig: Rig, wire: tuple[int, int], pid: tuple[int, int, int, int], limit_pwm: int
) -> None:
    address, axis = wire
    send(
        rig,
        [
            motor.GET_FIRMWARE_VERSION.request(address, axis, 1, 6),
            motor.SET_POS_PID.request(address, axis, *pid),
            motor.SET_POS_PIDLIMITS.request(address, axis, 0, limit_pwm, limit_pwm),
            motor.SET_MIN_POSITION.request(address, axis, -200_000),
            motor.SET_MAX_POSITION.request(address, axis, 200_000),
            motor.SET_PWM_LIMIT.request(address, axis, limit_pwm),
            motor.SET_BCAST_POLICY.request(address, axis, POSITION.mask_bit),
        ],
    )


@pytest.fixture
def holding(spec: RigSpec) -> Rig:
    """The elbow calibrated and held where it stood, 45 degrees; nothing else is driven."""
    rig = Rig(spec)
    configure(rig, ELBOW_WIRE, (32000, 60, 20, 13), 800)
    send(rig, [motor.CALIBRATE_ENCODER.request(*ELBOW_WIRE, 3, 2559, 10, 1371)])
    return rig


def test_calibrated_elbow_is_held_against_gravity(holding: Rig) -> None:
    run(holding, 1000)
    assert np.degrees(holding.q_rad[ELBOW]) == pytest.approx(45.0, abs=0.3)
    assert np.degrees(holding.q_rad[3]) > -29.0  # the shoulder is loose and swings to its rest
    assert holding.board_faults == 0


def test_board_reports_the_angle_that_the_plant_has(holding: Rig) -> None:
    frames = run(holding, 500)
    last = [data for can_id, data in frames if can_id == 0x121][-1]
    values = POSITION.parse(last)
    assert values is not None
    angle_deg = values[1] / 11.375 - 180.0
    assert angle_deg == pytest.approx(np.degrees(holding.q_rad[ELBOW]), abs=0.15)


def test_elbow_moves_where_it_is_told(holding: Rig) -> None:
    ticks = round((70.0 + 180.0) * 11.375)
    send(holding, [motor.POSITION_MOVE.request(*ELBOW_WIRE, ticks, 23)])  # 20 deg/s
    run(holding, 2500)
    assert np.degrees(holding.q_rad[ELBOW]) == pytest.approx(70.0, abs=0.3)
    assert holding.motor_torque_nm[ELBOW] != 0.0


def test_lost_encoder_opens_the_bridge_and_counts_one_fault(holding: Rig) -> None:
    run(holding, 100)
    holding.board(ARM_BUS, 2).ports[1].encoder_fault = True
    run(holding, 100)
    assert holding.board_faults == 1
    assert holding.motor_torque_nm[ELBOW] == 0.0


def test_hard_stop_calibration_zeroes_the_ticks_at_the_stop(spec: RigSpec) -> None:
    axes = list(spec.axes)
    axes[PROSUP] = replace(axes[PROSUP], hard_stop_deg=(-74.0, 74.0), start_deg=40.0)
    rig = Rig(replace(spec, axes=tuple(axes)))
    configure(rig, PROSUP_WIRE, (-200, -1, -1000, 6), 1333)
    send(rig, [motor.CALIBRATE_ENCODER.request(*PROSUP_WIRE, 0, 900, -20, 0)])
    run(rig, 3000)
    axis = rig.board(ARM_BUS, 3).axes[0]
    assert axis.calibrated
    assert axis.mode == ControlMode.POSITION
    assert np.degrees(rig.q_rad[PROSUP]) == pytest.approx(74.0, abs=0.5)
    assert abs(axis.position) < 0.5 * 706.67
    assert rig.limit_violations == 0  # it has not been inside its limits since
    send(rig, [motor.POSITION_MOVE.request(*PROSUP_WIRE, round(74.0 * 706.67), 2000)])
    run(rig, 5000)
    assert np.degrees(rig.q_rad[PROSUP]) == pytest.approx(0.0, abs=0.6)
    assert rig.limit_violations == 0


def test_unpowered_board_lets_go(holding: Rig) -> None:
    run(holding, 100)
    holding.board(ARM_BUS, 2).powered = False
    run(holding, 300)
    assert holding.motor_torque_nm[ELBOW] == 0.0
    assert np.degrees(holding.q_rad[ELBOW]) < 44.0


def test_same_seed_gives_the_same_run_and_another_seed_another(spec: RigSpec) -> None:
    def words(seed: int) -> tuple[tuple[float, ...], list[int]]:
        rig = Rig(replace(spec, plant=replace(spec.plant, seed=seed)))
        run(rig, 50)
        return rig.q_rad, list(rig.board(ARM_BUS, 13).raw_adc)

    assert words(4) == words(4)
    assert words(4) != words(5)
