"""What each sub-model can know: ranks, residuals, least norm, lost sensors."""

from collections.abc import Callable

import numpy as np
import pytest

from benchmarks.dynamics_scenes import FEET, LIMBS, SOURCE, Robot, Scene, scene
from benchmarks.newton_euler import Array
from dforc.estimation.assumption import (
    Assumption,
    Contact,
    KnownWrench,
    crawling,
    standing,
)
from dforc.estimation.estimate import BodyEstimate
from dforc.estimation.estimator import MOST_PLANS, WholeBodyEstimator

Make = Callable[[Assumption], WholeBodyEstimator]
Load = Callable[[str, tuple[str, ...]], Robot]
L_ARM, R_ARM, L_LEG, R_LEG, L_FOOT = range(5)
HAND, ELBOW, FOOT = Contact(frame="l_hand"), Contact(frame="l_forearm"), Contact(frame="l_foot")
PUSH_AT_ELBOW = Contact(frame="l_forearm", point_m=(0.02, 0.0, 0.05), kind="force")


def scene_of(robot: Robot, *contacts: Contact, seed: int = 1) -> Scene:
    return scene(np.random.default_rng(seed), robot, Assumption(contacts=contacts))


def run(estimator: WholeBodyEstimator, true: Scene, valid: Array | None = None) -> BodyEstimate:
    mask = None if valid is None else valid.astype(bool)
    return estimator.estimate(true.q, true.dq, true.ddq, true.readings, mask)


def of_joints(robot: Robot, name: str) -> list[int]:
    return [i for i, joint in enumerate(robot.tree.joints) if joint.startswith(name)]


# Where idyntree is silently wrong.


def test_known_wrench_away_from_the_links_origin_is_exact(icub: Robot, make: Make) -> None:
    load = KnownWrench(frame="r_hand", point_m=(0.137, 0.02, 0.05), wrench=(3, -8, 5, 0.1, 0, 1))
    assumption = Assumption(contacts=(HAND,), known=(load,))
    true = scene(np.random.default_rng(2), icub, assumption)
    found = run(make(assumption), true)
    assert found.tau_nm == pytest.approx(true.tau, abs=1e-9)
    assert max(sub.residual_n for sub in found.sub_models) < 1e-9


def test_force_in_a_sub_model_without_unknowns_is_a_residual_and_no_torque_error_behind_the_sensor(
    icub: Robot, make: Make
) -> None:
    true = scene_of(icub, HAND)
    found = run(make(Assumption()), true)
    arm = found.sub_models[1 + L_ARM]
    assert (arm.unknowns, arm.rank, arm.sensors) == (0, 0, ("l_arm_ft",))
    assert np.linalg.norm(arm.residual[:3]) == pytest.approx(
        np.linalg.norm(true.wrenches[0, :3]), abs=1e-9
    )
    beyond = of_joints(icub, "l_elbow") + of_joints(icub, "l_wrist")
    near = [i for i in range(icub.tree.n) if i not in beyond]
    assert found.tau_nm[near] == pytest.approx(true.tau[near], abs=1e-9)
    assert np.abs(found.tau_nm[beyond] - true.tau[beyond]).max() > 0.1


def test_contact_found_by_skin_puts_the_default_contact_out_of_the_sub_model(
    icub: Robot, make: Make
) -> None:
    true = scene_of(icub, PUSH_AT_ELBOW)
    default = Contact(frame="l_hand", fallback=True)
    found = run(make(Assumption(contacts=(default, PUSH_AT_ELBOW))), true)
    assert found.contact_wrenches[0] == pytest.approx(0.0, abs=0.0)
    assert found.contact_wrenches[1] == pytest.approx(true.wrenches[0], abs=1e-9)
    assert found.tau_nm == pytest.approx(true.tau, abs=1e-9)


def test_default_contacts_of_other_sub_models_stay(icub: Robot, make: Make) -> None:
    true = scene_of(icub, PUSH_AT_ELBOW, FOOT)
    defaults = tuple(
        Contact(frame=frame, fallback=True) for frame in ("l_hand", "l_foot", "l_lower_leg")
    )
    found = run(make(Assumption(contacts=(*defaults, PUSH_AT_ELBOW))), true)
    assert found.contact_wrenches[1] == pytest.approx(true.wrenches[1], abs=1e-9)
    assert found.contact_wrenches[2] == pytest.approx(0.0, abs=0.0)
    assert [sub.unknowns for sub in found.sub_models] == [6, 3, 0, 6, 0]


def test_default_contact_does_not_count_where_the_mainstay_holds(icub: Robot, make: Make) -> None:
    found = run(
        make(Assumption(contacts=(Contact(frame="root_link", fallback=True),))), scene_of(icub)
    )
    assert found.sub_models[0].unknowns == 6
    assert found.contact_wrenches == pytest.approx(0.0, abs=0.0)


