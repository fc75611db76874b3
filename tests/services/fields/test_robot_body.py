"""The body of a robot file: its joints, capsules, pairs, and that nothing touches at home."""

from dataclasses import replace
from pathlib import Path

import msgspec
import numpy as np
import pytest

from benchmarks.link_meshes import Mesh, load_meshes
from dforc.arrays import Matrix, Vector
from dforc.collision.body import Body
from dforc.collision.kernel_body import clearance, place_body
from dforc.collision.obstacles import World, world_of
from dforc.robot_model import RobotModel
from services.config import load_robot
from services.core.errors import ConfigError
from services.fields.robot_body import FILE, read_collision_file, robot_body
from services.robotfile.model_file import urdf_path
from services.robotfile.robot_tables import RobotFile

NOTHING = world_of([])
ARM_LINKS = ("upper_arm", "forearm", "hand")


@pytest.fixture(scope="module")
def robot() -> RobotFile:
    return load_robot("icub")


@pytest.fixture(scope="module")
def meshes() -> dict[str, Mesh]:
    return load_meshes(urdf_path("iCubLisboa01"))


@pytest.fixture(scope="module")
def body(robot: RobotFile) -> Body:
    return robot_body(robot)


def posture(robot: RobotFile, body: Body, key: str) -> Vector:
    """home_deg or rest_deg of every limb in use."""
    q = np.zeros(len(body.joints))
    for limb in robot.limbs.values():
        joints = [joint for part in limb.parts for joint in robot.parts[part]]
        values = limb.home_deg if key == "home" else limb.rest_deg
        q[body.columns(joints)] = np.radians(values)
    return q


def clear_m(body: Body, q: Vector, world: World = NOTHING) -> float:
    frames, segments = np.zeros((len(body.joints), 12)), np.zeros((len(body.capsules), 6))
    mask = body.moved_by(body.joints)
    return clearance(q, body.arrays, world, mask, frames, segments, 0.0, 0.0, -np.inf)


def pair_names(body: Body) -> set[frozenset[str]]:
    return {frozenset((body.capsules[i], body.capsules[j])) for i, j in body.arrays.pairs}


def allowed_postures(robot: RobotFile, body: Body, count: int) -> Matrix:
    """Evenly random within the limits and rows of the robot file."""
    low, high = np.radians([robot.joints[joint].limits_deg for joint in body.joints]).T
    rng = np.random.default_rng(1)
    found: list[Vector] = []
    while len(found) < count:
        q = rng.uniform(low, high)
        angle = dict(zip(body.joints, np.degrees(q), strict=True))
        sums = [
            (sum(k * angle[joint] for joint, k in row.coefficients.items()), row)
            for row in robot.rows
            if set(row.coefficients) <= set(body.joints)
        ]
        if all(row.lower_deg <= value <= row.upper_deg for value, row in sums):
            found.append(q)
    return np.array(found)


def test_the_whole_robot_moves_torso_and_both_arms(robot: RobotFile, body: Body) -> None:
    expected = (*robot.parts["torso"], *robot.parts["left_arm"], *robot.parts["right_arm"])
    assert body.joints == expected
    assert body.tips == ("l_hand_dh_frame", "r_hand_dh_frame")


def test_sixteen_capsules_hold_the_robot(body: Body) -> None:
    sides = [f"{s}_{n}" for n in ("shoulder", *ARM_LINKS, "thigh") for s in "lr"]
    assert set(body.capsules) == {
        "root",
        "pelvis_1",
        "pelvis_2",
        "chest",
        "head_1",
        "head_2",
        *sides,
    }
    moved = {
        name for name, yes in zip(body.capsules, body.moved_by(body.joints), strict=True) if yes
    }
    assert set(body.capsules) - moved == {"root", "l_thigh", "r_thigh"}


def test_hands_are_kept_from_everything_but_their_forearms(body: Body) -> None:
    names = pair_names(body)
    for side in "lr":
        partners = {next(iter(pair - {f"{side}_hand"})) for pair in names if f"{side}_hand" in pair}
        assert partners == set(body.capsules) - {f"{side}_hand", f"{side}_forearm"}


def test_no_pair_is_without_an_arm(body: Body) -> None:
    arms = {f"{side}_{link}" for side in "lr" for link in ARM_LINKS}
    assert all(pair & arms for pair in pair_names(body))
    assert len(body.arrays.pairs) == 67


@pytest.mark.parametrize("key", ["home", "rest"])
def test_at_home_and_at_rest_nothing_is_nearer_than_five_centimetres(
    robot: RobotFile, body: Body, key: str
) -> None:
    assert clear_m(body, posture(robot, body, key)) == pytest.approx(0.0547, abs=5e-4)


def test_few_allowed_postures_touch_and_no_pair_touches_at_most_of_them(
    robot: RobotFile, body: Body
) -> None:
    arrays = body.arrays
    touching = np.zeros(len(arrays.pairs))
    anything = 0
    postures = allowed_postures(robot, body, 400)
    for q in postures:
        anything += clear_m(body, q) < 0.0
        for k, pair in enumerate(arrays.pairs):
            alone = replace(body, arrays=arrays._replace(pairs=pair[None].copy()))
            touching[k] += clear_m(alone, q) < 0.0
    assert anything / len(postures) < 0.05
    assert touching.max() / len(postures) < 0.02


def test_pairs_that_are_left_out_touch_at_every_posture(robot: RobotFile, body: Body) -> None:
    file = read_collision_file(robot.path.with_name(FILE))
    assert file is not None
    index = body.capsules.index
    left_out = np.array([[index(one), index(other)] for one, other in file.always_near])
    assert len(left_out) == 8
    for q in allowed_postures(robot, body, 200):
        for pair in left_out:
            alone = replace(body, arrays=body.arrays._replace(pairs=pair[None].copy()))
            assert clear_m(alone, q) < 0.0


