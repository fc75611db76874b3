"""Speeds of the tips as the target: taken up, held, ended, and kept inside the limits."""

from collections.abc import Sequence

import numpy as np
import pytest

from dforc.arrays import Matrix, Vector
from dforc.cartesian.controller import CartesianController
from dforc.cartesian.params import CartesianParams, Law
from dforc.cartesian.state import CartesianOutput, Measurement
from dforc.cartesian.targets import SpeedTarget, Target, TipSpeed
from dforc.ik.problem import Tip
from dforc.limits import JointLimits
from dforc.rotation import angle_between, matrix, rotation_error

PERIOD_S = 0.01
STIFF = (False,) * 10
UP = SpeedTarget(tips=[TipSpeed(linear_m_s=(0.0, 0.03, 0.05))])


def drive(
    controller: CartesianController, q_start: Vector, targets: Sequence[Target | None]
) -> list[CartesianOutput]:
    state, outputs = controller.start(q_start), []
    for target in targets:
        measured = Measurement(q_rad=state.q_plan, compliant=STIFF)
        state, output = controller.step(state, measured, target)
        outputs.append(output)
    return outputs


def positions(tip: Tip, outputs: list[CartesianOutput]) -> Matrix:
    return np.array([tip.pose(output.plan_q_rad)[1] for output in outputs])


@pytest.mark.parametrize("law", list(Law))
def test_hand_takes_up_the_speed_in_its_time_and_keeps_line_and_orientation(
    tip: Tip, limits: JointLimits, home: Vector, law: Law
) -> None:
    controller = CartesianController([tip], limits, CartesianParams(law=law))
    outputs = drive(controller, home, [UP] * 100)  # then the wrist meets its limit
    velocity = np.diff(positions(tip, outputs), axis=0) / PERIOD_S
    assert velocity[30:] == pytest.approx(np.tile([0.0, 0.03, 0.05], (69, 1)), abs=2e-4)
    assert velocity[14] == pytest.approx([0.0, 0.015, 0.025], abs=3e-3)  # half way, half the speed
    R, start = tip.pose(home)
    end_R, end = tip.pose(outputs[-1].plan_q_rad)
    assert end == pytest.approx(start + (1.0 - 0.15) * np.array([0.0, 0.03, 0.05]), abs=3e-4)
    assert angle_between(end_R, R) < 5e-4
    assert not outputs[-1].in_target


def test_hand_turns_at_the_commanded_rate_about_its_own_origin(
    tip: Tip, limits: JointLimits, home: Vector
) -> None:
    turn = SpeedTarget(tips=[TipSpeed(linear_m_s=(0.0, 0.0, 0.0), angular_rad_s=(0.0, 0.2, 0.1))])
    outputs = drive(CartesianController([tip], limits), home, [turn] * 100)
    R, start = tip.pose(home)
    end_R, end = tip.pose(outputs[-1].plan_q_rad)
    assert np.linalg.norm(end - start) < 2e-4
    assert rotation_error(R, end_R) == pytest.approx([0.0, 0.17, 0.085], abs=2e-3)
    assert angle_between(end_R, matrix([0.0, 0.17, 0.085]) @ R) < 2e-3


def test_orientation_may_be_left_free(tip: Tip, limits: JointLimits, home: Vector) -> None:
    free = SpeedTarget(tips=[TipSpeed(linear_m_s=(0.0, 0.0, 0.1), angular_rad_s=None)])
    outputs = drive(CartesianController([tip], limits), home, [free] * 100)
    R, start = tip.pose(home)
    end_R, end = tip.pose(outputs[-1].plan_q_rad)
    assert end - start == pytest.approx([0.0, 0.0, 0.085], abs=3e-4)
    assert angle_between(end_R, R) > 0.02


def test_end_of_the_command_is_a_stop_in_minimum_jerk(
    tip: Tip, limits: JointLimits, home: Vector
) -> None:
    targets: list[Target | None] = [UP] * 80
    outputs = drive(CartesianController([tip], limits), home, targets + [None] * 80)
    path = positions(tip, outputs)
    steps = np.linalg.norm(np.diff(path, 2, axis=0), axis=1) / PERIOD_S
    assert steps.max() < 0.06 * np.hypot(0.03, 0.05)
    assert path[-1] - path[79] == pytest.approx(0.2 * np.array([0.0, 0.03, 0.05]), abs=2e-4)
    assert np.abs(outputs[-1].dq_rad_s).max() < 1e-6
    assert outputs[-1].held


def test_limits_and_rows_hold_when_the_speed_leads_out_of_the_workspace(
    tip: Tip, limits: JointLimits, home: Vector
) -> None:
    for direction in np.vstack([np.eye(3), -np.eye(3)]):
        out = SpeedTarget(tips=[TipSpeed(linear_m_s=0.2 * direction)])
        outputs = drive(CartesianController([tip], limits), home, [out] * 400)
        assert any(output.limited for output in outputs)
        for output in outputs:
            assert limits.violation(output.plan_q_rad) <= 1e-8


def test_turning_round_at_a_limit_answers_at_once(
    tip: Tip, limits: JointLimits, home: Vector
) -> None:
    """Nothing winds up while the hand cannot follow."""
    out = SpeedTarget(tips=[TipSpeed(linear_m_s=(-0.2, 0.0, 0.0), angular_rad_s=None)])
    back = SpeedTarget(tips=[TipSpeed(linear_m_s=(0.2, 0.0, 0.0), angular_rad_s=None)])
    outputs = drive(CartesianController([tip], limits), home, [out] * 500 + [back] * 60)
    path = positions(tip, outputs)
    assert path[530, 0] > path[500, 0] + 0.01


def test_changed_speed_is_taken_up_smoothly(tip: Tip, limits: JointLimits, home: Vector) -> None:
    """A stick that is moved: another speed every period."""
    rng = np.random.default_rng(3)
    targets: list[Target | None] = [
        SpeedTarget(tips=[TipSpeed(linear_m_s=rng.uniform(-0.1, 0.1, 3))]) for _ in range(100)
    ]
    outputs = drive(CartesianController([tip], limits), home, targets)
    steps = np.linalg.norm(np.diff(positions(tip, outputs), 2, axis=0), axis=1) / PERIOD_S
    assert steps.max() < 0.2 * 1.5 * PERIOD_S / 0.3 * 1.5
