"""PMP's virtual arm: Table I in both variants, what Gamma leaves, limits, orientation, refusals."""

import math
from dataclasses import replace

import numpy as np
import pytest

from dforc import rotation
from dforc.arrays import Vector
from dforc.errors import NotFiniteError, ShapeError
from dforc.field.force import FieldParams, ball, scene_of
from dforc.pmp.kernel_motion import LOGARITHM, RAW, Pull, add_turn
from dforc.pmp.motion import Pmp, PmpState, PmpTarget
from dforc.pmp.params import Orientation, PmpError, PmpParams, Variant
from dforc.robot_model import RobotModel

DT_S = 0.01


def pmp_of(model: RobotModel, params: PmpParams | None = None) -> Pmp:
    return Pmp(model, model.lower_rad, model.upper_rad, params or PmpParams())


def near(model: RobotModel, home: Vector, turn_rad: float) -> PmpTarget:
    """The pose of a posture a little beside home."""
    q = home.copy()
    q[3:7] += turn_rad
    R, p = model.tip_pose(q)
    return PmpTarget(position_m=p, rotation=R)


def away_m(state: PmpState, target: PmpTarget) -> float:
    return float(np.linalg.norm(state.position_m - target.position_m))


def finish(pmp: Pmp, q: Vector, target: PmpTarget, seconds: float, dt_s: float = DT_S) -> PmpState:
    state = pmp.begin(q)
    for _ in range(round(seconds / dt_s)):
        state = pmp.step(state, target, dt_s=dt_s)
    return state


def test_one_step_is_table_i_with_the_field_at_the_limits(model: RobotModel, home: Vector) -> None:
    admittance = tuple(np.linspace(0.1, 1.0, 10).tolist())
    pmp = pmp_of(
        model, PmpParams(has_time_base=False, admittance_rad_nms=admittance, limit_gain_nm=0.05)
    )
    target = near(model, home, 0.2)
    state = pmp.step(pmp.begin(home), target)
    J = model.tip_jacobian(home)[:3]
    place = 2.0 * (home - model.lower_rad) / (model.upper_rad - model.lower_rad) - 1.0
    place = np.clip(place, -0.9999, 0.9999)
    torque = J.T @ (4.0 * (target.position_m - model.tip_pose(home)[1]))
    torque += 0.05 * np.log((1.0 - place) / (1.0 + place))
    assert state.dq_rad_s == pytest.approx(np.array(admittance) * torque, abs=1e-12)
    assert state.q_rad == pytest.approx(home + DT_S * np.array(admittance) * torque, abs=1e-12)
    assert state.time_s == DT_S


def test_gamma_leaves_the_eigenvalue_s_power_of_epsilon_of_a_small_error(
    model: RobotModel, home: Vector
) -> None:
    """(eps / (1 + eps))^l along each eigenvector of K J A J', the Jacobian being all but frozen."""
    admittance = np.linspace(0.6, 1.0, 10)
    pmp = pmp_of(model, PmpParams(limit_gain_nm=0.0, admittance_rad_nms=tuple(admittance.tolist())))
    J = model.tip_jacobian(home)[:3]
    eigenvalues, basis = np.linalg.eigh(4.0 * J * admittance @ J.T)
    assert eigenvalues[0] < 0.15
    assert eigenvalues[2] > 0.7
    start = model.tip_pose(home)[1]
    error = basis @ np.full(3, 1e-7)
    # 6000 steps: with the papers' 300 the error of Euler itself is 18 % where l = 1.
    state = finish(pmp, home, PmpTarget(position_m=start + error), 3.0, dt_s=3.0 / 6000)
    left = (basis.T @ (start + error - state.position_m)) / 1e-7
    assert left == pytest.approx((1e-3 / 1.001) ** eigenvalues, rel=0.02)


def test_variants_differ_by_a_drift_that_is_first_order_in_the_period(
    model: RobotModel, home: Vector
) -> None:
    target = near(model, home, 0.5)
    drifts = []
    for dt_s in (0.02, 0.01, 0.005):
        state = finish(
            pmp_of(model, PmpParams(variant=Variant.A, limit_gain_nm=0.0)), home, target, 3.0, dt_s
        )
        drifts.append(float(np.linalg.norm(state.position_m - model.tip_pose(state.q_rad)[1])))
    assert 1e-5 < drifts[1] < 1.5e-3
    assert drifts[0] / drifts[1] == pytest.approx(2.0, rel=0.1)
    assert drifts[1] / drifts[2] == pytest.approx(2.0, rel=0.1)


def test_variant_b_is_where_its_arm_is(model: RobotModel, home: Vector) -> None:
    state = finish(pmp_of(model, PmpParams(limit_gain_nm=0.0)), home, near(model, home, 0.5), 3.0)
    R, p = model.tip_pose(state.q_rad)
    assert state.position_m == pytest.approx(p, abs=1e-12)
    assert state.rotation == pytest.approx(R, abs=1e-12)


def test_joint_limits_hold_where_they_clamp_and_only_there(model: RobotModel, home: Vector) -> None:
    beyond = PmpTarget(position_m=model.tip_pose(home)[1] + np.array([-0.6, -0.5, 0.4]))
    free = PmpParams(limit_gain_nm=0.0, has_time_base=False, clamped=False)
    clamped = finish(pmp_of(model, replace(free, clamped=True)), home, beyond, 10.0)
    loose = finish(pmp_of(model, free), home, beyond, 10.0)
    assert (clamped.q_rad >= model.lower_rad).all()
    assert (clamped.q_rad <= model.upper_rad).all()
    assert ((loose.q_rad < model.lower_rad) | (loose.q_rad > model.upper_rad)).any()


