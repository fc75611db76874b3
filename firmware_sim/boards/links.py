"""Other boards whose frames a motor board needs: a shoulder's partner, a hand's MAIS."""

from firmware_sim.boards.axis_state import Axis
from firmware_sim.boards.fields import (
    PARTNER_DUTY_0,
    PARTNER_DUTY_1,
    PARTNER_POSITION_0,
    PARTNER_POSITION_1,
    PARTNER_SILENT,
    WATCHES_PARTNER,
)
from firmware_sim.boards.hall import HallLink
from firmware_sim.boards.hardware import PartnerSpec
from firmware_sim.boards.partner import PartnerLink


class Links:
    """What a board knows of other boards, for its row in the bank."""

    __slots__ = ("_axes", "any", "hall", "partner")

    def __init__(self, partner: PartnerSpec | None, axes: tuple[Axis, ...]) -> None:
        self._axes = axes
        has_hall = any(axis.wiring.hall for axis in axes)
        self.partner = None if partner is None else PartnerLink(partner)
        self.hall = HallLink(axes) if has_hall else None
        self.any = self.partner is not None or self.hall is not None

    def attach(self, axes: tuple[Axis, ...]) -> None:
        """Mark the axes that may not move without the partner."""
        if self.partner is not None:
            for number in self.partner.axes:
                axes[number].words[WATCHES_PARTNER] = 1

    def boot(self) -> None:
        """Nothing heard yet."""
        if self.partner is not None:
            self.partner.boot()
        if self.hall is not None:
            self.hall.boot()

    def accepts(self, can_id: int) -> bool:
        """True for a partner's frames; those of a MAIS come in with the rest of their class."""
        return self.partner is not None and self.partner.accepts(can_id)

    def on_frame(self, can_id: int, data: bytes) -> bool | None:
        """Take a frame in; False when its length is wrong, None when it is another's."""
        if self.hall is not None:
            taken = self.hall.on_frame(can_id, data)
            if taken is not None:
                return taken
        if self.partner is not None and self.partner.accepts(can_id):
            return self.partner.on_frame(can_id, data)
        return None

    def advance(self, words: memoryview) -> None:
        """One millisecond; what the partner does now goes to the board's words."""
        if self.hall is not None:
            self._watch_hall(self.hall)
        if self.partner is not None:
            self.partner.advance()
            words[PARTNER_SILENT] = self.partner.silent
            words[PARTNER_DUTY_0], words[PARTNER_DUTY_1] = self.partner.duties
            words[PARTNER_POSITION_0], words[PARTNER_POSITION_1] = self.partner.positions

    def _watch_hall(self, hall: HallLink) -> None:
        hall.advance()
        if hall.silent:
            running = [axis for axis in self._axes if axis.enabled]
            for axis in running:
                axis.fault()
            if running:
                running[0].node.printer.say(f"MAIS error {hall.silent_ms}")
