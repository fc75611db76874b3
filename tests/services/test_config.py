"""The robot file: what it gives, and how a wrong one is refused."""

import copy
import tomllib
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from services.config import load_robot, parse_robot, robots_folder
from services.core.errors import ConfigError
from services.robot_messages import RobotRequest
from services.robotfile.wiring import joint_limits_deg, parked, robot_description

PATH = Path("robot.toml")


@pytest.fixture
def raw() -> dict[str, Any]:
    text = (robots_folder() / "icub" / "robot.toml").read_text(encoding="utf-8")
    return copy.deepcopy(tomllib.loads(text))


def refusal(raw: dict[str, Any]) -> str:
    with pytest.raises(ConfigError) as caught:
        parse_robot(raw, PATH)
    return str(caught.value)


def test_describes_torso_and_right_arm() -> None:
    description = robot_description(load_robot("icub:reach"))
    assert [joint.name for joint in description.joints][:4] == [
        "torso_pitch",
        "torso_roll",
        "torso_yaw",
        "r_shoulder_pitch",
    ]
    wrist_yaw = description.joints[-1]
    assert (wrist_yaw.bus, wrist_yaw.address, wrist_yaw.axis) == (2, 4, 0)
    assert {(b.bus, b.address) for b in description.boards} == {
        (0, 5), (0, 6), (2, 1), (2, 2), (2, 3), (2, 13)
    }  # fmt: skip


def test_firmware_numbers_are_bcd_words() -> None:
    boards = {board.name: board for board in robot_description(load_robot("icub:reach")).boards}
    assert boards["r_elbow"].firmware == (0x02, 0x57)


def test_shoulder_boards_broadcast_their_duty() -> None:
    boards = {board.name: board for board in robot_description(load_robot("icub:reach")).boards}
    assert boards["r_shoulder"].broadcast[0] & 0x37 == 0x37
    assert boards["waist"].broadcast[0] & 0x37 == 0x35


def test_limits_are_the_intersection_with_the_model() -> None:
    robot = load_robot("icub:reach")
    assert joint_limits_deg(robot, "r_wrist_prosup") == pytest.approx((-50.0, 50.0), abs=1e-3)
    assert joint_limits_deg(robot, "r_elbow") == (15.0, 106.0)


def test_torque_max_is_the_virtual_sensor_s_full_scale() -> None:
    joints = {joint.name: joint for joint in robot_description(load_robot("icub:reach")).joints}
    source = joints["r_elbow"].torque_source
    assert source is not None
    assert (source.address, source.channel, source.full_scale_nm) == (12, 3, 8.0)
    assert joints["r_wrist_pitch"].torque_source is None


def test_unknown_key_is_named_with_the_allowed_ones(raw: dict[str, Any]) -> None:
    raw["joints"]["r_elbow"]["ticks_per_rad"] = 1.0
    message = refusal(raw)
    assert "robot.toml: joints.r_elbow.ticks_per_rad: unknown key" in message
    assert "ticks_per_deg" in message


def test_wrong_unit_in_a_nested_table_is_named(raw: dict[str, Any]) -> None:
    raw["joints"]["r_elbow"]["impedance"] = {"stiffness_nm_rad": 20.0, "damping_nms_deg": 0.03}
    message = refusal(raw)
    assert "joints.r_elbow.impedance.stiffness_nm_rad: unknown key" in message
    assert "stiffness_nm_deg" in message


def test_wrong_type_is_named(raw: dict[str, Any]) -> None:
    raw["joints"]["r_elbow"]["zero_deg"] = "180"
    assert "joints.r_elbow.zero_deg" in refusal(raw)


def test_a_missing_pwm_limit_is_named(raw: dict[str, Any]) -> None:
    del raw["joint_types"]["arm"]["pwm_limit"]
    assert "pwm_limit" in refusal(raw)


@pytest.mark.parametrize(
    ("table", "key", "value", "expected"),
    [
        ("boards", "type", "bll3", "boards.r_elbow.type"),
        ("boards", "bus", "pelvis", "allowed: head_torso, left_arm"),
        ("boards", "address", 15, "15 is outside 1..14"),
        ("boards", "address", 4, "r_forearm"),
        ("boards", "firmware", "two", "major.minor"),
        ("joints", "motor", "big", "unknown name 'big'; allowed: torso"),
        ("joints", "axis", 2, "2 is outside 0..1"),
        ("joints", "limits_deg", [106.0, 15.0], "is not below"),
        ("joints", "ticks_per_deg", -11.375, "positive feedback"),
    ],
)
def test_wrong_value_is_refused(
    raw: dict[str, Any], table: str, key: str, value: object, expected: str
) -> None:
    raw[table]["r_elbow"][key] = value
    assert expected in refusal(raw)