@pytest.mark.parametrize("link", ["root_link", "torso_1", "chest", "head", "neck_1", "neck_2"])
def test_no_vertex_of_the_trunk_sticks_out(meshes: dict[str, Mesh], body: Body, link: str) -> None:
    assert outside_m(meshes, body, link) <= 0.0


@pytest.mark.parametrize("side", ["l", "r"])
@pytest.mark.parametrize("link", [*ARM_LINKS, "shoulder_1", "shoulder_2", "upper_leg", "hip_1"])
def test_no_vertex_of_a_limb_sticks_out(
    meshes: dict[str, Mesh], body: Body, side: str, link: str
) -> None:
    assert outside_m(meshes, body, f"{side}_{link}") <= 0.0


def outside_m(meshes: dict[str, Mesh], body: Body, link: str) -> float:
    """How far the worst vertex is from all capsules, at one bent posture."""
    q = 0.4 * np.sin(np.arange(float(len(body.joints))))
    segments = np.zeros((len(body.capsules), 6))
    place_body(q, body.arrays, np.zeros((len(body.joints), 12)), segments)
    model = RobotModel(str(urdf_path("iCubLisboa01")), body.joints, link, {})
    R, p = model.tip_pose(q)
    vertices = np.unique(meshes[link].moved(R, p).corners_m.reshape(-1, 3), axis=0)
    nearest = np.full(len(vertices), np.inf)
    for (ax, ay, az, bx, by, bz), radius_m in zip(segments, body.arrays.radii, strict=True):
        a, along = np.array([ax, ay, az]), np.array([bx - ax, by - ay, bz - az])
        length2 = max(float(along @ along), 1e-12)
        share = np.clip((vertices - a) @ along / length2, 0.0, 1.0)
        away = np.linalg.norm(vertices - a - share[:, None] * along, axis=1)
        nearest = np.minimum(nearest, away - radius_m)
    return float(nearest.max())


def test_both_arms_are_each_others_mirror_image(robot: RobotFile, body: Body) -> None:
    q = posture(robot, body, "home")
    segments = np.zeros((len(body.capsules), 6))
    place_body(q, body.arrays, np.zeros((len(body.joints), 12)), segments)
    for link in ARM_LINKS:
        left, right = body.capsules.index(f"l_{link}"), body.capsules.index(f"r_{link}")
        image = segments[left].reshape(2, 3) * [1.0, -1.0, 1.0]
        assert np.abs(image - segments[right].reshape(2, 3)).max() < 1.5e-3
        assert body.arrays.radii[left] == pytest.approx(body.arrays.radii[right], abs=3e-4)


def test_one_arm_alone_keeps_from_the_other_that_hangs_at_zero(robot: RobotFile) -> None:
    alone = robot_body(load_robot("icub:reach"))
    assert alone.joints == robot.chain
    assert alone.tips == ("r_hand_dh_frame",)
    names = pair_names(alone)
    assert frozenset(("r_hand", "l_forearm")) in names
    assert all(any(name.startswith("r_") for name in pair) for pair in names)
    assert clear_m(alone, np.radians(robot.reach.home_deg)) == pytest.approx(0.0547, abs=5e-4)


def test_a_robot_without_limbs_in_use_has_a_body_that_stands_still() -> None:
    legs = robot_body(load_robot("icub:left_leg"))
    assert legs.joints == legs.tips == ()
    assert clear_m(legs, np.zeros(0)) == np.inf


def beside(robot: RobotFile, tmp_path: Path, text: str | None) -> RobotFile:
    if text is not None:
        (tmp_path / FILE).write_text(text, encoding="utf-8")
    return msgspec.structs.replace(robot, path=tmp_path / "robot.toml")


def test_a_robot_without_the_file_gets_capsules_from_joint_to_joint(
    robot: RobotFile, tmp_path: Path
) -> None:
    plain = robot_body(beside(robot, tmp_path, None))
    assert plain.joints == robot_body(robot).joints
    assert len(plain.arrays.pairs) > 50
    assert clear_m(plain, posture(robot, plain, "home")) > 0.0


def test_capsules_of_another_model_are_not_used(robot: RobotFile, tmp_path: Path) -> None:
    other = 'urdf = "iCubGazeboV2_5"\ncapsules = []\n'
    assert len(robot_body(beside(robot, tmp_path, other)).capsules) > 0


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ('urdf = "iCubLisboa01"\n', "capsules"),
        ('urdf = "iCubLisboa01"\ncapsules = []\ncolour = 1\n', "colour"),
        (
            'urdf = "iCubLisboa01"\nalways_near = [["tail", "root"]]\ncapsules = []\n',
            "no capsule 'root'",
        ),
        (
            'urdf = "iCubLisboa01"\n[[capsules]]\nname = "a"\nlink = "tail"\n'
            "start_m = [0.0, 0.0, 0.0]\nend_m = [0.0, 0.0, 0.0]\nradius_m = 0.1\n",
            "no frame 'tail'",
        ),
        (
            'urdf = "iCubLisboa01"\n[[capsules]]\nname = "a"\nlink = "chest"\n'
            "start_m = [0.0, 0.0, 0.0]\nend_m = [0.0, 0.0, 0.0]\nradius_m = -0.1\n",
            "radius_m is -0.1",
        ),
    ],
)
def test_a_wrong_file_is_refused_with_what_is_wrong(
    robot: RobotFile, tmp_path: Path, text: str, said: str
) -> None:
    with pytest.raises(ConfigError, match=said):
        robot_body(beside(robot, tmp_path, text))