def test_field_at_the_limits_moves_an_arm_that_is_at_its_target(
    model: RobotModel, home: Vector
) -> None:
    R, p = model.tip_pose(home)
    target = PmpTarget(position_m=p, rotation=R)
    assert (
        away_m(finish(pmp_of(model, PmpParams(limit_gain_nm=0.0)), home, target, 3.0), target)
        < 1e-12
    )
    assert away_m(finish(pmp_of(model), home, target, 3.0), target) > 0.01


def test_orientation_by_the_logarithm_turns_the_hand_onto_the_target(
    model: RobotModel, home: Vector
) -> None:
    target = near(model, home, 0.2)
    assert target.rotation is not None
    start = rotation.angle_between(model.tip_pose(home)[0], target.rotation)
    pmp = pmp_of(
        model, PmpParams(orientation=Orientation.LOG, has_time_base=False, limit_gain_nm=0.0)
    )
    state = finish(pmp, home, target, 20.0)
    assert rotation.angle_between(state.rotation, target.rotation) < 0.2 * start


@pytest.mark.parametrize(
    ("turned", "torque_nm"), [(LOGARITHM, 4.0 * 0.4), (RAW, -4.0 * (2.0 * math.pi - 0.4))]
)
def test_raw_difference_across_half_a_turn_goes_nearly_all_the_way_round(
    turned: int, torque_nm: float
) -> None:
    here, there = (rotation.matrix((0.0, 0.0, math.pi + turn)) for turn in (-0.2, 0.2))
    torque = np.zeros(3)
    add_turn(here, Pull(np.zeros(3), there, turned), 4.0, torque)
    assert torque == pytest.approx([0.0, 0.0, torque_nm], abs=1e-9)


def test_variant_a_turns_its_hand_with_its_arm(model: RobotModel, home: Vector) -> None:
    target, q = near(model, home, 0.5), home.copy()
    state = finish(
        pmp_of(model, PmpParams(variant=Variant.A, limit_gain_nm=0.0)), q, target, 3.0, 1e-3
    )
    assert rotation.angle_between(state.rotation, model.tip_pose(state.q_rad)[0]) < 1e-3
    assert state.rotation.T @ state.rotation == pytest.approx(np.eye(3), abs=1e-12)


def test_obstacle_pushes_the_hand_as_in_the_force_field(model: RobotModel, home: Vector) -> None:
    pmp = pmp_of(model, PmpParams(has_time_base=False, limit_gain_nm=0.0))
    R, p = model.tip_pose(home)
    centre = (float(p[0]) - 0.01, float(p[1]), float(p[2]))
    scene = scene_of((), (ball(centre, 0.02),), FieldParams(gain_n=8.0))
    state = pmp.step(pmp.begin(home), PmpTarget(position_m=p, rotation=R), scene)
    pushed = model.tip_jacobian(home)[:3].T @ np.array([8.0 * math.exp(-0.25), 0.0, 0.0])
    assert state.dq_rad_s == pytest.approx(pushed, abs=1e-9)


def test_time_base_ends_the_motion_and_a_new_start_goes_on(model: RobotModel, home: Vector) -> None:
    target, pmp = near(model, home, 0.4), pmp_of(model, PmpParams(limit_gain_nm=0.0))
    ended = finish(pmp, home, target, 3.0)
    assert pmp.step(ended, target).q_rad == pytest.approx(ended.q_rad, abs=0.0)
    state = pmp.again(ended)
    for _ in range(300):
        state = pmp.step(state, target)
    assert away_m(state, target) < away_m(ended, target)


def test_roll_out_is_step_after_step(model: RobotModel, home: Vector) -> None:
    pmp, target = pmp_of(model, PmpParams(variant=Variant.A)), near(model, home, 0.3)
    path = pmp.roll_out(pmp.begin(home), target, steps=50)
    state = pmp.begin(home)
    for k in range(51):
        assert (path.q_rad[k] == state.q_rad).all()
        assert (path.positions_m[k] == state.position_m).all()
        assert (path.rotations[k] == state.rotation).all()
        state = pmp.step(state, target)


@pytest.mark.parametrize("bad", [math.nan, math.inf])
def test_what_is_not_finite_is_refused(model: RobotModel, home: Vector, bad: float) -> None:
    pmp = pmp_of(model)
    with pytest.raises(NotFiniteError):
        pmp.begin([bad, *home[1:]])
    with pytest.raises(NotFiniteError):
        pmp.step(pmp.begin(home), PmpTarget(position_m=np.array([0.0, bad, 0.0])))
    with pytest.raises(NotFiniteError):
        pmp.step(pmp.begin(home), near(model, home, 0.1), dt_s=bad)


def test_constants_and_limits_that_do_not_fit_are_refused(model: RobotModel) -> None:
    with pytest.raises(PmpError, match="duration"):
        PmpParams(duration_s=0.0)
    with pytest.raises(PmpError, match="admittance"):
        PmpParams(admittance_rad_nms=-1.0)
    with pytest.raises(PmpError, match="limit gain has 2 values for 10"):
        pmp_of(model, PmpParams(limit_gain_nm=(0.1, 0.1)))
    upper = model.upper_rad.copy()
    upper[3] = model.lower_rad[3]
    with pytest.raises(PmpError, match="joint 3"):
        Pmp(model, model.lower_rad, upper, PmpParams())
    with pytest.raises(ShapeError):
        Pmp(model, model.lower_rad[:3], model.upper_rad, PmpParams())
