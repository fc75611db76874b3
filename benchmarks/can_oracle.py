"""What the protocol allows a motor board to do, judged from nothing but the frames it was given.

Written against the fact sheet (can-protocol 1, 2, 8, 10.2), not against the boards' code.
"""

from collections.abc import Sequence

from hal.wire import analog, management, motor
from hal.wire.can import (
    CLASS_ANALOG_POLLING,
    CLASS_MANAGEMENT,
    CLASS_MOTOR_POLLING,
    EVERYBODY,
    HOST,
    class_of,
    low_of,
    source_of,
)

HANDSHAKE = 0x5B
SET_MODE = 0x09
CALIBRATE = 0x04
BOOT_LOADER = b"\x00"
NOT_RUNNING = (0x00, 0x09)  # idle, force idle
EVERY_FLAG = 0x7F
FLAGS = {0x1E: 0x01, 0x20: 0x02, 0x22: 0x04, 0x28: 0x08, 0x26: 0x10, 0x24: 0x20, 0x2A: 0x40}
"""Flag that a single gain sets, by command (can-protocol 2.3)."""
FLAG_GROUPS = {0x52: 0x4F, 0x54: 0x30}
TOGETHER = {0x52: (0, 1), 0x62: (0, 1), 0x63: (0, 1), 0x19: (1, 2), 0x15: (2, 3)}
"""Axes that are enabled together, by the minor firmware number (can-protocol 10.2)."""
QUEUE_MS = 31  # a full receive buffer, one frame each millisecond

_SINGLES = (0, 3, 4, *range(7, 17), 18, 19, 29, 50, 51, 52, 60, 114, 115, 116, 117, 118, 120)
_RANGES = ((20, 49), (55, 59), (61, 70), (72, 77), (78, 101))
HANDLED = frozenset(_SINGLES).union(*(range(*ends) for ends in _RANGES))
"""Commands that a DSP board acts upon (can-protocol 2.1)."""
DC4_ONLY = 29


class GateOracle:
    """One motor board's gate: handshake, seven gains for each axis, a mode command."""

    def __init__(self, axes: int, minor: int) -> None:
        self._axes = axes
        self._together = TOGETHER.get(minor, ())
        self.boot()

    def boot(self) -> None:
        """Nothing has been given."""
        self.ms = 0
        self.acknowledged = False
        self.flags = [0] * self._axes
        self._wanted_ms = [-QUEUE_MS - 1] * self._axes

    def hear(self, addresses: Sequence[int], can_id: int, data: bytes) -> None:
        """One frame on the bus, in millisecond `ms`."""
        kind, low = class_of(can_id), low_of(can_id)
        if kind == CLASS_MANAGEMENT:
            for_us = source_of(can_id) == HOST and low in (addresses[0], EVERYBODY)
            if for_us and data[:1] == BOOT_LOADER:
                ms = self.ms
                self.boot()
                self.ms = ms
        elif kind == CLASS_MOTOR_POLLING and low in addresses and data:
            self._command(2 * (low - addresses[0]) + (data[0] >> 7), data[0] & 0x7F, data)

    def may_start(self, axis: int) -> bool:
        """Whether an axis may begin to run now."""
        recent = self.ms - self._wanted_ms[axis] <= QUEUE_MS
        return recent and self.may_run(axis)

    def may_run(self, axis: int) -> bool:
        """Whether an axis may go on."""
        return self.acknowledged and self.flags[axis] == EVERY_FLAG

    def _command(self, axis: int, code: int, data: bytes) -> None:
        if code == HANDSHAKE:
            if len(data) == 3 and data[1] == 1 and data[2] <= 6:
                self.acknowledged = True
        elif code in FLAGS:
            self.flags[axis] |= FLAGS[code] if len(data) == 3 else 0
        elif code in FLAG_GROUPS:
            self.flags[axis] |= FLAG_GROUPS[code] if len(data) == 8 else 0
        elif code == CALIBRATE or (
            code == SET_MODE and len(data) == 2 and data[1] not in NOT_RUNNING
        ):
            group = self._together if axis in self._together else (axis,)
            for one in group:
                self._wanted_ms[one] = self.ms


def is_useless(addresses: Sequence[int], can_id: int, data: bytes) -> bool:
    """True for a command to a motor board that it cannot act upon, in whatever state it is."""
    kind, low = class_of(can_id), low_of(can_id)
    if kind == CLASS_MANAGEMENT and source_of(can_id) == HOST:
        known = bool(data) and data[0] in management.COMMANDS
        return low in (addresses[0], EVERYBODY) and not known
    if kind != CLASS_MOTOR_POLLING or low not in addresses:
        return False
    if not data:
        return True
    code = data[0] & 0x7F
    if code not in HANDLED or (code == DC4_ONLY and len(addresses) == 1):
        return True
    return motor.COMMANDS[code].parse_request(data) is None


def is_useless_to_sensor(address: int, can_id: int, data: bytes) -> bool:
    """The same for a sensor board: no command at all, or one that no such board knows."""
    kind, low = class_of(can_id), low_of(can_id)
    if kind == CLASS_MANAGEMENT and source_of(can_id) == HOST:
        known = bool(data) and data[0] in management.COMMANDS
        return low in (address, EVERYBODY) and not known
    if kind != CLASS_ANALOG_POLLING or low != address:
        return False
    return not data or data[0] not in analog.COMMANDS
