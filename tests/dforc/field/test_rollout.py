"""The paper's point in time: arrival, what traps it and what does not, the same bits every time."""

import math
import struct
from dataclasses import replace

import numpy as np
import pytest

from dforc.errors import NotFiniteError
from dforc.field.force import (
    Ellipsoid,
    FieldError,
    FieldParams,
    PointState,
    Target,
    Triple,
    ball,
    scene_of,
)
from dforc.field.rollout import PERIOD_S, Path, roll_out, step

START = PointState(position_m=(0.0, 0.0, 0.0))
GOAL = Target(position_m=(0.3, 0.0, 0.0))
NEAR_M = 5e-3


def arrival_s(path: Path, goal_m: Triple, within_m: float = NEAR_M) -> float | None:
    """When the point comes within reach of the goal for good; None when it does not."""
    away = np.linalg.norm(path.positions_m - np.array(goal_m), axis=1) > within_m
    last = int(np.flatnonzero(away)[-1]) + 1
    return None if last == len(away) else last * PERIOD_S


def clearance_m(path: Path, item: Ellipsoid) -> float:
    distances = np.linalg.norm(path.positions_m - np.array(item.centre_m), axis=1)
    return float(distances.min()) - item.semi_axes_m[0]


def scalar_reference(
    goal_m: Triple, balls: list[Ellipsoid], params: FieldParams, steps: int
) -> list[tuple[float, ...]]:
    """The same path in plain floats, in the order of operations that the field promises."""
    k, d = params.stiffness_n_m, params.damping_ns_m
    x, v = [0.0, 0.0, 0.0], [0.0, 0.0, 0.0]
    path = [tuple(x)]
    for _ in range(steps):
        total = [k * (goal_m[i] - x[i]) - d * v[i] for i in range(3)]
        for item in balls:
            away = [x[i] - item.centre_m[i] for i in range(3)]
            parts = [away[i] / (item.semi_axes_m[i] + params.margin_m) for i in range(3)]
            q = parts[0] * parts[0] + parts[1] * parts[1] + parts[2] * parts[2]
            if q > 1.0:
                continue
            r = math.sqrt(away[0] * away[0] + away[1] * away[1] + away[2] * away[2])
            scale = params.gain_n * math.exp(-q) / r
            total = [total[i] + scale * away[i] for i in range(3)]
        v = [v[i] + PERIOD_S * total[i] for i in range(3)]
        x = [x[i] + PERIOD_S * v[i] for i in range(3)]
        path.append(tuple(x))
    return path


def test_free_reach_of_30_cm_comes_within_5_mm_in_7_79_s() -> None:
    path = roll_out(START, scene_of((GOAL,), (), FieldParams()), 1000)
    assert arrival_s(path, GOAL.position_m) == pytest.approx(7.79, abs=PERIOD_S + 1e-9)


def test_path_is_bit_for_bit_that_of_plain_floats() -> None:
    balls = [ball((0.15, 0.01, -0.005), 0.05), ball((0.22, -0.03, 0.01), 0.03)]
    params = FieldParams(margin_m=0.004)
    path = roll_out(START, scene_of((GOAL,), balls, params), 1500)
    expected = scalar_reference(GOAL.position_m, balls, params, 1500)
    packed = [struct.pack("3d", *row) for row in path.positions_m.tolist()]
    assert packed == [struct.pack("3d", *row) for row in expected]


def test_roll_out_is_step_after_step_and_moves_nothing() -> None:
    scene = scene_of((GOAL,), (ball((0.15, 0.01, 0.0), 0.05),), FieldParams())
    state = replace(START, velocity_m_s=(0.0, 0.1, 0.0))
    path = roll_out(state, scene, 400)
    assert state == replace(START, velocity_m_s=(0.0, 0.1, 0.0))
    for k in range(401):
        assert state.position_m == tuple(path.positions_m[k].tolist())
        assert state.velocity_m_s == tuple(path.velocities_m_s[k].tolist())
        state = step(state, scene)


def test_roll_out_ends_early_at_the_target() -> None:
    path = roll_out(START, scene_of((GOAL,), (), FieldParams()), 3000, within_m=NEAR_M)
    assert 779 <= len(path.positions_m) - 1 <= 781
    assert path.positions_m[-1] == pytest.approx(GOAL.position_m, abs=NEAR_M)


