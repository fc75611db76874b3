"""The HAL against emulated boards that fail, lose power or are spoken to by somebody else."""

import pytest

from hal.wire.modes import ControlMode
from tests.hal.arm import BUS
from tests.hal.emulated import Bench

DIRECT = int(ControlMode.DIRECT)


def test_late_torques_make_the_limb_stiff_before_the_boards_fault(ready: Bench) -> None:
    ready.compliant("pitch", "roll")
    ready.fed = False
    ready.tick(400)

    assert [axis.compliant for axis in ready.axes] == [False] * 4
    assert sum(axis.fault_entries for axis in ready.axes) == 0
    assert ready.robot.status().faults == ("torques 0.061 s old: pitch, roll made stiff",)
    assert ready.robot.joints.control_mode[:2] == [DIRECT, DIRECT]


def test_the_boards_fault_when_the_whole_bus_is_lost(ready: Bench) -> None:
    ready.compliant("roll")
    ready.memory.faults("arm").bus_off = True
    ready.tick(300)

    assert ready.axes[1].mode == ControlMode.HW_FAULT
    faults = ready.robot.status().faults
    assert "bus 1 is off: no frame gets through" in faults
    assert any(fault.startswith("board r_shoulder") and "silent" in fault for fault in faults)


def test_names_the_cause_of_a_hardware_fault(ready: Bench) -> None:
    ready.axes[1].port.encoder_fault = True
    ready.tick(20)

    status = ready.robot.status()
    assert "roll in hardware fault: absolute encoder read error" in status.faults
    assert ready.robot.joints.fault[1] == "hardware fault: absolute encoder read error"


def test_leaves_a_hardware_fault_on_request(ready: Bench) -> None:
    ready.axes[1].port.encoder_fault = True
    ready.tick(20)
    ready.axes[1].port.encoder_fault = False
    ready.tick(20)

    ready.finish(ready.robot.request("mode", ["roll"], "idle"))
    task = ready.robot.request("mode", ["roll"], "position")
    ready.finish(task)

    assert task.ok
    assert ready.axes[1].mode == ControlMode.POSITION


def test_calibrates_out_of_a_hardware_fault(ready: Bench) -> None:
    ready.axes[1].port.encoder_fault = True
    ready.tick(20)
    ready.axes[1].port.encoder_fault = False
    task = ready.robot.request("calibrate", ["roll"])
    ready.finish(task)

    assert task.ok, task.reason
    assert ready.axes[1].mode == ControlMode.POSITION


@pytest.mark.parametrize("slot", range(5))
def test_explains_the_emergency_button(ready: Bench, slot: int) -> None:
    # The board enters the mode for one millisecond, and one slot reports just that.
    for axis in ready.axes:
        axis.port.external_fault = True
    ready.tick(20 + slot)
    task = ready.robot.request("mode", ["roll"], "position")
    ready.finish(task)

    assert task.reason == "roll did not enter position mode: emergency button pressed"
    assert "board r_shoulder (bus 1, address 1): emergency button pressed" in (
        ready.robot.status().faults
    )


def test_does_not_calibrate_while_the_emergency_button_is_pressed(ready: Bench) -> None:
    for axis in ready.axes:
        axis.port.external_fault = True
    task = ready.robot.request("calibrate", ["pitch", "roll"], "again")
    ready.finish(task, limit_ms=400)

    assert "pitch not calibrated: emergency button pressed" in task.reason
    assert ready.robot.joints.calibrated[:2] == [False, False]


def test_a_board_that_loses_power_is_named_and_configured_again(ready: Bench) -> None:
    board = ready.boards.board(BUS, 1)
    board.powered = False
    ready.tick(300)
    (fault,) = ready.robot.status().faults
    assert fault.startswith("board r_shoulder (bus 1, address 1) silent for 0.09")
    board.power_cycle()
    ready.tick(2500)

    assert "has restarted; it is configured again" in ready.robot.status().faults[-1]
    assert ready.robot.joints.calibrated == [False, False, True, True]
    task = ready.robot.request("calibrate", ["pitch", "roll"])
    ready.finish(task)
    assert task.ok


def test_settings_changed_by_another_host_are_written_again(ready: Bench) -> None:
    intruder = ready.buses[2]
    intruder.send_frames([(0x001, bytes.fromhex("C200100000"))])  # roll: max position 4096
    ready.tick(3)
    assert ready.axes[1].reference.high == 4096
    ready.tick(80)

    assert ready.axes[1].reference.high == 2252
    assert "SET_MAX_POSITION axis 1" in ready.robot.status().faults[-1]


def test_the_guard_makes_the_limb_stiff_when_the_host_hangs(ready: Bench) -> None:
    guard = ready.guard()
    ready.compliant("pitch", "roll")
    ready.running = False
    ready.tick(60)
    task = guard.make_stiff(ready.now_ns)
    for _ in range(10):
        ready.tick()
        guard.step(ready.now_ns)

    assert task.ok
    assert task.done
    assert [axis.compliant for axis in ready.axes] == [False] * 4
    ready.tick(300)
    assert sum(axis.fault_entries for axis in ready.axes) == 0


def test_the_guard_brings_the_limb_down(ready: Bench) -> None:
    ready.compliant("pitch", "roll")
    ready.running = False
    guard = ready.guard()
    task = guard.stop(ready.now_ns)
    for _ in range(3000):
        ready.tick()
        guard.step(ready.now_ns)
        if task.done:
            break

    assert task.ok, task.reason
    assert [axis.enabled for axis in ready.axes] == [False] * 4


def test_says_which_settings_are_missing_on_a_board(ready: Bench) -> None:
    ready.finish(ready.robot.request("mode", ["roll"], "idle"))
    ready.axes[1].pid_flags = 0x3F
    task = ready.robot.request("mode", ["roll"], "position")
    ready.finish(task)

    assert task.reason == (
        'roll went into hardware fault: its board says "PIDs not received 0x3F, axis 1"'
    )


def test_says_that_a_board_has_not_taken_the_protocol(ready: Bench) -> None:
    ready.finish(ready.robot.request("mode", ["roll"], "idle"))
    ready.axes[1].node.accepted = False
    task = ready.robot.request("mode", ["roll"], "position")
    ready.finish(task)

    assert task.reason.endswith('its board says "protocol not acknowledged, axis 1"')
