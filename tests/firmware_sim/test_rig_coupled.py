"""Coupled boards and their plant: the firmware's sums and the mechanics cancel."""

from collections.abc import Iterable
from dataclasses import replace

import numpy as np
import pytest

from firmware_sim.description import AxisSpec, BoardSpec, MotorSpec, RigSpec
from firmware_sim.rig import Rig
from hal.wire import motor
from hal.wire.can import Frame
from hal.wire.motor_periodic import POSITION

TORSO_BUS, WAIST = 0, 6
PITCH, ROLL = 0, 1  # joints of the rig; axes 1 and 0 of the board
EYES = BoardSpec(bus=5, address=2, type="dc4", firmware=(2, 0x15))
EYE_MOTOR = MotorSpec(
    supply_v=12.0,
    torque_constant_nm_a=0.01,
    resistance_ohm=12.0,
    gear=100.0,
    rotor_inertia_kg_m2=1e-7,
    coulomb_nm=0.01,
    viscous_nms_rad=0.005,
)


def eye_axis(
    index: int, joint: str, encoder: tuple[float, float], stops: tuple[float, float]
) -> AxisSpec:
    return AxisSpec(
        bus=5,
        address=3,
        axis=index,
        joint=joint,
        motor=EYE_MOTOR,
        ticks_per_deg=encoder[0],
        zero_deg=encoder[1],
        hard_stop_deg=stops,
        start_deg=5.0,
        mechanism="single",
        inertia_kg_m2=2e-5,
    )


VERSION = eye_axis(0, "version", (568.88, -45.0), (-45.0, 45.0))
VERGENCE = eye_axis(1, "vergence", (284.44, 0.0), (0.0, 60.0))


def send(rig: Rig, bus: int, frames: Iterable[Frame]) -> None:
    for can_id, data in frames:
        rig.step({bus: [(can_id, data, 0)]})


def run(rig: Rig, ticks: int) -> None:
    for _ in range(ticks):
        rig.step({})


def configuration(
    address: int, axis: int, pid: tuple[int, int, int, int], limit_pwm: int
) -> list[Frame]:
    return [
        motor.GET_FIRMWARE_VERSION.request(address, axis, 1, 6),
        motor.SET_POS_PID.request(address, axis, *pid),
        motor.SET_POS_PIDLIMITS.request(address, axis, 0, limit_pwm, limit_pwm),
        motor.SET_MIN_POSITION.request(address, axis, -100_000),
        motor.SET_MAX_POSITION.request(address, axis, 100_000),
        motor.SET_PWM_LIMIT.request(address, axis, limit_pwm),
        motor.SET_BCAST_POLICY.request(address, axis, POSITION.mask_bit),
    ]


@pytest.fixture
def waist(exact_spec: RigSpec) -> Rig:
    """Roll and pitch of the torso calibrated at zero."""
    rig = Rig(exact_spec)
    for axis, offset in ((0, 364), (1, 836)):
        send(rig, TORSO_BUS, configuration(WAIST, axis, (32000, 60, 6000, 13), 800))
        calibrate = motor.CALIBRATE_ENCODER.request(WAIST, axis, 3, 2048, 10, offset)
        send(rig, TORSO_BUS, [calibrate])
    run(rig, 1000)
    return rig


def test_differential_moves_one_joint_and_holds_the_other(waist: Rig) -> None:
    target = round((12.0 + 180.0) * 11.375)
    send(waist, TORSO_BUS, [motor.POSITION_MOVE.request(WAIST, 0, target, 23)])
    both = []
    for _ in range(1500):
        waist.step({})
        both.append(waist.plant.pwm[[ROLL, PITCH]].copy())
    assert np.degrees(waist.q_rad[ROLL]) == pytest.approx(12.0, abs=0.5)
    assert np.degrees(waist.q_rad[PITCH]) == pytest.approx(0.0, abs=0.5)
    assert np.abs(both).max(axis=0).min() > 5.0  # both motors worked for it


def test_uncoupled_board_has_an_uncoupled_plant(exact_spec: RigSpec) -> None:
    boards = tuple(replace(board, coupled=False) for board in exact_spec.boards)
    rig = Rig(replace(exact_spec, boards=boards))
    assert rig.plant.drives.S.tolist() == np.eye(10).tolist()
    coupled = Rig(exact_spec).plant.drives.S
    assert coupled[1, :2].tolist() == [-1.0, 1.0]  # motor of roll: pitch stands before it
    assert coupled[0, :2].tolist() == [1.0, 1.0]


def test_eyes_find_their_zero_at_the_stops_and_move_apart(exact_spec: RigSpec) -> None:
    rig = Rig(replace(exact_spec, boards=(EYES,), axes=(VERSION, VERGENCE), sensors=()))
    for axis in (0, 1):  # powered together, so that both have to be configured
        send(rig, 5, configuration(3, axis, (20, 0, 60, 6), 1333))
    for axis, creep in ((0, 10), (1, -10)):
        send(rig, 5, [motor.CALIBRATE_ENCODER.request(3, axis, 0, 700, creep, 0)])
        run(rig, 4000)
    assert np.degrees(rig.q_rad) == pytest.approx([45.0, 0.0], abs=0.1)
    moves = [
        motor.POSITION_MOVE.request(3, 0, round((10.0 - 45.0) * 568.88), 2000),
        motor.POSITION_MOVE.request(3, 1, round(20.0 * 284.44), 1000),
    ]
    send(rig, 5, moves)
    run(rig, 3000)
    assert np.degrees(rig.q_rad) == pytest.approx([10.0, 20.0], abs=0.3)
