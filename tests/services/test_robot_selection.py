"""Parts of a robot, the whole robot, and what a site changes."""

from pathlib import Path

import pytest

from services.config import load_robot
from services.core.errors import ConfigError
from services.emulated.emulation import rig_spec
from services.robotfile.robot_selection import split_reference
from services.robotfile.wiring import robot_description


def at(folder: Path, site: str) -> str:
    """A copy of the robot with one site file, as a reference."""
    robot = Path(load_robot("icub").path)
    (folder / "sites").mkdir()
    (folder / "sites" / "lab.toml").write_text(site, encoding="utf-8")
    (folder / "robot.toml").write_text(robot.read_text(encoding="utf-8"), encoding="utf-8")
    return f"{folder / 'robot.toml'}@lab"


def test_a_reference_names_robot_parts_and_site() -> None:
    assert split_reference("icub") == ("icub", "", "")
    assert split_reference("icub:reach") == ("icub", "reach", "")
    assert split_reference("r/robot.toml:arms@lab") == ("r/robot.toml", "arms", "lab")


def test_the_whole_robot_has_53_axes_on_ten_buses() -> None:
    robot = load_robot("icub")
    kinds = [board.type for board in robot.boards.values()]
    assert len(robot.joints) == 53
    assert len(robot.buses) == 10
    assert sum(kind in ("bll_ie", "bll_dc", "dc4") for kind in kinds) == 20
    assert [kinds.count(kind) for kind in ("strain", "mais", "mtb", "imu")] == [6, 2, 18, 1]
    assert sorted(joint for names in robot.parts.values() for joint in names) == sorted(
        robot.joints
    )


def test_the_legs_listen_to_their_own_torque_channels() -> None:
    joints = {joint.name: joint for joint in robot_description(load_robot("icub")).joints}
    left, right = joints["l_knee"].torque_source, joints["r_knee"].torque_source
    assert left is not None
    assert right is not None
    assert (left.address, left.channel) == (12, 3)
    assert (right.address, right.channel) == (11, 3)


def test_a_selection_keeps_what_its_parts_need() -> None:
    robot = load_robot("icub:reach")
    assert list(robot.parts) == ["torso", "right_arm"]
    assert set(robot.boards) == {
        "torso_yaw", "waist", "r_shoulder", "r_elbow", "r_forearm", "r_arm_strain"
    }  # fmt: skip
    assert list(robot.buses) == ["head_torso", "right_arm"]
    assert list(robot.sensors) == ["r_arm_ft"]
    assert set(robot.virtual_sensors) == {"right_arm", "torso"}


def test_a_part_and_a_group_of_boards_are_selections_too() -> None:
    assert list(load_robot("icub:right_hand").boards) == [
        "r_forearm", "r_hand_proximal", "r_hand_distal", "r_mais"
    ]  # fmt: skip
    assert len(load_robot("icub:left_arm_skin").boards) == 7


def test_an_unknown_selection_lists_the_known_ones() -> None:
    with pytest.raises(ConfigError, match=r"unknown selection 'tail'; known: reach, arms"):
        load_robot("icub:tail")


def test_a_site_makes_a_bus_real_and_a_board_on_it_emulated(tmp_path: Path) -> None:
    site = """
[buses]
right_arm = { channel = "can2", simulated = false }
[boards]
r_forearm = { simulated = true }
"""
    robot = load_robot(at(tmp_path, site))
    assert robot.buses["right_arm"].channel == "can2"
    assert not robot.is_simulated("r_shoulder")
    assert robot.is_simulated("r_forearm")
    assert robot.is_simulated("l_shoulder")
    spec = rig_spec(robot, seed=0)
    driven = [axis.joint for axis in spec.axes if axis.driven]
    assert driven == ["r_shoulder_pitch", "r_shoulder_roll", "r_shoulder_yaw", "r_elbow"]
    assert "r_elbow" not in [board.name for board in spec.boards]
    assert "r_arm_ft" not in [sensor.name for sensor in spec.sensors]


@pytest.mark.parametrize(
    ("site", "expected"),
    [
        ("[buses]\nright_leg_skin = { simulated = true }", "unknown bus; known: head_torso"),
        ("[boards]\nwrist = { simulated = true }", "unknown board; known: neck"),
        ("[boards]\nwaist = { emulated = true }", "unknown key; allowed: simulated"),
        (
            "[joints]\nr_elbow = { axis = 1 }",
            "joints: unknown table; allowed: buses",
        ),
        ("[buses]\nright_arm = { channel = 'can2' }", "buses.right_arm"),
    ],
)
def test_a_wrong_site_file_is_refused(tmp_path: Path, site: str, expected: str) -> None:
    with pytest.raises(ConfigError) as caught:
        load_robot(at(tmp_path, site))
    assert expected in str(caught.value)


def test_a_site_may_let_the_robot_start_with_what_answers(tmp_path: Path) -> None:
    site = "[start]\nallow_missing = true\n"
    assert robot_description(load_robot(at(tmp_path, site))).allow_missing
    assert not robot_description(load_robot("icub@real")).allow_missing


def test_an_unknown_site_lists_the_known_ones() -> None:
    with pytest.raises(ConfigError, match="known sites: bench, real"):
        load_robot("icub@moon")


def test_every_bus_of_the_real_site_is_real() -> None:
    robot = load_robot("icub@real")
    assert not any(map(robot.is_simulated, robot.boards))
    assert [bus.channel for bus in robot.buses.values()] == [f"can{n}" for n in range(10)]


@pytest.mark.parametrize(
    ("site", "why"),
    [
        ("[sensors.nose]\ngain = []\n", "sensors.nose: unknown sensor; known: l_arm_ft"),
        ("[sensors.r_arm_ft]\nframe = 'x'\n", "sensors.r_arm_ft.frame: unknown key; allowed: gain"),
        ("[sensors.r_arm_ft]\ngain = [1.0, 2.0]\n", "has 2 numbers; six rows of six are needed"),
        (f"[sensors.r_arm_ft]\ngain = {[0.0] * 36}\n", "sensors.r_arm_ft.gain: determinant 0;"),
        ("[sensors.r_arm_ft]\ngain = ['a']\n", "sensors.r_arm_ft.gain[0]: expected `float`"),
    ],
)
def test_a_gain_that_is_none_is_refused(tmp_path: Path, site: str, why: str) -> None:
    with pytest.raises(ConfigError) as refusal:
        load_robot(at(tmp_path, site))
    assert "lab.toml" in str(refusal.value)
    assert why in str(refusal.value)
