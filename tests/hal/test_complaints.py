"""What users of the real robot complained about, and what its driver gets wrong (can-protocol 13).

docs/complaints.md has the whole table; here stand the symptoms that no other test is about.
"""

import ast
import math
import re
from pathlib import Path

import pytest
from msgspec.structs import replace

from hal.boards.bll import Bll
from hal.boards.bll_ie import BllIe
from hal.robot import Robot
from hal.wire.modes import ControlMode
from hal.wire.motor import SET_TORQUE_PID
from tests.hal.arm import BUS, DESCRIPTION, PITCH, ROLL
from tests.hal.emulated import EMULATED, Bench
from tests.hal.scripted import MS, Script, frame

ROOT = Path(__file__).parents[2]
TABLE = ROOT / "docs" / "complaints.md"


@pytest.fixture
def script() -> Script:
    script = Script()
    script.ready()
    return script


def test_every_test_of_the_table_exists() -> None:
    named = set(re.findall(r"`(test_\w+)`", TABLE.read_text(encoding="utf-8")))
    defined = {
        node.name
        for path in (ROOT / "tests").rglob("test_*.py")
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8")))
        if isinstance(node, ast.FunctionDef)
    }

    assert len(named) > 30
    assert named - defined == set()


def test_messages_time_out_when_a_board_loses_power(ready: Bench) -> None:
    """The board is named by its periodic frames, before any request could time out."""
    ready.boards.board(BUS, 3).powered = False
    ready.tick(100)

    (fault,) = ready.robot.status().faults
    assert fault.startswith("board r_forearm (bus 1, address 3) silent for 0.09")


def test_the_robot_does_not_move_and_the_driver_says_time_out(ready: Bench) -> None:
    """Each of the reasons is told as itself."""
    robot, axis = ready.robot, ready.axes[ROLL]
    ready.finish(robot.request("mode", ["roll"], "idle"))
    axis.port.external_fault = True
    ready.tick(20)
    pressed = robot.request("mode", ["roll"], "position")
    ready.finish(pressed)
    assert pressed.reason.endswith("emergency button pressed")
    axis.port.external_fault = False
    ready.tick(20)

    robot.joints.calibrated[ROLL] = False
    assert robot.request("mode", ["roll"], "position").reason == "roll is not calibrated"


def test_a_hardware_fault_is_told_when_a_mode_is_asked_for(ready: Bench) -> None:
    ready.axes[ROLL].port.encoder_fault = True
    ready.tick(20)

    task = ready.robot.request("mode", ["roll"], "direct")
    assert task.reason == (
        "roll is in hardware fault (absolute encoder read error): request mode idle first"
    )


def test_board_not_heard_since_12_seconds_and_no_counters_to_look_at(script: Script) -> None:
    """Every bus has them, also those that carry sensors only."""
    (bus,) = script.robot.status().buses

    assert (bus.number, bus.state, bus.frames_lost, bus.errors) == (BUS, "active", 0, 0)
    assert bus.frames_received > bus.frames_sent > 0


def test_firmware_version_read_as_minus_one() -> None:
    """No answer is no version, and the board is asked again."""
    script = Script()
    answer = script.bus.answers.pop(frame("001 5B0106"))
    script.tick(250)
    assert script.robot.status().boards[0].found_firmware is None
    script.bus.answers[frame("001 5B0106")] = answer
    script.open()

    assert script.robot.status().boards[0].found_firmware == (2, 0x50)


def test_relaunch_fails_because_an_ft_keeps_streaming(ready: Bench) -> None:
    """A second start, while everything of the first one still runs."""
    for _ in range(3):
        ready.robot = Robot(EMULATED, {BUS: ready.buses[1]})
        ready.open()
        assert ready.robot.phase == "idle"
        assert ready.robot.status().faults == ()
    ready.tick(10)
    assert len(ready.robot.take_samples("r_arm_ft")) >= 10


def test_receive_buffer_overrun_ends_the_robot_interface(script: Script) -> None:
    """A flood is read, counted and forgotten; the newest samples are kept."""
    script.bus.inbox += [frame("3DA 008000800080"), frame("3DB 008000800080")] * 5000
    script.bus.inbox += [frame("1F9 00")] * 5000
    script.tick()

    assert len(script.robot.take_samples("r_arm_ft")) == 256
    assert script.robot.status().frames_dropped == 5000
    script.tick(10)
    assert script.robot.is_fresh(PITCH, script.now_ns)


