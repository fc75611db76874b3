"""The body: where it is, how near it is to obstacles and itself, how that changes."""

from dataclasses import replace

import numpy as np
import pytest

from dforc.collision.body import Body, BodyError
from dforc.collision.kernel_body import clearance, place_body, tip_jacobian, tip_pose
from dforc.collision.kernel_nearness import normal_between
from dforc.collision.kernel_segments import segments_apart
from dforc.collision.obstacles import World, sphere, world_of
from dforc.robot_model import ModelError, RobotModel
from tests.dforc.collision.bodies import (
    CAPSULES,
    JOINTS,
    LEFT,
    NEIGHBOURS,
    RIGHT,
    TIPS,
    TORSO,
    URDF,
    Room,
    along,
    hanging,
    make_body,
    random_obstacles,
    random_postures,
)

NO_WORLD = world_of([])
NEVER = -np.inf


@pytest.fixture(scope="module")
def body() -> Body:
    return make_body()


@pytest.fixture(scope="module")
def world() -> World:
    return world_of(
        [
            replace(one, velocity_m_s=(0.1, -0.2, 0.3), margin_m=0.01)
            for one in random_obstacles(8, seed=3)
        ]
    )


def least(room: Room, q: np.ndarray, world: World, stop_below: float = NEVER) -> float:
    return clearance(
        q, room.body.arrays, world, room.mask, room.frames, room.segments, 0.02, 0.03, stop_below
    )


@pytest.mark.parametrize("tip", [0, 1])
def test_tips_are_where_the_model_has_them(body: Body, tip: int) -> None:
    model = RobotModel(URDF, JOINTS, TIPS[tip], {})
    room = Room(body)
    R, p, J = np.zeros(9), np.zeros(3), np.zeros((6, len(JOINTS)))
    for q in random_postures(20, seed=1):
        place_body(q, body.arrays, room.frames, room.segments)
        tip_pose(body.arrays, tip, room.frames, R, p)
        tip_jacobian(body.arrays, tip, room.frames, J)
        expected_R, expected_p = model.tip_pose(q)
        assert np.abs(R.reshape(3, 3) - expected_R).max() < 1e-14
        assert np.abs(p - expected_p).max() < 1e-14
        assert np.abs(J - model.tip_jacobian(q)).max() < 1e-14


@pytest.mark.parametrize("number", range(len(CAPSULES)))
def test_capsules_move_with_their_links(body: Body, number: int) -> None:
    model = RobotModel(URDF, JOINTS, CAPSULES[number].link, {})
    room = Room(body)
    for q in random_postures(5, seed=2):
        place_body(q, body.arrays, room.frames, room.segments)
        R, p = model.tip_pose(q)
        ends = [
            R @ np.array(point) + p for point in (CAPSULES[number].start_m, CAPSULES[number].end_m)
        ]
        assert np.abs(room.segments[number] - np.concatenate(ends)).max() < 1e-14


def test_clearance_is_the_smallest_of_all_distances_one_by_one(body: Body, world: World) -> None:
    room, arrays = Room(body), body.arrays
    for q in random_postures(40, seed=4):
        found = least(room, q, world)
        apart = [
            segments_apart(*room.segments[[i, j]].ravel().tolist())[0]
            - arrays.radii[i]
            - arrays.radii[j]
            - 0.03
            for i, j in arrays.pairs
        ]
        for i in np.flatnonzero(room.mask):
            for o in range(len(world.kinds)):
                R = world.rotations[o].reshape(3, 3)
                a, b = (room.segments[i].reshape(2, 3) - world.centres[o]) @ R
                far = along(int(world.kinds[o]), world.sizes[o], a, b)[0]
                apart.append(far - arrays.radii[i] - world.margins[o] - 0.02)
        assert found == pytest.approx(min(apart), abs=1e-12)


def test_clearance_returns_early_only_with_less_than_was_asked_for(
    body: Body, world: World
) -> None:
    room = Room(body)
    for q in random_postures(40, seed=5):
        exact, early = least(room, q, world), least(room, q, world, stop_below=0.0)
        assert (early < 0.0) == (exact < 0.0)
        assert early >= exact
        assert exact < 0.0 or early == exact


def test_what_the_mask_leaves_out_may_be_in_an_obstacle(body: Body) -> None:
    room, q = Room(body), hanging()
    room.mask = body.moved_by(LEFT)
    place_body(q, body.arrays, room.frames, room.segments)
    r_hand = room.segments[body.capsules.index("r_hand"), :3].tolist()
    world = world_of([sphere("held", (r_hand[0], r_hand[1], r_hand[2]), 0.01)])
    assert least(room, q, world) > -0.03
    assert least(Room(body), q, world) < -0.05


def test_with_nothing_around_only_the_body_counts(body: Body) -> None:
    alone = replace(body, arrays=body.arrays._replace(pairs=np.zeros((0, 2), dtype=np.int64)))
    assert least(Room(alone), random_postures(1, seed=6)[0], NO_WORLD) == np.inf
    assert Room(alone).near(random_postures(1, seed=6)[0], NO_WORLD) == {}


def test_proximities_agree_with_clearance(body: Body, world: World) -> None:
    room = Room(body, rows=200)
    for q in random_postures(20, seed=7):
        near = room.near(q, world)
        assert len(near) == len(body.arrays.pairs) + room.mask.sum() * len(world.kinds)
        rest = [far - (0.02 if other >= 0 else 0.03) for (_, other), (far, _, _) in near.items()]
        assert min(rest) == pytest.approx(least(room, q, world), abs=1e-12)


