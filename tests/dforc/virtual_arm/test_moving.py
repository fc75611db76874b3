"""Bounds of how fast a limb moves its capsules."""

import numpy as np

from dforc.collision.body import Body
from dforc.collision.kernel_body import place_body
from dforc.virtual_arm.moving import moving_of


def test_a_lever_is_the_longest_way_from_the_joint_to_the_capsules_end(flat_body: Body) -> None:
    moving = moving_of(flat_body.arrays, np.arange(3))
    expected = [[0.2, 0.0, 0.0], [0.4, 0.2, 0.0], [0.6, 0.4, 0.2]]
    np.testing.assert_allclose(moving.levers, expected)
    np.testing.assert_allclose(moving.metric, [0.6, 0.4, 0.2])


def test_what_moves_both_capsules_of_a_pair_does_not_bring_them_together(flat_body: Body) -> None:
    moving = moving_of(flat_body.arrays, np.arange(3))
    np.testing.assert_allclose(moving.pair_levers, [[0.0, 0.4, 0.2]])


def test_a_limb_without_the_first_joint_leaves_out_what_it_does_not_move(flat_body: Body) -> None:
    moving = moving_of(flat_body.arrays, np.array([2]))
    np.testing.assert_array_equal(moving.capsules, [2])
    np.testing.assert_array_equal(moving.pairs, [[0, 2]])


def test_only_capsules_in_the_mask_count_against_obstacles(flat_body: Body) -> None:
    mask = np.array([True, False, True])
    np.testing.assert_array_equal(moving_of(flat_body.arrays, np.arange(3), mask).capsules, [0, 2])


def test_an_axis_across_the_joint_has_the_distance_from_the_joints_axis(flat_body: Body) -> None:
    upright = flat_body.arrays._replace(
        starts=np.tile([0.03, 0.04, -1.0], (3, 1)), ends=np.tile([0.03, 0.04, 1.0], (3, 1))
    )
    moving = moving_of(upright, np.arange(3))
    np.testing.assert_allclose(np.diag(moving.levers), 0.05)


def test_no_posture_moves_a_capsule_faster_than_its_levers_say(flat_body: Body) -> None:
    moving = moving_of(flat_body.arrays, np.arange(3))
    rng = np.random.default_rng(4)
    before, after, frames = np.zeros((3, 6)), np.zeros((3, 6)), np.zeros((3, 12))
    for _ in range(200):
        q, dq = rng.uniform(-3.0, 3.0, 3), rng.normal(size=3) * 0.1
        place_body(q, flat_body.arrays, frames, before)
        place_body(q + dq, flat_body.arrays, frames, after)
        moved = np.linalg.norm((after - before).reshape(3, 2, 3), axis=2).max(axis=1)
        assert (moved <= moving.levers @ np.abs(dq) + 1e-12).all()