def test_points_too_close_to_tell_apart_count_as_one(icub: Robot, make: Make) -> None:
    """A micrometre apart: what tells them apart is 1e-5 of what they share."""
    near = Contact(frame="l_forearm", point_m=(0.020001, 0.0, 0.05), kind="force")
    true = scene_of(icub, PUSH_AT_ELBOW)
    found = run(make(Assumption(contacts=(PUSH_AT_ELBOW, near))), true)
    assert found.sub_models[1 + L_ARM].rank == 3
    for wrench in found.contact_wrenches:
        assert wrench == pytest.approx(true.wrenches[0] / 2.0, abs=1e-3)


def test_copies_of_a_contact_share_its_wrench_evenly(icub: Robot, make: Make) -> None:
    true = scene_of(icub, HAND)
    found = run(make(Assumption(contacts=(HAND, HAND, HAND))), true)
    for wrench in found.contact_wrenches:
        assert wrench == pytest.approx(true.wrenches[0] / 3.0, abs=1e-9)
    arm = found.sub_models[1 + L_ARM]
    assert (arm.unknowns, arm.rank) == (18, 6)


def test_redundant_contacts_come_out_with_the_least_norm(icub: Robot, make: Make) -> None:
    """No other pair of wrenches with the same sum is smaller; 0.1 Nm counts as 1 N."""
    true = scene_of(icub, HAND)
    found = run(make(Assumption(contacts=(HAND, ELBOW))), true)
    a, b = found.contact_wrenches
    lever = found.contact_points_m[0] - found.contact_points_m[1]
    weight = np.array([1.0, 1.0, 1.0, 10.0, 10.0, 10.0])
    for other in np.random.default_rng(3).normal(size=(6, 6)):
        moved = np.concatenate([other[:3], other[3:] + np.cross(lever, other[:3])])
        steepness = (a * weight) @ (other * weight) - (b * weight) @ (moved * weight)
        assert abs(steepness) < 1e-9
    assert found.tau_nm[of_joints(icub, "l_shoulder")] == pytest.approx(
        true.tau[of_joints(icub, "l_shoulder")], abs=1e-9
    )


# Least squares.


def test_moment_at_a_contact_that_can_only_push_is_the_residual(icub: Robot, make: Make) -> None:
    true = scene_of(icub, HAND)
    found = run(make(Assumption(contacts=(Contact(frame="l_hand", kind="force"),))), true)
    arm = found.sub_models[1 + L_ARM]
    assert found.contact_wrenches[0, :3] == pytest.approx(true.wrenches[0, :3], abs=1e-9)
    assert arm.residual == pytest.approx([0, 0, 0, *true.wrenches[0, 3:]], abs=1e-9)
    assert (arm.unknowns, arm.rank) == (3, 3)


def test_two_pushes_cannot_be_told_apart_along_the_line_between_them(
    icub: Robot, make: Make
) -> None:
    hand = Contact(frame="l_hand", kind="force")
    arm = run(make(Assumption(contacts=(hand, PUSH_AT_ELBOW))), scene_of(icub, hand)).sub_models[1]
    assert (arm.unknowns, arm.rank) == (6, 5)
    assert arm.residual_n < 1e-9


def test_force_where_nothing_is_expected_shows_within_one_tick(icub: Robot, make: Make) -> None:
    calm, pushed = scene_of(icub), scene_of(icub, PUSH_AT_ELBOW)
    estimator = make(Assumption(contacts=(FOOT,)))
    before = run(estimator, calm).sub_models[1 + L_ARM].residual_n
    after = run(estimator, pushed).sub_models[1 + L_ARM].residual_n
    assert before < 1e-9
    assert after >= np.linalg.norm(pushed.wrenches[0, :3]) - 1e-9


# Sensors that are lost.


def test_lost_sensor_merges_its_sub_model_with_the_neighbours(icub: Robot, make: Make) -> None:
    true = scene_of(icub, FOOT)
    true.readings[L_ARM] = np.nan
    estimator = make(standing())
    found = run(estimator, true, np.array([0, 1, 1, 1]))
    assert len(found.sub_models) == 4
    assert "l_hand" in found.sub_models[0].links
    assert found.tau_nm == pytest.approx(true.tau, abs=1e-9)  # nothing touched the arm
    assert found.contact_wrenches[2] == pytest.approx(true.wrenches[0], abs=1e-9)
    assert found.contact_wrenches[0] == pytest.approx(0.0, abs=0.0)
    assert (found.sub_models[0].unknowns, found.sub_models[0].rank) == (12, 6)


