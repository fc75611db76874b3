"""The force field: clearance, arrival, and what it refuses."""

import math
from dataclasses import replace

import numpy as np
import pytest

from dforc import rotation
from dforc.errors import NotFiniteError
from dforc.field import (
    Ellipsoid,
    FieldError,
    FieldParams,
    PointState,
    Triple,
    ball,
    force,
    repulsion,
    step,
)

PERIOD_S = 0.01
START: Triple = (0.0, 0.0, 0.0)
GOAL: Triple = (0.2, 0.0, 0.0)
ARRIVED_M = 1e-3


def run(
    goal: Triple, balls: list[Ellipsoid], params: FieldParams, seconds: float
) -> tuple[float, float | None]:
    """Smallest clearance [m] and time of arrival [s] of the point that starts at START."""
    state = PointState(position_m=START)
    clearance_m = math.inf
    for tick in range(int(seconds / PERIOD_S)):
        state = step(state, goal, balls, params, PERIOD_S)
        for item in balls:
            distance = math.dist(state.position_m, item.centre_m) - item.semi_axes_m[0]
            clearance_m = min(clearance_m, distance)
        if math.dist(state.position_m, goal) < ARRIVED_M and max(map(abs, state.velocity_m_s)) < (
            ARRIVED_M
        ):
            return clearance_m, (tick + 1) * PERIOD_S
    return clearance_m, None


def scene(rng: np.random.Generator) -> tuple[Triple, list[Ellipsoid]]:
    """A goal 25 to 45 cm away and a ball of 2 to 6 cm near the way, both ends 3 cm clear."""
    while True:
        u = rng.normal(size=3)
        goal = u / np.linalg.norm(u) * rng.uniform(0.25, 0.45)
        centre = goal * rng.uniform(0.2, 0.8) + rng.normal(size=3) * 0.04
        radius = rng.uniform(0.02, 0.06)
        if min(np.linalg.norm(centre), np.linalg.norm(centre - goal)) > radius + 0.03:
            return tuple(goal.tolist()), [ball(tuple(centre.tolist()), radius)]


def test_point_never_enters_a_ball_and_arrives_in_1000_random_scenes() -> None:
    rng = np.random.default_rng(7)
    for _ in range(1000):
        goal, balls = scene(rng)
        clearance_m, arrived_s = run(goal, balls, FieldParams(), 10.0)
        assert clearance_m > 0.0
        assert arrived_s is not None


def test_free_point_is_critically_damped() -> None:
    state = PointState(position_m=START)
    for _ in range(300):
        state = step(state, GOAL, [], FieldParams(), PERIOD_S)
        assert state.position_m[0] <= GOAL[0]  # no overshoot
    assert GOAL[0] - state.position_m[0] == pytest.approx(0.2 * 10 * math.exp(-9), rel=0.3)


def test_point_passes_a_ball_exactly_in_front() -> None:
    clearance_m, arrived_s = run(GOAL, [ball((0.1, 0.0, 0.0), 0.05)], FieldParams(), 12.0)
    assert clearance_m > 0.01
    assert arrived_s is not None


def test_point_passes_a_ball_that_is_off_the_line_by_a_tenth_of_a_millimetre() -> None:
    clearance_m, arrived_s = run(GOAL, [ball((0.1, 1e-4, 0.0), 0.05)], FieldParams(), 12.0)
    assert clearance_m > 0.01
    assert arrived_s is not None


def test_without_margin_the_ball_is_entered() -> None:
    params = FieldParams(margin_m=0.0)
    clearance_m, _ = run(GOAL, [ball((0.1, 0.01, 0.0), 0.05)], params, 10.0)
    assert -0.01 < clearance_m < 0.0


def test_sigma_of_the_radius_itself_acts_far_beyond_the_ball() -> None:
    """The paper's words taken literally: Sigma = diag(r) is a ball of sqrt(r)."""
    literal = ball((0.2, 0.1, 0.0), math.sqrt(0.05))
    _, arrived_s = run(GOAL, [literal], FieldParams(margin_m=0.0), 10.0)
    assert arrived_s is None
    _, arrived_s = run(GOAL, [ball((0.2, 0.1, 0.0), 0.05)], FieldParams(margin_m=0.0), 10.0)
    assert arrived_s is not None


def test_boundary_force_holds_the_point_out_against_a_goal_a_metre_behind() -> None:
    params = FieldParams()
    item = ball((0.0, 0.0, 0.0), 0.05)
    at_boundary = PointState(position_m=(-0.05 - params.margin_m, 0.0, 0.0))
    fx, _, _ = force(at_boundary, (0.93, 0.0, 0.0), [item], params)
    assert fx < 0.0


def test_force_begins_at_the_margin() -> None:
    params = FieldParams(margin_m=0.02)
    item = ball((0.0, 0.0, 0.0), 0.05)
    assert repulsion((0.0701, 0.0, 0.0), item, params) == (0.0, 0.0, 0.0)
    fx, fy, fz = repulsion((0.0699, 0.0, 0.0), item, params)
    assert fx == pytest.approx(params.gain_n / math.e, rel=0.01)
    assert (fy, fz) == (0.0, 0.0)


def test_turned_ellipsoid_acts_along_its_own_axes() -> None:
    R = rotation.matrix((0.0, 0.0, math.pi / 2)).tolist()
    turned = Ellipsoid(
        centre_m=(0.0, 0.0, 0.0),
        semi_axes_m=(0.1, 0.02, 0.02),
        rotation=(tuple(R[0]), tuple(R[1]), tuple(R[2])),
    )
    params = FieldParams(margin_m=0.0)
    assert repulsion((0.05, 0.0, 0.0), turned, params) == (0.0, 0.0, 0.0)
    assert repulsion((0.0, 0.05, 0.0), turned, params)[1] > 0.0


def test_centre_of_an_obstacle_has_no_direction_and_no_force() -> None:
    item = ball((0.1, 0.2, 0.3), 0.05)
    assert repulsion((0.1, 0.2, 0.3), item, FieldParams()) == (0.0, 0.0, 0.0)


@pytest.mark.parametrize("bad", [math.nan, math.inf, -math.inf])
def test_what_is_not_finite_is_refused(bad: float) -> None:
    state = PointState(position_m=START)
    item = ball((0.1, 0.0, 0.0), 0.05)
    with pytest.raises(NotFiniteError):
        step(replace(state, velocity_m_s=(0.0, bad, 0.0)), GOAL, [item], FieldParams(), PERIOD_S)
    with pytest.raises(NotFiniteError):
        step(state, (0.0, 0.0, bad), [item], FieldParams(), PERIOD_S)
    with pytest.raises(NotFiniteError):
        step(state, GOAL, [ball((bad, 0.0, 0.0), 0.05)], FieldParams(), PERIOD_S)
    with pytest.raises(NotFiniteError):
        step(state, GOAL, [ball((0.0, 0.0, 0.0), bad)], FieldParams(), PERIOD_S)
    with pytest.raises(NotFiniteError):
        step(state, GOAL, [item], FieldParams(), bad)


def test_obstacle_without_volume_and_negative_constants_are_refused() -> None:
    state = PointState(position_m=START)
    with pytest.raises(FieldError):
        step(state, GOAL, [ball((0.1, 0.0, 0.0), 0.0)], FieldParams(), PERIOD_S)
    with pytest.raises(FieldError):
        step(state, GOAL, [], FieldParams(), 0.0)
    with pytest.raises(FieldError):
        FieldParams(margin_m=-0.01)
    with pytest.raises(FieldError):
        FieldParams(gain_n=math.nan)