def test_gradients_are_the_finite_differences_of_the_distances(body: Body, world: World) -> None:
    room, h = Room(body, rows=200), 1e-6
    for q in random_postures(4, seed=8):
        near = room.near(q, world)
        for joint in range(len(JOINTS)):
            ahead, behind = q.copy(), q.copy()
            ahead[joint] += h
            behind[joint] -= h
            after, before = room.near(ahead, world), room.near(behind, world)
            for key, (_, gradient, _) in near.items():
                slope = (after[key][0] - before[key][0]) / (2.0 * h)
                assert slope == pytest.approx(gradient[joint], abs=2e-6)


def test_drifts_are_the_rates_at_which_obstacles_come_nearer(body: Body, world: World) -> None:
    room, h = Room(body, rows=200), 1e-6
    q = random_postures(1, seed=9)[0]
    near = room.near(q, world)
    later = room.near(q, world._replace(centres=world.centres + h * world.velocities))
    for key, (far, _, drift) in near.items():
        assert (later[key][0] - far) / h == pytest.approx(drift, abs=1e-5)
    assert all(drift == 0.0 for (_, other), (_, _, drift) in near.items() if other < 0)


def test_only_what_is_in_reach_is_reported(body: Body, world: World) -> None:
    room = Room(body, rows=200)
    q = random_postures(1, seed=10)[0]
    everything = room.near(q, world)
    some = room.near(q, world, reach_m=0.2, self_reach_m=0.1)
    assert set(some) == {
        key for key, (far, _, _) in everything.items() if far < (0.2 if key[1] >= 0 else 0.1)
    }
    assert all(some[key][0] == pytest.approx(everything[key][0], abs=1e-12) for key in some)


def test_of_more_than_there_are_rows_the_nearest_are_kept(body: Body, world: World) -> None:
    everything, few = Room(body, rows=200), Room(body, rows=7)
    for q in random_postures(10, seed=11):
        all_of_them = sorted(everything.near(q, world).items(), key=lambda one: one[1][0])
        kept = few.near(q, world)
        assert set(kept) == {key for key, _ in all_of_them[:7]}
        for key, (far, gradient, drift) in all_of_them[:7]:
            assert kept[key][0] == far
            assert kept[key][1].tolist() == gradient.tolist()
            assert kept[key][2] == drift


def test_axes_that_cross_are_pushed_apart_across_both() -> None:
    crossing = np.array([[-1.0, 0.0, 0.0, 1.0, 0.0, 0.0], [0.0, -1.0, 0.0, 0.0, 1.0, 0.0]])
    assert normal_between(0.0, 0.0, 0.0, 0.0, crossing, 0, 1) == (0.0, 0.0, 1.0)
    along_each_other = crossing[[0, 0]]
    assert np.linalg.norm(normal_between(0.0, 0.0, 0.0, 0.0, along_each_other, 0, 1)) == 1.0


def test_pairs_are_all_that_joints_move_but_the_neighbours(body: Body) -> None:
    names = {frozenset((body.capsules[i], body.capsules[j])) for i, j in body.arrays.pairs}
    assert len(names) == 8 * 7 // 2 - len(NEIGHBOURS)
    assert frozenset(("l_hand", "r_hand")) in names
    assert not names & {frozenset(pair) for pair in NEIGHBOURS}
    arms = body.keeping(body.moved_by(LEFT))
    assert all(any(body.capsules[k].startswith("l_") for k in pair) for pair in arms.arrays.pairs)
    assert len(arms.arrays.pairs) == 3 * 5 + 3 - 3


def test_the_torso_moves_all_but_the_root(body: Body) -> None:
    assert body.moved_by(TORSO).tolist() == [False] + [True] * 7
    assert body.moved_by(RIGHT).tolist() == [False] * 5 + [True] * 3
    assert body.moved_by(["r_elbow"]).tolist() == [False] * 6 + [True] * 2
    assert not body.moved_by([]).any()


def test_columns_are_places_in_the_bodys_vector(body: Body) -> None:
    assert body.columns((*TORSO, *RIGHT)).tolist() == [0, 1, 2, *range(10, 17)]
    with pytest.raises(BodyError, match="no joint 'tail'"):
        body.columns(["tail"])


def test_joints_in_the_wrong_order_and_unknown_names_are_refused() -> None:
    with pytest.raises(BodyError, match="stands before"):
        Body.make(URDF, (*RIGHT, *TORSO), CAPSULES, TIPS, NEIGHBOURS)
    with pytest.raises(BodyError, match="no capsule 'tail'"):
        Body.make(URDF, JOINTS, CAPSULES, TIPS, [("chest", "tail")])
    with pytest.raises(BodyError, match="two capsules of one name"):
        Body.make(URDF, JOINTS, (*CAPSULES, CAPSULES[0]), TIPS)
    with pytest.raises(ModelError, match="no frame 'tail'"):
        Body.make(URDF, JOINTS, [replace(CAPSULES[0], link="tail")], TIPS)
    with pytest.raises(BodyError, match="radius_m"):
        Body.make(URDF, JOINTS, [replace(CAPSULES[0], radius_m=0.0)], TIPS)
