"""The skin behind an MTB: its set-up and the two frames of each triangle (can-protocol 7.3).

A pair is packed again only when its taxels have changed: 18 boards send 800 frames a second each.
"""

from typing import Protocol

from hal.wire import skin
from hal.wire.can import CLASS_ANALOG_PERIODIC, Frame
from hal.wire.skin import TAXELS, TRIANGLES, TriangleError

REST = 240  # input of a taxel that nobody touches
TOP = 255
ERRORS_TO_RECALIBRATE = 5
PAUSE_PERIODS = 2  # a calibration lets so many periods pass
_ENABLED = 1
_UNKNOWN: list[int] = []


class Inputs(Protocol):
    """What is behind a skin board."""

    taxels: list[int]  # 192, REST when untouched, less under pressure
    triangle_errors: list[int]  # 16, see TriangleError


class SkinPatch:
    """Up to 16 triangles.

    A taxel is sent as the input minus its level at the last calibration plus the no-load level that
    the host has set; what leaves 0 to 255 is cut and marked in the out-of-range mask.
    """

    def __init__(self, address: int, inputs: Inputs) -> None:
        self.recalibrations = 0
        self._inputs = inputs
        self._address = address
        self.boot()

    def boot(self) -> None:
        """All triangles enabled, old style, calibrated at rest."""
        self.can_class = CLASS_ANALOG_PERIODIC
        self.no_load = skin.DEFAULT_NO_LOAD
        self.enabled = [True] * TRIANGLES
        self.shift = [0] * TRIANGLES
        self.cdc_offset = [skin.DEFAULT_CDC_OFFSET] * TRIANGLES
        self._level = [REST] * skin.BOARD_TAXELS
        self._failures = [0] * TRIANGLES
        self._forget()

    def set_up(self, can_class: int, no_load: int) -> None:
        """Take a board set-up; `can_class` is the class of the frames from now on."""
        self.can_class = can_class
        self.no_load = no_load
        self._forget()

    def set_triangles(self, first: int, last: int, shift: int, flags: int, cdc_offset: int) -> None:
        """Take the set-up of a range of triangles; those beyond the sixteenth do not exist."""
        for triangle in range(first, min(last + 1, TRIANGLES)):
            self.enabled[triangle] = bool(flags & _ENABLED)
            self.shift[triangle] = shift
            self.cdc_offset[triangle] = cdc_offset

    def set_old_triangles(self, mask: int, shift: int) -> None:
        """Take the set-up of all triangles in the old style, one bit each."""
        self.enabled = [bool(mask >> triangle & 1) for triangle in range(TRIANGLES)]
        self.shift = [shift] * TRIANGLES

    def recalibrate(self) -> None:
        """What the taxels show now is no load."""
        self.recalibrations += 1
        self._level = list(self._inputs.taxels)
        self._failures = [0] * TRIANGLES
        self._forget()

    def pair(self, triangle: int) -> tuple[Frame, ...]:
        """Head and tail of a triangle as it is now, nothing when it is disabled."""
        if not self.enabled[triangle]:
            return ()
        first = triangle * TAXELS
        taxels = self._inputs.taxels[first : first + TAXELS]
        error = self._inputs.triangle_errors[triangle]
        if error != self._sent_error[triangle] or taxels != self._sent[triangle]:
            if error:  # nothing was read: the previous values go out again
                taxels = self._sent[triangle] or taxels
            self._pairs[triangle] = self._packed(triangle, taxels, error)
            self._sent[triangle] = taxels if not error else self._sent[triangle]
            self._sent_error[triangle] = error
        return self._pairs[triangle]

    def must_recalibrate(self, triangle: int) -> bool:
        """Count a reading; true when a connected triangle could not be read five times running."""
        if self._inputs.triangle_errors[triangle] != TriangleError.NO_ANSWER:
            self._failures[triangle] = 0
            return False
        self._failures[triangle] += 1
        return self._failures[triangle] >= ERRORS_TO_RECALIBRATE

    def _forget(self) -> None:
        self._sent: list[list[int]] = [_UNKNOWN] * TRIANGLES
        self._sent_error = [-1] * TRIANGLES
        self._pairs: list[tuple[Frame, ...]] = [()] * TRIANGLES

    def _packed(self, triangle: int, taxels: list[int], error: int) -> tuple[Frame, ...]:
        first = triangle * TAXELS
        levels = self._level[first : first + TAXELS]
        values = []
        mask = 0
        for index, (taxel, level) in enumerate(zip(taxels, levels, strict=True)):
            value = taxel - level + self.no_load
            if not 0 <= value <= TOP:
                mask |= 1 << index
                value = min(max(value, 0), TOP)
            values.append(value)
        state = skin.tail_state(mask, error)
        head, tail = values[: skin.HEAD_TAXELS], values[skin.HEAD_TAXELS :]
        return (
            skin.HEAD.frame(self._address, triangle, *head, can_class=self.can_class),
            skin.TAIL.frame(self._address, triangle, *tail, *state, can_class=self.can_class),
        )