@pytest.mark.parametrize(
    ("mode", "setter"),
    [
        (ControlMode.DIRECT, "set_positions"),
        (ControlMode.VELOCITY, "set_velocities"),
        (ControlMode.TORQUE, "set_torques"),
        (ControlMode.OPENLOOP, "set_duties"),
    ],
)
def test_direct_references_are_not_implemented(
    script: Script, mode: ControlMode, setter: str
) -> None:
    """Every control mode has one set-point, and takes no other."""
    script.status(0x113, ControlMode.POSITION, mode)
    script.tick()

    taken = {
        name: getattr(script.robot, name)([ROLL], [0.0])
        for name in ("set_positions", "set_velocities", "set_torques", "set_duties")
    }
    assert [name for name, accepted in taken.items() if accepted] == [setter]


def test_the_pwm_scale_is_missing_in_the_configuration() -> None:
    """It cannot be: it belongs to the type of the board."""
    assert (Bll.full_pwm, BllIe.full_pwm) == (1333, 800)


def test_identifiers_that_end_in_ff_are_never_let_in(script: Script) -> None:
    script.say("0FF 00", "1FF 00", "2FF 00", "3FF 00")
    script.tick()

    assert [cause for cause, _ in script.robot.status().drops] == [
        f"unexpected identifier 0x{can_id} on bus 1" for can_id in ("0FF", "1FF", "2FF", "3FF")
    ]


def test_fault_byte_and_control_mode_are_mixed(script: Script) -> None:
    """A running axis without a fault bit has no fault."""
    script.say("113 0008000200000000")
    script.tick()

    assert script.robot.joints.fault[:2] == ["", ""]
    assert script.robot.joints.control_mode[:2] == [ControlMode.DIRECT, ControlMode.VELOCITY]


def test_the_shift_of_the_torque_pid_is_written_beyond_the_payload() -> None:
    _, data = SET_TORQUE_PID.request(1, 0, -76, 0, 0, 14)

    assert data == bytes.fromhex("4EB4FF000000000E")


def test_the_result_of_earlier_joints_is_overwritten(script: Script) -> None:
    """A request for several joints tells the failure of each."""
    task = script.robot.request("mode", ["pitch", "roll"], "direct")
    script.status(0x113, 0xA0, 0x08, 0x08)
    script.finish(task)

    assert not task.ok
    assert task.reason.startswith("pitch went into hardware fault: over-current or I2T trip")


def test_max_velocity_and_torque_source_never_reach_the_board() -> None:
    script = Script()
    sent: list[str] = []
    while script.robot.phase != "idle":
        sent += script.tick()

    assert {"001 44AF00", "001 340C000000000000", "001 B40C010000000000"} <= set(sent)


def test_zero_before_the_first_frame_looks_like_data() -> None:
    robot = Script().robot

    assert all(math.isnan(q_rad) for q_rad in robot.joints.q_rad)
    assert not any(robot.is_fresh(joint, 0) for joint in range(4))
    assert robot.take_samples("r_arm_ft") == []


def test_status_flood_during_an_emergency_stop(script: Script) -> None:
    """One STATUS each 4 ms for a minute is one report."""
    script.status(0x113, 0, 0)
    script.tick()
    before = script.robot.status().fault_count
    for _ in range(15_000):
        script.say("113 0400040000000000")
        script.tick()

    assert script.robot.status().fault_count == before + 1


def test_the_pc_is_silent_and_the_robot_keeps_moving(ready: Bench) -> None:
    """The boards do not notice; a guard with a bus handle of its own brings the limb down."""
    guard = ready.guard()
    ready.running = False
    ready.tick(1000)
    assert all(axis.enabled for axis in ready.axes)
    task = guard.stop(ready.now_ns)
    for _ in range(3300):
        ready.tick()
        guard.step(ready.now_ns)

    assert task.ok, task.reason
    assert not any(axis.enabled for axis in ready.axes)


def test_a_mask_belongs_to_the_address_and_not_to_the_axis() -> None:
    """Both addresses of a 4DC get theirs, also where the robot uses one axis only."""
    script = Script(replace(DESCRIPTION, name="masks"))
    sent: list[str] = []
    while script.robot.phase != "idle":
        sent += script.tick()

    assert sent.count("003 4975000000") == sent.count("004 4975000000") == 1
    assert script.now_ns < 500 * MS
