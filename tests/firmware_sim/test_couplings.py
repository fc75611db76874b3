"""Couplings of motors, encoders and joints against the rows of can-protocol 9.4."""

from collections.abc import Sequence
from typing import Literal

import numpy as np
import pytest

from firmware_sim.boards import couplings as firmware
from firmware_sim.boards.dc4 import Dc4
from firmware_sim.boards.hardware import Coupling
from firmware_sim.description import AxisSpec, BoardSpec
from firmware_sim.plants.couplings import (
    CoupledBoard,
    coupled_board,
    encoder_readout,
    motor_speeds,
)

T = 1.6455


def axis(
    address: int,
    index: int,
    ticks_per_deg: float = 11.375,
    *,
    zero_deg: float = 0.0,
    pwm_polarity: int = 1,
    mechanism: Literal["body", "single", "tendon"] = "body",
) -> AxisSpec:
    return AxisSpec(
        bus=1,
        address=address,
        axis=index,
        joint="j",
        motor=None,
        ticks_per_deg=ticks_per_deg,
        zero_deg=zero_deg,
        pwm_polarity=pwm_polarity,
        mechanism=mechanism,
    )


def on_board(
    coupling: Coupling, axes: Sequence[AxisSpec], partner: int | None = None
) -> list[CoupledBoard | None]:
    addresses = tuple(sorted({a.address for a in axes}))
    return [CoupledBoard(coupling, addresses, partner)] * len(axes)


def shoulder(polarity: int = 1) -> tuple[list[AxisSpec], list[CoupledBoard | None]]:
    axes = [axis(a, i, pwm_polarity=polarity) for a, i in ((1, 0), (1, 1), (2, 0), (2, 1))]
    upper = CoupledBoard(firmware.shoulder_upper(), (1,), 2)
    lower = CoupledBoard(firmware.shoulder_lower(), (2,), 1)
    return axes, [upper, upper, lower, lower]


def test_waists_motors_turn_by_difference_and_sum() -> None:
    axes = [axis(6, 0), axis(6, 1)]
    S = motor_speeds(axes, on_board(firmware.WAIST, axes))
    assert S.tolist() == [[1.0, -1.0], [1.0, 1.0]]


def test_necks_motors_have_the_polarity_of_each_joint() -> None:
    axes = [axis(1, 0), axis(1, 1, pwm_polarity=-1)]
    S = motor_speeds(axes, on_board(firmware.NECK, axes))
    assert S.tolist() == [[-1.0, -1.0], [1.0, -1.0]]


@pytest.mark.parametrize("polarity", [1, -1])
def test_shoulders_three_motors_follow_across_two_boards(polarity: int) -> None:
    speeds = motor_speeds(*shoulder(polarity))
    expected = [[1, 0, 0, 0], [-T, T, 0, 0], [-T, T, T, 0], [0, 0, 0, 1]]
    assert speeds == pytest.approx(polarity * np.array(expected))


def test_firmware_map_through_the_coupling_leaves_each_joint_of_the_waist_its_own_torque() -> None:
    axes = [axis(6, 0), axis(6, 1)]
    S = motor_speeds(axes, on_board(firmware.WAIST, axes))
    assert S.T @ np.array(firmware.WAIST.motors) == pytest.approx(np.eye(2))


def test_board_elsewhere_is_not_coupled_and_keeps_its_polarity() -> None:
    assert motor_speeds([axis(1, 0, pwm_polarity=-1)], [None]).tolist() == [[-1.0]]


def test_wrists_second_motor_turns_by_the_difference() -> None:
    axes = [axis(3, 1), axis(4, 0)]
    S = motor_speeds(axes, [CoupledBoard(firmware.WRIST_V2, (3, 4), None)] * 2)
    assert S.tolist() == [[1.0, 0.0], [-1.0, 1.0]]


def eyes() -> tuple[list[AxisSpec], list[CoupledBoard | None]]:
    version = axis(3, 0, 568.88, zero_deg=-45.0, mechanism="single")
    vergence = axis(3, 1, 284.44, mechanism="single")
    return [version, vergence], [CoupledBoard(firmware.EYES_V2, (2, 3), None)] * 2


def test_each_eye_turns_by_the_version_and_half_the_vergence() -> None:
    assert motor_speeds(*eyes()) == pytest.approx(np.array([[1.0, 0.5], [1.0, -0.5]]))


def test_each_eyes_encoder_counts_that_eye_and_is_zero_at_45_degrees() -> None:
    readout = encoder_readout(*eyes())

    def ticks(version_deg: float, vergence_deg: float) -> np.ndarray:
        shown: np.ndarray = readout.per_rad @ np.radians([version_deg, vergence_deg])
        return shown + readout.level

    assert ticks(45.0, 0.0) == pytest.approx([0.0, 0.0], abs=1e-9)
    # left eye at 15 + 10, right eye at 15 - 10
    assert ticks(15.0, 20.0) == pytest.approx([284.44 * (25 - 45), 284.44 * (5 - 45)])
    # and what 2.15 makes of them: version and vergence in ticks
    shown = ticks(15.0, 20.0)
    assert shown.sum() == pytest.approx(568.88 * (15 - 45))
    assert shown[0] - shown[1] == pytest.approx(284.44 * 20)


def test_joint_encoders_show_degrees_plus_zero() -> None:
    axes = [axis(6, 0, zero_deg=180.0), axis(6, 1, zero_deg=180.0)]
    readout = encoder_readout(axes, on_board(firmware.WAIST, axes))
    assert readout.per_rad @ np.radians([10.0, -20.0]) + readout.level == pytest.approx(
        [190.0 * 11.375, 160.0 * 11.375]
    )


def test_old_wrists_second_encoder_sits_on_its_motor() -> None:
    axes = [axis(3, 1, 978.46), axis(4, 0, 978.46)]
    readout = encoder_readout(axes, [CoupledBoard(firmware.WRIST_V1, (3, 4), None)] * 2)
    shown = readout.per_rad @ np.radians([10.0, 25.0])
    assert shown == pytest.approx([9784.6, 15.0 * 978.46])  # q2 = e1 + e2


def test_old_shoulders_yaw_encoder_is_what_its_firmware_takes_apart() -> None:
    axes, _ = shoulder()
    upper = CoupledBoard(firmware.shoulder_upper(), (1,), 2)
    lower = CoupledBoard(firmware.shoulder_lower(motor_encoder=True), (2,), 1)
    readout = encoder_readout(axes, [upper, upper, lower, lower])
    ticks = 11.375 * np.array([-30.0, 40.0, 20.0, 60.0])
    shown = readout.per_rad @ np.radians([-30.0, 40.0, 20.0, 60.0])
    assert shown[[0, 1, 3]] == pytest.approx(ticks[[0, 1, 3]])
    assert 40 / 65 * shown[2] + ticks[0] - ticks[1] == pytest.approx(ticks[2])


@pytest.mark.parametrize("polarity", [1, -1])
def test_thumbs_opposition_pulls_the_proximal_tendon_the_same_way_in_both_hands(
    polarity: int,
) -> None:
    axes = [
        axis(5, 0, 7.78, pwm_polarity=polarity, mechanism="single"),
        axis(5, 1, -2.5, mechanism="tendon"),
    ]
    hand = Dc4(BoardSpec(bus=5, address=5, type="dc4", firmware=(2, 0x28)))
    board = coupled_board(hand.firmware, hand.addresses, axes[0])
    S = motor_speeds(axes, [board, board])
    assert S.tolist() == [[polarity, 0.0], [1.0, 1.0]]
