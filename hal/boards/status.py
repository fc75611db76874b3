"""STATUS frames: control modes, and faults as text with their evidence."""

from collections.abc import Sequence
from functools import partial

from hal.axis import POWERED, Axis
from hal.boards.board import Parts, board_name
from hal.line import Trace
from hal.wire.modes import ControlMode
from hal.wire.motor_periodic import (
    STATUS,
    AxisFault,
    BoardStatus,
    CanStatus,
    axis_fault_text,
    board_status_text,
    can_status_text,
)

# Bits are the state of one cycle; those that say why an axis is in fault must outlast it.
NOT_A_CAUSE = AxisFault.EXTERNAL  # the button leads to idle, and its bit to nothing but itself
SAID_RECENTLY_NS = 500_000_000
HEAT = (BoardStatus.OVERTEMPERATURE_0, BoardStatus.OVERTEMPERATURE_1)
SILENT_CAUSES = "no fault bit: torque source or coupled board silent, bus-off, or refused to enable"


class StatusReader:
    """Reads the STATUS frames of one address."""

    __slots__ = ("_addresses", "_axes", "_causes", "_faults", "_line", "_name", "_trace")

    def __init__(self, parts: Parts, axes: Sequence[Axis | None], trace: Trace) -> None:
        self._axes = tuple(axes)
        self._faults = parts.faults
        self._line = parts.line
        self._name = board_name(parts.board)
        self._trace = trace
        self._addresses = tuple({axis.address for axis in parts.axes})
        self._causes = [""] * len(self._axes)  # in the bytes about the board, why it is in fault
        for number, axis in enumerate(self._axes):
            if axis is not None:
                axis.suspects.append(partial(self._own_cause, number))

    def on_status(self, data: bytes, stamp_ns: int) -> None:
        """STATUS: sent on a change, each 4 or 5 ms during an emergency stop, and each 5 s."""
        values = STATUS.parse(data)
        if values is None:
            self._faults.drop("STATUS of wrong length")
            return
        both = list(zip(self._axes, values[0:4:2], values[1:4:2], strict=True))
        for axis, bits, mode in both:
            if axis is not None:
                self._on_fault_bits(axis, bits, mode, stamp_ns)
        for number, mode in enumerate(values[1:4:2]):
            cause = _board_cause(values[4], values[5] & HEAT[number])
            if mode != ControlMode.HW_FAULT:
                self._causes[number] = ""
            elif cause:
                self._causes[number] = cause
        # The axis that faulted first: it is the reason why its coupled partner is idle.
        for axis, _, mode in sorted(both, key=_runs):
            if axis is not None:
                self.on_mode(axis, mode, stamp_ns)
        if any(values[4:]):
            self._on_trouble(values[4], values[5], values[6:8], stamp_ns)

    def _own_cause(self, number: int, now_ns: int) -> str:  # noqa: ARG002  (a suspect)
        return self._causes[number]

    def _on_trouble(
        self, can_bits: int, board_bits: int, errors: Sequence[int], stamp_ns: int
    ) -> None:
        """CAN status, board status, and the error flags that only the 5-second copy has."""
        self._line.errors += bool(can_bits or any(errors))
        directions = [
            way for way, flag in zip(("transmit", "receive"), errors, strict=True) if flag
        ]
        flags = f"CAN {' and '.join(directions)} errors since its last report" if directions else ""
        for text in (can_status_text(can_bits), board_status_text(board_bits), flags):
            if text:
                self._faults.report(stamp_ns, f"{self._name}: {text}", f"{self._name} {text}")

    def on_mode(self, axis: Axis, mode: int, stamp_ns: int) -> None:
        """The board says which mode an axis is in; a change nobody asked for is a fault."""
        before = axis.mode
        axis.on_mode(mode)
        axis.set_fault_text(_present_fault(axis))
        if mode == before:
            return
        for partner in axis.partners:
            partner.set_fault_text(_present_fault(partner))
        if mode == ControlMode.HW_FAULT:
            text = f"{axis.name} in hardware fault: {fault_cause(axis)}{_dragged(axis)}"
            evidence = self._line.evidence(self._trace, self._addresses)
            self._faults.report(stamp_ns, text, frames=evidence)
        elif mode == ControlMode.IDLE and axis.wanted_mode in POWERED:
            text = f"{axis.name} went idle by itself"
            cause = axis_fault_text(axis.fault_bits)
            faulted = _faulted_partner(axis)
            if faulted and not cause:
                text, cause = f"{axis.name} is idle", f"its coupled partner {faulted} faulted"
            text += f": {cause}" if cause else ""
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


def _board_cause(can_bits: int, heat: int) -> str:
    """What faults every axis, or one of them, without a bit in the axis's own byte."""
    texts = (can_status_text(can_bits & CanStatus.BUS_OFF), board_status_text(heat))
    return "; ".join(text for text in texts if text)


def _runs(entry: tuple[Axis | None, int, int]) -> bool:
    return entry[2] != ControlMode.HW_FAULT


def fault_cause(axis: Axis) -> str:
    """Why an axis is in hardware fault, as far as its STATUS frames and the other boards tell."""
    if axis.fault_bits:
        return axis_fault_text(axis.fault_bits)
    now_ns = axis.line.now_ns
    causes = [suspect(now_ns) for suspect in axis.suspects]
    if axis.said and now_ns - axis.said_ns < SAID_RECENTLY_NS:
        causes.append(f'its board says "{axis.said}"')
    return "; ".join(cause for cause in causes if cause) or SILENT_CAUSES


def _faulted_partner(axis: Axis) -> str:
    """The coupled axis in whose fault this one is switched off too, empty when there is none."""
    faulted = [p.name for p in axis.partners if p.mode == ControlMode.HW_FAULT]
    return faulted[0] if faulted else ""


def _dragged(axis: Axis) -> str:
    """Which coupled axes a fault switches off."""
    names = [p.name for p in axis.partners if p.wanted_mode in POWERED]
    return f"; {', '.join(names)} coupled with it goes idle" if names else ""


def _present_fault(axis: Axis) -> str:
    if axis.mode == ControlMode.HW_FAULT:
        return f"hardware fault: {fault_cause(axis)}"
    faulted = _faulted_partner(axis)
    if faulted and axis.mode == ControlMode.IDLE:
        return f"idle because its coupled partner {faulted} faulted"
    return axis_fault_text(axis.fault_bits)