def test_robot_without_mainstay_finds_the_contact_of_a_leg_whose_sensor_is_lost(
    icub: Robot, compiled: bool
) -> None:
    feet = Assumption(contacts=(FOOT, Contact(frame="r_foot")), source=SOURCE, mainstay=False)
    estimator = WholeBodyEstimator(icub.tree, feet, compiled=compiled)
    true = scene(np.random.default_rng(4), icub, feet)
    valid = np.array([True, True, False, True])
    found = estimator.estimate(true.q, true.dq, true.ddq, true.readings, valid, true.imu)
    assert found.contact_wrenches == pytest.approx(true.wrenches, abs=1e-9)
    assert found.tau_nm == pytest.approx(true.tau, abs=1e-9)


def test_lost_sensor_in_a_foot_leaves_the_foot_to_the_sensor_of_its_leg(
    load: Load, compiled: bool
) -> None:
    made = load("iCubGenova03", (*LIMBS, *FEET))
    sole = Assumption(contacts=(Contact(frame="l_sole"),))
    estimator = WholeBodyEstimator(made.tree, sole, compiled=compiled)
    true = scene(np.random.default_rng(7), made, sole)
    true.readings[L_FOOT] = np.nan
    found = run(estimator, true, np.array([1, 1, 1, 1, 0, 1]))
    assert found.contact_wrenches == pytest.approx(true.wrenches, abs=1e-9)
    assert found.tau_nm == pytest.approx(true.tau, abs=1e-9)
    assert found.sub_models[1 + L_LEG].sensors == ("l_leg_ft",)
    assert {"l_sole", "l_lower_leg"} < set(found.sub_models[1 + L_LEG].links)


def test_hundreds_of_assumptions_in_a_row_stay_exact(icub: Robot, make: Make) -> None:
    """Skin moves its contacts all the time; what is remembered of old ones is bounded."""
    estimator = make(standing())
    true = scene_of(icub, PUSH_AT_ELBOW)
    for step in range(200):
        elsewhere = Contact(frame="r_forearm", kind="force", point_m=(0.0, 0.0, 1e-3 * step))
        estimator.assume(Assumption(contacts=(PUSH_AT_ELBOW, elsewhere)))
    assert len(estimator._plans) <= MOST_PLANS
    found = run(estimator, true)
    assert found.contact_wrenches[0] == pytest.approx(true.wrenches[0], abs=1e-9)
    assert found.contact_wrenches[1] == pytest.approx(0.0, abs=1e-9)


def test_sensor_that_comes_back_counts_at_once(icub: Robot, make: Make) -> None:
    true = scene_of(icub, HAND, FOOT)
    estimator = make(standing())
    first = run(estimator, true).numbers.copy()
    run(estimator, true, np.array([0, 1, 0, 1]))
    assert np.array_equal(run(estimator, true).numbers, first)


def test_fault_in_one_limb_leaves_the_others_bit_identical(icub: Robot, make: Make) -> None:
    true = scene_of(icub, HAND, FOOT)
    estimator = make(standing())
    whole = run(estimator, true)
    true.readings[L_ARM] = 1e6
    saturated = run(estimator, true)
    lost = run(estimator, true, np.array([0, 1, 1, 1]))
    other = of_joints(icub, "r_") + of_joints(icub, "l_hip") + of_joints(icub, "l_knee")
    for spoiled in (saturated, lost):
        assert np.array_equal(spoiled.tau_nm[other], whole.tau_nm[other])
        assert np.array_equal(spoiled.contact_wrenches[1:], whole.contact_wrenches[1:])


# The paper's sets.


def test_standing_robot_is_held_by_the_mainstay_and_touched_at_hands_and_feet(
    icub: Robot, make: Make
) -> None:
    assumption = standing()
    true = scene(np.random.default_rng(5), icub, assumption)
    found = run(make(assumption), true)
    assert found.contact_wrenches == pytest.approx(true.wrenches, abs=1e-9)
    assert found.base_wrench == pytest.approx(true.base, abs=1e-9)
    assert [sub.unknowns for sub in found.sub_models] == [6] * 5


def test_crawling_robot_is_carried_by_wrists_and_knees(icub: Robot, compiled: bool) -> None:
    assumption = crawling()
    estimator = WholeBodyEstimator(icub.tree, assumption, compiled=compiled)
    true = scene(np.random.default_rng(6), icub, assumption)
    found = estimator.estimate(true.q, true.dq, true.ddq, true.readings, None, true.imu)
    assert found.contact_wrenches == pytest.approx(true.wrenches, abs=1e-9)
    assert found.tau_nm == pytest.approx(true.tau, abs=1e-9)
    assert found.base_wrench == pytest.approx(0.0, abs=0.0)
    assert [sub.unknowns for sub in found.sub_models] == [0, 6, 6, 6, 6]
    assert found.sub_models[0].residual_n < 1e-9
