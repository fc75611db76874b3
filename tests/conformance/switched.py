"""A whole emulated robot with its HAL, watched while a fault is switched on and off."""

import math
from collections.abc import Iterable
from typing import NamedTuple

from benchmarks.whole_robot import WholeRobot
from firmware_sim.switch_table import FaultSpec
from hal.boards.board import HostBoard
from hal.wire.modes import ControlMode

MS = 1_000_000
STEP_RAD = 0.06
USUAL_MS = 300  # long enough to see every board's slowest gap


class Report(NamedTuple):
    """One report of the HAL, milliseconds after the switch was thrown."""

    ms: float
    text: str
    frames: tuple[str, ...]


class Switched:
    """Asserts, whatever happens, that boards and joints that are not concerned go on as before."""

    def __init__(self, reference: str, *, calibrate: bool) -> None:
        self.robot = WholeRobot(reference)
        self.hal = self.robot.hal
        if calibrate:
            self.robot.calibrated()
        else:
            self.robot.open()
            self.robot.tick(USUAL_MS)
        self.names = self.hal.joints.names
        self._boards = self.hal._machine.boards
        self._usual_ns = {board.board.name: 0 for board in self._boards}
        for _ in range(USUAL_MS):
            self.robot.tick()
            for board in self._boards:
                self._usual_ns[board.board.name] = max(
                    self._usual_ns[board.board.name], self._age_ns(board)
                )

    def on(self, spec: FaultSpec, ms: int, boards: set[str], joints: set[str]) -> list[Report]:
        """Switch on and watch; `boards` may fall silent, `joints` may change."""
        self.robot.rig.switches.switch_on(spec)
        return self.watch(ms, boards, joints)

    def off(self, spec: FaultSpec, ms: int, boards: set[str], joints: set[str]) -> list[Report]:
        """Switch off, unless it was over at once, and watch."""
        if self.robot.rig.switches.on:
            self.robot.rig.switches.switch_off(spec)
        return self.watch(ms, boards, joints)

    def watch(self, ms: int, boards: set[str], joints: set[str]) -> list[Report]:
        """Pass time; what is reported meanwhile."""
        count, began_ns = self.hal.status().fault_count, self.robot.now_ns
        modes, faults = list(self.hal.joints.control_mode), list(self.hal.joints.fault)
        others = [board for board in self._boards if board.board.name not in boards]
        for _ in range(ms):
            self.robot.tick()
            for board in others:
                assert self._age_ns(board) <= self._usual_ns[board.board.name], board.board.name
        for index, name in enumerate(self.names):
            if name not in joints:
                assert self.hal.joints.control_mode[index] == modes[index], name
                assert self.hal.joints.fault[index] == faults[index], name
        new = self.hal.status().fault_count - count
        events = self.hal.fault_events[-new:] if new else ()
        return [Report((e.stamp_ns - began_ns) / MS, e.text, e.frames) for e in events]

    def recover(self, joints: Iterable[str]) -> None:
        """What the user does: idle, calibrate what has to be, position mode."""
        named = tuple(joints)
        if not named:
            return
        self.ask("mode", named, "idle")
        lost = [name for name in named if not self.hal.joints.calibrated[self.names.index(name)]]
        if lost:
            self.ask("calibrate", lost)
        self.ask("mode", named, "position")

    def assert_well(self) -> None:
        """Every board sends, every axis is calibrated, holds its position and has no fault."""
        joints = self.hal.joints
        assert set(joints.fault) <= {""}
        assert all(joints.calibrated)
        assert set(joints.control_mode) <= {ControlMode.POSITION}
        assert [b.name for b in self.hal.status().boards if b.state not in ("ok",)] == []

    def assert_obeys(self, joints: Iterable[str]) -> None:
        """Joints go where they are sent, in truth."""
        named = tuple(joints)
        if not named:
            return
        before = [self.hal.joints.q_rad[self.names.index(name)] for name in named]
        targets = [self._inward(name) for name in named]
        self.ask("move", named, q_rad=targets, duration_s=0.4)
        self.robot.tick(200)
        truth = dict(zip(self.robot.rig.joints, self.robot.rig.q_rad, strict=True))
        for name, start, target in zip(named, before, targets, strict=True):
            assert abs(target - start) > STEP_RAD * 0.9, name
            assert abs(truth[name] - target) < STEP_RAD / 2, name

    def ask(
        self,
        action: str,
        joints: Iterable[str],
        value: str = "",
        q_rad: Iterable[float] = (),
        duration_s: float = 0.0,
    ) -> None:
        """Request something of the HAL; it must end well."""
        task = self.hal.request(action, tuple(joints), value, tuple(q_rad), duration_s)
        self.robot.finish(task)

    def close(self) -> None:
        self.robot.close()

    def _age_ns(self, board: HostBoard) -> int:
        return max((self.robot.now_ns - pulse.heard_ns for pulse in board.pulses), default=0)

    def _inward(self, name: str) -> float:
        """A step towards the middle of its range, from inside its limits."""
        index = self.names.index(name)
        joint = self.hal.description.joints[index]
        low, high = (math.radians(deg) for deg in (joint.min_deg, joint.max_deg))
        margin = math.radians(joint.margin_deg)
        at = min(max(self.hal.joints.q_rad[index], low + margin), high - margin)
        return at + math.copysign(STEP_RAD, (low + high) / 2.0 - at)
