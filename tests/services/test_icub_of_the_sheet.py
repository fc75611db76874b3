"""The robot file of the iCub against the wiring of can-protocol 11, typed from there."""

import pytest

from hal.description import Joint, RobotDescription
from services.config import load_robot
from services.robotfile.wiring import robot_description

ARM = (
    ("shoulder_pitch", 1, 0, -95.5, 10, 7000),
    ("shoulder_roll", 1, 1, 0, 161, 7000),
    ("shoulder_yaw", 2, 0, -30, 75, 7000),
    ("elbow", 2, 1, 15, 106, 7000),
    ("wrist_prosup", 3, 0, -50, 85, 1000),
    ("wrist_pitch", 3, 1, -80, 25, 800),
    ("wrist_yaw", 4, 0, -20, 25, 800),
    ("hand_finger", 4, 1, 0, 60, 800),
)
ARM_SCALES = {
    "l": (
        (-11.375, -11.375, 11.375, -11.375, 706.67, -11.375, 11.375, -4.16667),
        (-185, -330, 169, -181, -74, -180, 180, -600),
    ),
    "r": (
        (11.375, 11.375, -11.375, 11.375, -706.67, 11.375, -11.375, -4.66667),
        (177, 37, -198, 180, -74, 180, -180, -482.143),
    ),
}
HAND = (
    *(("thumb_oppose", 10, 90), ("thumb_proximal", 0, 90)),
    *(("thumb_distal", 0, 170), ("index_proximal", 0, 90)),
    *(("index_distal", 0, 170), ("middle_proximal", 0, 90)),
    *(("middle_distal", 0, 170), ("ring_little", 0, 250)),
)
HAND_SCALES = {
    "l": (
        (7.78, -1.97, -2.44, -2.50, -2.22, -2.39, -2.39, -2.14),
        (164.57, -120.51, -196.36, -102, -220.5, -102.56, -205.12, -350.47),
    ),
    "r": (
        (12.91, -2.50, -2.36, -2.39, -2.50, -2.50, -2.31, -2.16),
        (111.163, -98, -199.06, -106.74, -200, -98, -219.04, -342.59),
    ),
}
LEG = (
    ("hip_pitch", 6, 0, 180, -30, 90),
    ("hip_roll", 6, 1, -180, -90, 0),  # mirrored: the model's hip roll is positive inwards
    ("hip_yaw", 5, 0, 180, -40, 65),
    ("knee", 5, 1, 179, -120, 0),
    ("ankle_pitch", 7, 0, 180, -20, 30),
    ("ankle_roll", 7, 1, 180, -10, 15),
)
# Bus, address, axis, ticks/deg, zero, limits, current limit.
Row = tuple[int, int, int, float, float, float, float, int]
TABLE: dict[str, Row] = {
    "torso_yaw": (0, 5, 0, 11.375, 180, -50, 50, 7000),
    "torso_roll": (0, 6, 0, 11.375, 180, -30, 30, 7000),
    "torso_pitch": (0, 6, 1, 11.375, 180, -22, 70, 7000),
    "neck_pitch": (0, 1, 0, 11.375, 180, -30, 22, 2000),
    "neck_roll": (0, 1, 1, -11.375, -180, -20, 20, 2000),
    "neck_yaw": (0, 2, 0, 11.375, 180, -45, 45, 1200),
    "eyes_tilt": (0, 2, 1, 11.375, 175, -30, 30, 620),
    "eyes_version": (0, 3, 0, 568.88, -45, -30, 30, 600),
    "eyes_vergence": (0, 3, 1, 284.44, 0, 0, 50, 600),
}
for _bus, _side in ((1, "l"), (2, "r")):
    for (_name, _address, _axis, _low, _high, _ma), _scale, _zero in zip(
        ARM, *ARM_SCALES[_side], strict=True
    ):
        TABLE[f"{_side}_{_name}"] = (_bus, _address, _axis, _scale, _zero, _low, _high, _ma)
    for _place, ((_name, _low, _high), _scale, _zero) in enumerate(
        zip(HAND, *HAND_SCALES[_side], strict=True)
    ):
        _wire = (_bus + 4, 5 + _place // 2, _place % 2)
        TABLE[f"{_side}_{_name}"] = (*_wire, _scale, _zero, _low, _high, 485)
for _name, _address, _axis, _zero, _low, _high in LEG:
    _scale = 11.375 if _zero > 0 else -11.375
    TABLE[f"l_{_name}"] = (3, _address, _axis, _scale, _zero, _low, _high, 7000)
    _other = -180 if _zero > 0 else 180  # -180 for all, the mirrored one apart
    TABLE[f"r_{_name}"] = (4, _address + 3, _axis, -_scale, _other, _low, _high, 7000)

ROBOT = load_robot("icub")
DESCRIPTION: RobotDescription = robot_description(ROBOT)
JOINTS: dict[str, Joint] = {joint.name: joint for joint in DESCRIPTION.joints}


def test_every_joint_is_in_the_table() -> None:
    assert set(JOINTS) == set(TABLE)
    assert len(TABLE) == 53


@pytest.mark.parametrize("name", TABLE)
def test_joint_is_wired_and_scaled_as_in_the_sheet(name: str) -> None:
    joint, table = JOINTS[name], ROBOT.joints[name]
    found = (
        *(joint.bus, joint.address, joint.axis, joint.ticks_per_deg, joint.zero_deg),
        *table.limits_deg,
        joint.current_limit_ma,
    )
    assert found == TABLE[name]


@pytest.mark.parametrize(
    ("bus", "address", "kind", "firmware", "mask"),
    [
        (0, 1, "bll_dc", (1, 0x62), 0x35),
        (0, 2, "dc4", (2, 0x15), 0x35),
        (0, 5, "bll_ie", (2, 0x54), 0x35),
        (0, 6, "bll_ie", (2, 0x52), 0x35),
        *((bus, 1, "bll_ie", (2, 0x50), 0x37) for bus in (1, 2)),
        *((bus, 2, "bll_ie", (2, 0x57), 0x37) for bus in (1, 2)),
        *((bus, 3, "dc4", (2, 0x19), 0x35) for bus in (1, 2)),
        *((3, address, "bll_ie", (2, 0x51), 0x35) for address in (5, 6, 7)),
        *((4, address, "bll_ie", (2, 0x51), 0x35) for address in (8, 9, 10)),
        *((bus, 5, "dc4", (2, 0x28), 0x35) for bus in (5, 6)),
        *((bus, 7, "dc4", (2, 0x30), 0x35) for bus in (5, 6)),
    ],
)
def test_motor_board_is_where_and_what_the_sheet_says(
    bus: int, address: int, kind: str, firmware: tuple[int, int], mask: int
) -> None:
    (board,) = (b for b in DESCRIPTION.boards if (b.bus, b.address) == (bus, address))
    assert (board.type, board.firmware) == (kind, firmware)
    # Velocities are asked for beside what robots ask for.
    assert board.broadcast == (mask | 0x40,) * (2 if kind == "dc4" else 1)


def test_sensor_boards_are_where_the_sheet_says() -> None:
    found = {(b.bus, b.address): b.type for b in DESCRIPTION.boards if not b.broadcast}
    strains = {(1, 13), (2, 13), (3, 13), (3, 1), (4, 14), (4, 1)}
    skins = {(bus, address) for bus in (7, 8) for address in range(8, 15)}
    skins |= {(9, address) for address in range(7, 11)}
    assert found == {
        **dict.fromkeys(strains, "strain"),
        **dict.fromkeys(((5, 14), (6, 14)), "mais"),
        **dict.fromkeys(skins, "mtb"),
        (0, 14): "imu",
    }


ARM_GAINS = (
    *((32000, 60, 50, 13, 800), (32000, 60, 50, 13, 800), (-32000, -60, -50, 13, 800)),
    *((32000, 60, 20, 13, 800), (-200, -1, -1000, 6, 1333), (1000, 1, 10000, 7, 1333)),
    *((-1000, -1, -10000, 7, 1333), (200, 1, 200, 4, 1333)),
)


@pytest.mark.parametrize("side", "lr")
def test_position_gains_of_an_arm(side: str) -> None:
    for (name, *_), gains in zip(ARM, ARM_GAINS, strict=True):
        pid = JOINTS[f"{side}_{name}"].position_pid
        kp, ki, kd, shift, largest = gains
        sign = -1 if (side, name) == ("r", "hand_finger") else 1
        assert (pid.kp, pid.ki, pid.kd) == (sign * kp, sign * ki, sign * kd), name
        assert (pid.shift, pid.output_limit) == (shift, largest), name


def test_position_gains_of_torso_and_legs() -> None:
    for name, joint in JOINTS.items():
        pid = joint.position_pid
        if name.startswith("torso"):
            assert (pid.kp, pid.ki, pid.kd, pid.shift) == (32000, 60, 6000, 13)
        elif joint.part.endswith("leg"):
            assert (abs(pid.kp), abs(pid.ki), abs(pid.kd), pid.shift) == (32000, 60, 100, 13)


@pytest.mark.parametrize(("side", "sign"), [("l", -1), ("r", 1)])
def test_torque_gains_of_an_arm_have_the_signs_of_the_robots_and_are_not_smaller(
    side: str, sign: int
) -> None:
    gains = ((76, 14), (76, 14), (288, 14), (288, 14), (80, 10))
    for (name, *_), (kp, shift) in zip(ARM[:5], gains, strict=True):
        pid = JOINTS[f"{side}_{name}"].torque_pid
        assert pid is not None
        assert pid.shift == shift
        assert sign * pid.kp >= kp


def test_torque_gain_of_the_torso_is_not_below_6_by_2_to_the_11() -> None:
    for name in ("torso_yaw", "torso_roll", "torso_pitch"):
        pid = JOINTS[name].torque_pid
        assert pid is not None
        assert pid.kp / 2**pid.shift >= 6 / 2**11


def test_a_torque_loop_without_torques_asks_for_no_more_than_with_the_robots_gains() -> None:
    # (kp + kff) of full scale, 2^15, shifted by 14: twice their sum, for the robots' kp
    robots = {"shoulder_pitch": 76 + 19, "knee": 48 + 17, "ankle_pitch": 48 + 37}
    for name, gains in robots.items():
        pid = JOINTS[f"r_{name}"].torque_pid
        assert pid is not None
        assert pid.output_limit <= 2 * gains


CALIBRATIONS = {
    "l": (
        (3, 3, 3, 3, 0, 3, 3, 3),
        (2388.75, 3241.875, 2047.5, 1535.625, 1000, 2047.5, 2047.5, 2291),
        (10, 10, 10, 10, 20, 10, 10, 100),
        (3081.4875, 1918.9625, 2405.813, 879.2875, 0, 1205.75, 3071.25, 0),
    ),
    "r": (
        (3, 3, 3, 3, 0, 3, 3, 3),
        (1706.25, 853.13, 2047.5, 2559.38, 900, 2047.5, 2047.5, 2150),
        (10, 10, 10, 10, -20, 10, 10, 100),
        (348.075, 2.275, 448.175, 1370.688, 0, 3202.063, 1057.875, 0),
    ),
}


@pytest.mark.parametrize("side", "lr")
def test_calibration_of_an_arm(side: str) -> None:
    for (name, *_), *expected in zip(ARM, *CALIBRATIONS[side], strict=True):
        found = JOINTS[f"{side}_{name}"].calibration
        assert [found.type, found.p1, found.p2, found.p3] == expected, name


def test_calibration_of_the_others() -> None:
    for name, p3 in (("torso_yaw", 2612.838), ("torso_roll", 364), ("torso_pitch", 836.0625)):
        found = JOINTS[name].calibration
        assert (found.type, found.p3) == (3, p3)
    head = [ROBOT.joints[name].calibration.type for name in ROBOT.parts["head"]]
    assert head == [3, 3, 3, 3, 0, 0]
    for side in "lr":
        hand = [JOINTS[f"{side}_{name}"].calibration.type for name, *_ in HAND]
        assert hand == [3, 4, 4, 4, 4, 4, 4, 4]
    legs = [joint.calibration for joint in JOINTS.values() if joint.part.endswith("leg")]
    assert {(found.type, found.p2, found.startup_pwm) for found in legs} == {(3, 10.0, 120)}


def test_the_sign_of_a_thumbs_gain_tells_the_firmware_which_hand_it_is() -> None:
    assert JOINTS["l_thumb_oppose"].position_pid.kp < 0 < JOINTS["r_thumb_oppose"].position_pid.kp


def test_torque_sources_are_those_compiled_into_the_firmwares() -> None:
    expected = {
        **{"torso_yaw": (12, 0), "torso_roll": (12, 1), "torso_pitch": (12, 2)},
        **{f"{s}_{name}": (12, i) for s in "lr" for i, (name, *_) in enumerate(ARM[:5])},
        **{f"l_{name}": (12, i) for i, (name, *_) in enumerate(LEG)},
        **{f"r_{name}": (11, i) for i, (name, *_) in enumerate(LEG)},
    }
    found = {
        name: (joint.torque_source.address, joint.torque_source.channel)
        for name, joint in JOINTS.items()
        if joint.torque_source is not None
    }
    assert found == expected
    scales = {joint.part: joint.torque_source for joint in JOINTS.values() if joint.torque_source}
    assert {part: source.full_scale_nm for part, source in scales.items()} == {
        **dict.fromkeys(("left_arm", "right_arm"), 8.0),
        **dict.fromkeys(("torso", "left_leg", "right_leg"), 12.0),
    }


def test_shifts_and_times_of_a_configuration() -> None:
    host = DESCRIPTION
    assert (host.velocity_shift, host.velocity_timeout_ms, host.speed_estimate_shift) == (8, 100, 5)
