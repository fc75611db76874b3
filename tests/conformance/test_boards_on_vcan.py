"""Every board type behind a real SocketCAN interface: scan, start-up, configuration, plugging.

Asserts what happens, not how fast: the kernel that this runs on may have one slow core.
"""

from collections.abc import Callable, Iterator

import pytest

from hal.buses.socketcan import interfaces_up
from hal.scan import Found, Scanner
from hal.stocktaking import differences
from services.config import load_robot
from services.robotfile.wiring import robot_description
from tests.services.mixed import Mixed

INTERFACES = tuple(bus.channel for bus in load_robot("icub").buses.values())
PARTS = ("head", "right_arm", "right_hand", "torso_skin")
"""Between them every board type of the robot: bll_dc, bll_ie, dc4, imu, strain, mais, mtb."""
BACK = ("restarted", "needs calibration")

pytestmark = [
    pytest.mark.live,
    pytest.mark.skipif(
        not interfaces_up(INTERFACES), reason=f"{', '.join(INTERFACES)} are not up on this kernel"
    ),
]

Maker = Callable[[str], Mixed]


@pytest.fixture
def on_vcan() -> Iterator[Maker]:
    """Makes a robot on the interfaces, and closes it in the end."""
    made: list[Mixed] = []

    def make(reference: str) -> Mixed:
        made.append(Mixed(load_robot(reference), on_vcan=True))
        return made[-1]

    yield make
    for robot in made:
        robot.close()


def scanned(robot: Mixed) -> dict[int, tuple[Found, ...]]:
    """Every bus of the robot, one after the other."""
    found: dict[int, tuple[Found, ...]] = {}
    for number, bus in robot.hal_buses.items():
        scan = Scanner(bus, robot.clock.now_ns).scan()
        while number not in found:
            robot.tick_boards()
            try:
                next(scan)
            except StopIteration as end:
                found[number] = end.value
    return found


@pytest.mark.parametrize("part", PARTS)
def test_a_scan_finds_what_the_robot_file_says(on_vcan: Maker, part: str) -> None:
    robot = on_vcan(f"icub:{part}")
    found = scanned(robot)
    assert differences(found, robot_description(robot.file)) == ()
    assert sum(len(boards) for boards in found.values()) >= len(robot.file.boards)


@pytest.mark.parametrize("part", PARTS)
def test_every_board_is_configured_and_streams_without_a_loss(on_vcan: Maker, part: str) -> None:
    robot = on_vcan(f"icub:{part}")
    robot.open()
    robot.tick(300)
    status = robot.hal.status()
    assert {board.state for board in status.boards} <= {"ok", "needs calibration"}
    assert (status.frames_lost, status.drops, status.faults) == (0, (), ())
    heard_ns = robot.hal.joints.heard_ns
    assert all(robot.now_ns - stamp_ns < 100_000_000 for stamp_ns in heard_ns)


def test_a_board_is_plugged_pulled_and_plugged_back(on_vcan: Maker) -> None:
    arm = on_vcan("icub:right_arm@bench")
    arm.open()
    assert arm.report("r_shoulder").state == "missing"
    for _ in range(2):
        arm.plug("right_arm", 1)
        arm.until(
            lambda: arm.report("r_shoulder").state in ("restarted", "needs calibration"), 5000
        )
        arm.ask("calibrate", ("r_shoulder_pitch",))
        arm.pull()
        arm.until(lambda: arm.report("r_shoulder").state == "silent", 1000)
    assert arm.report("r_elbow").state == "needs calibration"
    assert arm.hal.status().frames_lost == 0
