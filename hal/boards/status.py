"""STATUS frames: control modes, and faults as text with their evidence."""

from collections.abc import Sequence

from hal.axis import POWERED, Axis
from hal.boards.board import Parts, board_name
from hal.line import Trace
from hal.wire.modes import ControlMode
from hal.wire.motor_periodic import (
    STATUS,
    AxisFault,
    axis_fault_text,
    board_status_text,
    can_status_text,
)

# Bits are the state of one cycle; those that say why an axis is in fault must outlast it.
NOT_A_CAUSE = AxisFault.EXTERNAL  # the button leads to idle, and its bit to nothing but itself
SILENT_CAUSES = "no fault bit: torque source or coupled board silent, bus-off, or refused to enable"


class StatusReader:
    """Reads the STATUS frames of one address."""

    __slots__ = ("_addresses", "_axes", "_faults", "_line", "_name", "_trace")

    def __init__(self, parts: Parts, axes: Sequence[Axis | None], trace: Trace) -> None:
        self._axes = tuple(axes)
        self._faults = parts.faults
        self._line = parts.line
        self._name = board_name(parts.board)
        self._trace = trace
        self._addresses = tuple({axis.address for axis in parts.axes})

    def on_status(self, data: bytes, stamp_ns: int) -> None:
        """STATUS: sent on a change, each 4 or 5 ms during an emergency stop, and each 5 s."""
        values = STATUS.parse(data)
        if values is None:
            self._faults.drop("STATUS of wrong length")
            return
        for axis, bits, mode in zip(self._axes, values[0:4:2], values[1:4:2], strict=True):
            if axis is not None:
                self._on_fault_bits(axis, bits, mode, stamp_ns)
                self.on_mode(axis, mode, stamp_ns)
        for text in (can_status_text(values[4]), board_status_text(values[5])):
            if text:
                self._faults.report(stamp_ns, f"{self._name}: {text}", f"{self._name} {text}")

    def on_mode(self, axis: Axis, mode: int, stamp_ns: int) -> None:
        """The board says which mode an axis is in; a change nobody asked for is a fault."""
        before = axis.mode
        axis.on_mode(mode)
        axis.set_fault_text(_present_fault(axis))
        if mode == before:
            return
        if mode == ControlMode.HW_FAULT:
            text = f"{axis.name} in hardware fault: {fault_cause(axis)}"
            evidence = self._line.evidence(self._trace, self._addresses)
            self._faults.report(stamp_ns, text, frames=evidence)
        elif mode == ControlMode.IDLE and axis.wanted_mode in POWERED:
            bits = axis_fault_text(axis.fault_bits)
            text = f"{axis.name} went idle by itself" + (f": {bits}" if bits else "")
            self._faults.report(stamp_ns, text, text)

    def _on_fault_bits(self, axis: Axis, bits: int, mode: int, stamp_ns: int) -> None:
        if mode == axis.mode == ControlMode.HW_FAULT:
            bits |= axis.fault_bits & ~NOT_A_CAUSE
        news = bits & ~axis.fault_bits
        axis.fault_bits = bits
        if news & AxisFault.EXTERNAL:
            text = f"{self._name}: emergency button pressed"
            self._faults.report(stamp_ns, text, text)
        text = axis_fault_text(news & ~AxisFault.EXTERNAL)
        if text:
            self._faults.report(stamp_ns, f"{axis.name}: {text}", f"{axis.name} {text}")


def fault_cause(axis: Axis) -> str:
    """Why an axis is in hardware fault, as far as its STATUS frames have told."""
    return axis_fault_text(axis.fault_bits) or SILENT_CAUSES


def _present_fault(axis: Axis) -> str:
    if axis.mode == ControlMode.HW_FAULT:
        return f"hardware fault: {fault_cause(axis)}"
    return axis_fault_text(axis.fault_bits)
