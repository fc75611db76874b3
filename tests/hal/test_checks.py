"""Descriptions that no Robot is made of."""

from typing import Any

import msgspec
import pytest

from hal.description import RobotDescription, TorqueSource
from hal.errors import DescriptionError
from hal.robot import Robot
from tests.hal.arm import BUS, DESCRIPTION, compliant_joint, joint
from tests.hal.scripted import ScriptedBus


def with_joints(*joints: Any) -> RobotDescription:
    return msgspec.structs.replace(DESCRIPTION, joints=joints)


def refusal(description: RobotDescription) -> str:
    with pytest.raises(DescriptionError) as refused:
        Robot(description, {BUS: ScriptedBus()})
    return str(refused.value)


def test_refuses_a_joint_without_a_board() -> None:
    assert refusal(with_joints(joint("knee", 7, 0))) == "joint knee: no board at bus 1, address 7"


def test_refuses_an_unknown_board_type() -> None:
    ems = msgspec.structs.replace(DESCRIPTION.boards[0], type="ems5")

    text = refusal(msgspec.structs.replace(DESCRIPTION, boards=(ems, *DESCRIPTION.boards[1:])))
    assert text.startswith("unknown board type 'ems5'; known: bll, bll_dc, bll_ie, dc4, imu")


def test_refuses_two_joints_on_one_axis() -> None:
    assert refusal(with_joints(joint("a", 1, 0), joint("b", 1, 0))) == (
        "joints a and b share axis 0 of address 1 on bus 1"
    )


def test_refuses_two_joints_on_one_torque_channel() -> None:
    assert refusal(with_joints(compliant_joint("a", 1, 0, 2), compliant_joint("b", 1, 1, 2))) == (
        "joints a and b share torque channel 2 of address 12 on bus 1"
    )


def test_refuses_a_torque_channel_that_does_not_exist() -> None:
    source = TorqueSource(address=12, channel=6, full_scale_nm=8.0)

    assert refusal(with_joints(compliant_joint("a", 1, 0, 0, torque_source=source))) == (
        "joint a: torque channel 6 is not within 0..5"
    )


def test_refuses_a_gain_that_no_frame_can_carry() -> None:
    strong = msgspec.structs.replace(DESCRIPTION.joints[0].position_pid, kp=40000)

    assert refusal(with_joints(joint("a", 1, 0, position_pid=strong))) == (
        "joint a: SET_P_GAIN: kp = 40000 does not fit i16"
    )


def test_refuses_a_spring_that_no_frame_can_carry() -> None:
    weak = TorqueSource(address=12, channel=4, full_scale_nm=2.0)  # so its unit is fine

    assert refusal(with_joints(compliant_joint("a", 1, 0, 4, torque_source=weak))) == (
        "joint a: SET_IMPEDANCE_PARAMS: damping = 43211 does not fit i16"
    )


def test_refuses_masks_that_do_not_fit_the_addresses_of_a_board() -> None:
    forearm = msgspec.structs.replace(DESCRIPTION.boards[1], broadcast=(0x75,))
    boards = (DESCRIPTION.boards[0], forearm, DESCRIPTION.boards[2])

    assert refusal(msgspec.structs.replace(DESCRIPTION, boards=boards)) == (
        "board r_forearm: 1 broadcast masks; a dc4 needs 2"
    )


def test_refuses_a_current_that_the_board_would_not_take() -> None:
    assert refusal(with_joints(joint("a", 3, 0, current_limit_ma=1601))) == (
        "joint a: current_limit_ma 1601 is not within 1 and 1600, which is what its board takes"
    )


def test_refuses_masks_without_which_the_host_or_a_partner_board_is_blind() -> None:
    def with_mask(mask: int) -> RobotDescription:
        shoulder = msgspec.structs.replace(DESCRIPTION.boards[0], broadcast=(mask,))
        return msgspec.structs.replace(DESCRIPTION, boards=(shoulder, *DESCRIPTION.boards[1:]))

    assert (
        refusal(with_mask(0x72)) == "board r_shoulder: broadcast mask 0x72 lacks POSITION, STATUS"
    )
    assert refusal(with_mask(0x75)) == "board r_shoulder: broadcast mask 0x75 lacks PID_VAL"
