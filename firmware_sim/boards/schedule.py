"""When a motor board says what by itself: one slot after the other (can-protocol 3.2)."""

from firmware_sim.boards.axis_state import Axis
from firmware_sim.boards.broadcasts import (
    HEARTBEAT_MS,
    POSITION_SLOT,
    STATUS_SLOT,
    USED_SLOTS,
    broadcast,
    print_piece,
)
from firmware_sim.boards.fields import STATUS_KEY
from firmware_sim.boards.hardware import Firmware
from firmware_sim.boards.node import Node, Pair
from hal.wire.can import Frame
from hal.wire.motor_periodic import STATUS

Addressed = tuple[tuple[Pair, tuple[Axis, Axis]], ...]
"""The addresses of a board, each with its two axes."""

_STATUS = STATUS.mask_bit


class Schedule:
    """The broadcasts of one board."""

    __slots__ = ("_addressed", "_hides_position", "_node", "_said", "_slots")

    def __init__(self, addressed: Addressed, slots: int, firmware: Firmware, node: Node) -> None:
        """The schedule repeats after `slots` milliseconds."""
        self._addressed = addressed
        self._slots = slots
        self._hides_position = firmware.position_needs_encoders
        self._node = node
        self.boot()

    def boot(self) -> None:
        """Nothing said yet."""
        # By address: what led to no STATUS when it was looked at last.
        self._said: list[tuple[int, int] | None] = [None] * len(self._addressed)

    def broadcast(self, now_ms: int, sent: list[Frame]) -> None:
        """Append what is due in this millisecond."""
        addressed = self._addressed
        first_mask = addressed[0][0].mask
        if not first_mask:
            return  # mask 0 silences the second address too
        slot = now_ms % self._slots
        if slot == STATUS_SLOT:
            self._status(now_ms, sent)
        elif slot < USED_SLOTS and not (slot == POSITION_SLOT and self._is_blind()):
            for pair, axes in addressed:
                if pair.mask:
                    broadcast(pair, axes, slot, now_ms, sent)
        if self._node.printer.waiting:
            print_piece(self._node, first_mask, sent)

    def _status(self, now_ms: int, sent: list[Frame]) -> None:
        """STATUS of each address, left out while all that it could say led to none before."""
        for number, (pair, axes) in enumerate(self._addressed):
            if pair.mask & _STATUS:
                keys = axes[0].words[STATUS_KEY], axes[1].words[STATUS_KEY]
                new = keys != self._said[number] or pair.can_status or pair.board_status
                if new or now_ms - pair.heartbeat_ms >= HEARTBEAT_MS:
                    before = len(sent)
                    broadcast(pair, axes, STATUS_SLOT, now_ms, sent)
                    self._said[number] = keys if len(sent) == before else None

    def _is_blind(self) -> bool:
        return self._hides_position and any(
            axis.port.encoder_fault for _, axes in self._addressed for axis in axes
        )