def test_ball_exactly_in_front_stops_the_point_for_good() -> None:
    item = ball((0.15, 0.0, 0.0), 0.02)
    path = roll_out(START, scene_of((GOAL,), (item,), FieldParams(gain_n=8.0)), 6000)
    assert arrival_s(path, GOAL.position_m) is None
    assert path.positions_m[-1] == pytest.approx((0.13, 0.0, 0.0), abs=2e-3)


def test_a_tenth_of_a_millimetre_beside_it_the_point_goes_round() -> None:
    item = ball((0.15, 1e-4, 0.0), 0.02)
    path = roll_out(START, scene_of((GOAL,), (item,), FieldParams(gain_n=8.0)), 1500)
    assert arrival_s(path, GOAL.position_m) == pytest.approx(9.7, abs=0.1)


@pytest.mark.parametrize(("margin_m", "low_m", "high_m"), [(0.0, -2e-3, -1e-3), (0.01, 8e-3, 9e-3)])
def test_without_margin_the_ball_is_entered_and_with_one_it_is_not(
    margin_m: float, low_m: float, high_m: float
) -> None:
    item = ball((0.15, 1e-4, 0.0), 0.02)
    params = FieldParams(gain_n=8.0, margin_m=margin_m)
    assert (
        low_m
        < clearance_m(roll_out(START, scene_of((GOAL,), (item,), params), 1500), item)
        < high_m
    )


def test_tails_leave_the_point_beside_the_target_and_truncation_does_not() -> None:
    item = ball((0.22, 0.04, 0.0), 0.05)  # 3.9 cm from the target to its surface
    tails = roll_out(START, scene_of((GOAL,), (item,), FieldParams(truncated=False)), 6000)
    truncated = roll_out(START, scene_of((GOAL,), (item,), FieldParams()), 6000)
    assert 0.01 < np.linalg.norm(tails.positions_m[-1] - GOAL.position_m) < 0.03
    assert np.linalg.norm(truncated.positions_m[-1] - GOAL.position_m) < 1e-6


def test_target_that_moves_is_followed_two_seconds_behind() -> None:
    state, speed_m_s = START, 0.1
    for k in range(2000):
        target = Target(position_m=(speed_m_s * k * PERIOD_S, 0.0, 0.0))
        state = step(state, scene_of((target,), (), FieldParams()))
    lag_m = speed_m_s * 2000 * PERIOD_S - state.position_m[0]
    assert lag_m == pytest.approx(0.199, abs=0.002)


def test_obstacle_may_appear_between_two_steps() -> None:
    free, blocked = (
        scene_of((GOAL,), items, FieldParams()) for items in ((), (ball((0.15, 0.0, 0.0), 0.05),))
    )
    state = START
    for _ in range(100):
        state = step(state, free)
    assert state.position_m[0] > 0.05
    for _ in range(3000):
        state = step(state, blocked)
    assert state.position_m[0] < 0.105


@pytest.mark.parametrize("bad", [math.nan, math.inf, -math.inf])
def test_state_or_period_that_is_not_finite_is_refused(bad: float) -> None:
    scene = scene_of((GOAL,), (), FieldParams())
    with pytest.raises(NotFiniteError):
        step(replace(START, velocity_m_s=(0.0, bad, 0.0)), scene)
    with pytest.raises(NotFiniteError):
        step(START, scene, bad)
    with pytest.raises(NotFiniteError):
        roll_out(replace(START, position_m=(bad, 0.0, 0.0)), scene, 1)


def test_point_driven_beyond_all_numbers_is_refused() -> None:
    with pytest.raises(NotFiniteError):
        step(START, scene_of((Target(position_m=(1e308, 0.0, 0.0)),), (), FieldParams()))
    stiff = scene_of((GOAL,), (), FieldParams(stiffness_n_m=1e9))
    with pytest.raises(NotFiniteError):
        roll_out(START, stiff, 1000)


def test_period_and_number_of_steps_are_checked() -> None:
    scene = scene_of((GOAL,), (), FieldParams())
    with pytest.raises(FieldError, match="period"):
        step(START, scene, 0.0)
    with pytest.raises(FieldError, match="steps"):
        roll_out(START, scene, -1)