def test_missing_and_unknown_tables_are_named(raw: dict[str, Any]) -> None:
    rows = raw.pop("rows")
    assert "rows: this table is missing" in refusal(raw)
    raw["rows"], raw["row"] = rows, rows
    assert "row: unknown table; allowed: robot" in refusal(raw)


def test_unknown_robot_lists_the_known_ones() -> None:
    with pytest.raises(ConfigError, match="known robots: icub"):
        load_robot("coman")


def test_invalid_toml_names_the_file(tmp_path: Path) -> None:
    path = tmp_path / "robot.toml"
    path.write_text("[robot", encoding="utf-8")
    with pytest.raises(ConfigError, match=r"robot\.toml: not valid TOML"):
        load_robot(str(path))


def test_value_that_is_no_number_is_named(raw: dict[str, Any]) -> None:
    raw["joints"]["r_elbow"]["limits_deg"] = [15.0, float("nan")]
    assert "joints.r_elbow.limits_deg: nan is no finite number" in refusal(raw)


def test_rate_of_zero_is_refused(raw: dict[str, Any]) -> None:
    raw["rates"]["wrench"]["live_hz"] = 0
    assert "rates.wrench.live_hz: 0 is outside 1..1000" in refusal(raw)


def test_bus_number_used_twice_is_refused(raw: dict[str, Any]) -> None:
    raw["buses"]["right_arm"]["number"] = 0
    assert "buses.right_arm.number: 0 is head_torso's" in refusal(raw)


def test_part_that_is_no_list_is_refused(raw: dict[str, Any]) -> None:
    raw["parts"]["torso"] = 3
    assert "parts: each needs a list of joints" in refusal(raw)


def test_row_over_an_unknown_joint_is_refused(raw: dict[str, Any]) -> None:
    raw["rows"][0]["coefficients"] = {"l_shoulder_tilt": 1.0}
    message = refusal(raw)
    assert "rows.l_cable_1.coefficients: unknown name 'l_shoulder_tilt'; allowed: neck_p" in message


@pytest.mark.parametrize(
    ("key", "value", "expected"),
    [
        ("parts", ["torso", "tail"], "parts: unknown name 'tail'; allowed: head, torso"),
        ("parts", [], "parts: needs parts, each once"),
        ("parts", ["torso", "torso"], "parts: needs parts, each once"),
        ("sensor", "l_hand_ft", "sensor: unknown name 'l_hand_ft'; allowed: l_arm_ft"),
        ("compliant", ["r_elbow"], "compliant: unknown name 'r_elbow'; allowed: torso_pitch"),
        ("home_deg", [0.0] * 9, "home_deg: needs 10 values, one per joint of torso, left_arm"),
        ("rest_deg", [0.0] * 11, "rest_deg: needs 10 values"),
        ("rest_weights", [1.0], "rest_weights: needs 10 values"),
        ("rest_weights", [-1.0] + [1.0] * 9, "rest_weights: must not be negative"),
        ("rest_beta", 0.0, "rest_beta: must be above 0"),
        ("tip_frame", 3, "tip_frame: expected `str`"),
    ],
)
def test_wrong_limb_is_refused(raw: dict[str, Any], key: str, value: object, expected: str) -> None:
    raw["limbs"]["left_arm"][key] = value
    assert f"limbs.left_arm.{expected}" in refusal(raw)


def test_main_job_with_an_unknown_limb_is_refused(raw: dict[str, Any]) -> None:
    raw["reach"]["limb"] = "trunk"
    assert "reach.limb: unknown name 'trunk'; allowed: left_arm, right_arm" in refusal(raw)


def test_a_stop_without_a_posture_comes_down_to_the_park_posture() -> None:
    robot = load_robot("icub:reach")
    whole = parked(robot, RobotRequest(action="stop"))
    assert whole.joints == robot.chain
    assert whole.q_rad == pytest.approx(np.radians([0, 0, 0, -10, 30, 0, 20, 0, 0, 0]))
    elbow = parked(robot, RobotRequest(action="stop", joints=("r_elbow",)))
    assert elbow.joints == ("r_elbow",)
    assert elbow.q_rad == (whole.q_rad[robot.chain.index("r_elbow")],)
