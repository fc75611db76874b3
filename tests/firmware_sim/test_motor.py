"""Drives against values worked out by hand."""

import numpy as np
import pytest
from numpy.typing import NDArray

from firmware_sim.description import MotorSpec
from firmware_sim.motor import Drives
from firmware_sim.plants import kernel

Vector = NDArray[np.float64]

STEP_S = 0.001

# 36 V, 1 ohm, 4.7 Nm/A at the joint: the shoulder
SHOULDER = MotorSpec(
    supply_v=36.0,
    torque_constant_nm_a=0.047,
    resistance_ohm=1.0,
    gear=100.0,
    rotor_inertia_kg_m2=1e-5,
    coulomb_nm=1.0,
    viscous_nms_rad=0.5,
)


def drives(enabled: bool = True, polarity: int = 1) -> Drives:
    made = Drives([SHOULDER, SHOULDER], [800, 1333], np.diag([polarity, polarity]) * 1.0, STEP_S)
    made.power(np.array([enabled, enabled]))
    return made


def current_a(of: Drives, pwm: Vector, dq_rad_s: Vector) -> Vector:
    """What the current sensors show, A."""
    n = len(pwm)
    state, constants = np.zeros((kernel.STATE_ROWS, n)), np.zeros((kernel.CONSTANT_ROWS, n))
    state[kernel.PWM], state[kernel.DX] = pwm, dq_rad_s
    constants[kernel.A_PER_COUNT], constants[kernel.BRAKING_AS_RAD] = (
        of.a_per_count,
        of.braking_as_rad,
    )
    shown = np.zeros((2, n), dtype=np.int64)
    nothing = np.zeros((2, 0), dtype=np.int64)
    width = np.full((2, n), -1, dtype=np.int64)
    level = np.zeros(n)
    kernel.show(state, constants, of.links, of.shares, nothing, np.zeros(0), level, width, shown)
    amperes: Vector = shown[1] / 1000.0
    return amperes


def test_stalled_motor_takes_supply_over_resistance_at_full_pwm() -> None:
    still = np.zeros(2)
    assert current_a(drives(), np.array([800.0, 1333.0]), still) == pytest.approx([36.0, 36.0])


def test_torque_per_count_follows_the_boards_full_count() -> None:
    still = np.zeros(2)
    torque = drives().torque_nm(np.array([1.0, 1.0]), still)
    assert torque == pytest.approx([4.7 * 36 / 800, 4.7 * 36 / 1333])


def test_motor_at_no_load_speed_takes_no_current() -> None:
    no_load_rad_s = 36.0 / 4.7
    current = current_a(drives(), np.array([800.0, 1333.0]), np.full(2, no_load_rad_s))
    assert current == pytest.approx([0.0, 0.0], abs=1e-12)


def test_enabled_bridge_without_pwm_brakes() -> None:
    torque = drives().torque_nm(np.zeros(2), np.full(2, 0.1))
    assert torque == pytest.approx([-0.1 * 4.7**2, -0.1 * 4.7**2])


def test_open_bridge_neither_drives_nor_brakes() -> None:
    off = drives(enabled=False)
    assert off.torque_nm(np.zeros(2), np.full(2, 3.0)).tolist() == [0.0, 0.0]
    assert current_a(off, np.zeros(2), np.full(2, 3.0)).tolist() == [0.0, 0.0]
    assert off.viscous_nms_rad.tolist() == [0.5, 0.5]  # the gear still has its friction


def test_negative_polarity_turns_torque_and_keeps_the_current_in_the_pwms_sign() -> None:
    turned = drives(polarity=-1)
    pwm, speed = np.array([80.0, 80.0]), np.array([-0.2, -0.2])
    assert turned.torque_nm(pwm, speed) == pytest.approx(-drives().torque_nm(pwm, -speed))
    assert current_a(turned, pwm, speed) == pytest.approx(current_a(drives(), pwm, -speed))


def test_rotor_inertia_is_seen_through_the_gear_squared() -> None:
    assert drives(enabled=False).inertia_kg_m2 == pytest.approx(np.diag([0.1, 0.1]))


def test_braking_over_a_step_counts_as_inertia() -> None:
    braked = 0.1 + STEP_S * 4.7**2
    assert drives().inertia_diagonal == pytest.approx([braked, braked])


def test_differential_adds_its_motors_torques_at_one_joint_and_cancels_them_at_the_other() -> None:
    waist = Drives([SHOULDER, SHOULDER], [800, 800], np.array([[1.0, -1.0], [1.0, 1.0]]), STEP_S)
    waist.power(np.ones(2, dtype=np.bool_))
    each = 100 * 4.7 * 36 / 800
    assert waist.torque_nm(np.array([100.0, 100.0]), np.zeros(2)) == pytest.approx([2 * each, 0.0])
    # joint 0 turns both motors at its own speed, joint 1 turns them against each other
    braked = 2 * (0.1 + STEP_S * 4.7**2)
    assert waist.inertia_kg_m2 == pytest.approx(np.diag([braked, braked]))
    assert current_a(waist, np.zeros(2), np.array([0.0, 0.1])) == pytest.approx([0.47, -0.47])


def test_axis_without_a_motor_gives_no_torque() -> None:
    axis = Drives([None], [1], np.eye(1), STEP_S)
    axis.power(np.ones(1, dtype=np.bool_))
    assert axis.torque_nm(np.array([500.0]), np.ones(1)).tolist() == [0.0]
