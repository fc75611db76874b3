from pathlib import Path

import msgspec
import numpy as np
import pytest

from dforc.contacts.location import locate
from dforc.contacts.skin import SkinContacts
from dforc.robot_model import RobotModel
from services.config import load_robot
from services.core.errors import ConfigError
from services.robotfile.model_file import urdf_path
from services.robotfile.robot_tables import RobotFile
from services.robotfile.shape_tables import (
    DEFAULT_RADIUS_M,
    child_origins,
    link_shapes,
    skin_patches,
)

CAPSULE = '[[shapes]]\nlink = "r_hand"\nstart_m = [0, 0, 0]\nend_m = [0, 0, 0.1]\nradius_m = 0.03\n'
SKIN = '[[skin]]\nboard = "r_hand_skin"\nlink = "r_hand"\npoint_m = [0, 0, 0]\nassumed = true\n'


def robot_with(folder: Path, text: str, urdf: str = "iCubLisboa01") -> RobotFile:
    (folder / "shapes.toml").write_text(text, encoding="utf-8")
    robot = load_robot("icub")
    table = msgspec.structs.replace(robot.robot, urdf=urdf)
    return msgspec.structs.replace(robot, path=folder / "robot.toml", robot=table)


def test_the_icub_has_shapes_for_arms_and_legs() -> None:
    links = link_shapes(load_robot("icub")).links
    for side in "lr":
        for link in ("upper_arm", "forearm", "hand", "upper_leg", "lower_leg", "ankle_1", "foot"):
            assert f"{side}_{link}" in links


def test_every_skin_board_of_the_icubs_arms_has_a_place() -> None:
    robot = load_robot("icub")
    placed = {patch.board for patch in skin_patches(robot)}
    arms = {name for name, board in robot.boards.items() if board.part.endswith("_arm_skin")}
    assert placed == arms
    SkinContacts(skin_patches(robot))


def test_skin_of_one_arm_is_one_limb() -> None:
    patches = skin_patches(load_robot("icub"))
    assert {patch.limb for patch in patches if patch.link == "r_hand"} == {"right_arm_skin"}


def test_a_robot_without_a_file_gets_capsules_between_its_joints(tmp_path: Path) -> None:
    robot = msgspec.structs.replace(load_robot("icub"), path=tmp_path / "robot.toml")
    forearm = [c for c in link_shapes(robot).capsules if c.link == "r_forearm"]
    assert [(c.end_m[1], c.radius_m) for c in forearm] == [(-0.1373, DEFAULT_RADIUS_M)]
    assert skin_patches(robot) == ()


def test_a_file_for_another_model_is_not_used(tmp_path: Path) -> None:
    robot = robot_with(tmp_path, f'urdf = "iCubLisboa01"\n{CAPSULE}', urdf="iCubGazeboV2_5")
    assert len(link_shapes(robot).links) > 20


def test_frames_without_mass_have_no_shape() -> None:
    origins = child_origins(urdf_path("iCubLisboa01"))
    assert "r_hand" in origins
    assert "r_hand_dh_frame" not in origins


@pytest.mark.parametrize(
    ("text", "complaint"),
    [
        (CAPSULE, "urdf"),
        (f'urdf = "iCubLisboa01"\ncolour = 1\n{CAPSULE}', "colour"),
        (f'urdf = "iCubLisboa01"\n{CAPSULE.replace("r_hand", "r_tail")}', "no link 'r_tail'"),
        (f'urdf = "iCubLisboa01"\n{CAPSULE.replace("0.03", "0.0")}', "radius"),
        (f'urdf = "iCubLisboa01"\n{CAPSULE.replace("0.03", "nan")}', "not finite"),
        ('urdf = "iCubLisboa01"\nshapes = []\n', "no capsule"),
        (f'urdf = "iCubLisboa01"\n{CAPSULE}{SKIN}triangles_m = [[0, 0, 0]]\n', "1 points, not 16"),
    ],
)
def test_a_wrong_file_is_refused_by_name(tmp_path: Path, text: str, complaint: str) -> None:
    with pytest.raises(ConfigError, match=complaint) as refused:
        link_shapes(robot_with(tmp_path, text))
    assert "shapes.toml" in str(refused.value)


@pytest.mark.parametrize("link", ["r_upper_arm", "r_forearm", "r_hand"])
def test_a_push_on_the_hanging_arm_is_found_by_the_icubs_shapes(link: str) -> None:
    robot = load_robot("icub")
    urdf = str(urdf_path(robot.robot.urdf))
    names = ("r_upper_arm", "r_forearm", "r_hand")
    models = {name: RobotModel(urdf, ("r_elbow",), name, {}) for name in names}
    poses = {name: model.tip_pose(np.zeros(1)) for name, model in models.items()}
    posed = link_shapes(robot).only(names).posed_by(poses.__getitem__)
    own = [i for i, at in enumerate(posed.link_at) if posed.links[at] == link]
    thick = max(own, key=lambda i: float(posed.radius_m[i]))
    middle = 0.5 * (posed.start_m[thick] + posed.end_m[thick])
    push = np.array([0.0, -10.0, 0.0])  # to the robot's left, at its right side
    sensor = poses["r_upper_arm"][1]
    found = locate(push, np.cross(middle - sensor, push), sensor, posed)
    assert (found.link, found.certainty) == (link, "sure")
    assert found.point_m[1] > middle[1]
