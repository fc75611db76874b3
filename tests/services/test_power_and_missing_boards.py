"""No power without calibration, and a robot that starts without what it can do without."""

import pytest

from benchmarks.whole_robot import WholeRobot
from firmware_sim.boards.motor_board import MotorBoard
from hal.switching import MODES

POWERED_MODES = [mode for mode in MODES if mode != "idle"]


def bridges(robot: WholeRobot) -> list[bool]:
    boards = [
        board
        for spec in robot.hal.description.boards
        if isinstance(board := robot.rig.board(spec.bus, spec.address), MotorBoard)
    ]
    return [bool(axis.port.enabled) for board in boards for axis in board.axes]


@pytest.mark.parametrize("mode", POWERED_MODES)
def test_no_joint_gets_power_before_it_is_calibrated(mode: str) -> None:
    robot = WholeRobot("icub:head")
    robot.open()
    names = [joint.name for joint in robot.hal.description.joints]
    reasons = [robot.hal.request("mode", [name], mode).reason for name in names]
    robot.hal.request("move", names, q_rad=[0.0] * len(names))
    robot.hal.request("park", names, q_rad=[0.0] * len(names))
    seen = []
    for _ in range(300):
        robot.tick()
        seen += bridges(robot)
    robot.close()

    assert [reason.partition(";")[0] for reason in reasons] == [
        f"{name} is not calibrated" for name in names
    ]
    assert len(seen) == 300 * 6
    assert not any(seen)


def test_a_robot_without_its_head_imu_calibrates_and_moves() -> None:
    robot = WholeRobot("icub:head")
    robot.rig.board(0, 14).powered = False
    robot.calibrated()
    task = robot.hal.request("move", ["neck_yaw"], q_rad=[0.3])
    robot.finish(task)
    states = {board.name: board.state for board in robot.hal.status().boards}
    yaw_rad = robot.rig.q_rad[robot.rig.joints.index("neck_yaw")]
    robot.close()

    assert states == {"neck": "ok", "eyes": "ok", "head_imu": "missing"}
    assert yaw_rad == pytest.approx(0.3, abs=0.03)
