"""The boot loader of a board, as far as its handshake (can-protocol 8).

DELIBERATE: the lines of a download are acknowledged and thrown away; the application that starts
afterwards is the one that was there. The board does not pass through the boot loader at power-up.
"""

from collections import Counter

from hal.wire import management
from hal.wire.can import CLASS_MANAGEMENT, Frame
from hal.wire.management import BoardType

PATIENCE_MS = 5000  # without a second BOARD the application starts again
DSP_VERSION = (2, 0)  # of the DSP boards' boot loader; the sheet shows none


class Loader:
    """Runs instead of the application between BOARD and END, or until its patience ends."""

    __slots__ = ("_address", "_identity", "_left_ms", "_line_bytes", "is_running")

    def __init__(
        self,
        address: int,
        board_type: int = BoardType.GENERIC_DSP,
        version: tuple[int, int] = DSP_VERSION,
    ) -> None:
        """`board_type` and `version` answer a discovery."""
        self._address = address
        self._identity = board_type, *version
        self.leave()

    def move_to(self, address: int) -> None:
        """Answer at another address from now on."""
        self._address = address

    def leave(self) -> None:
        """The application runs."""
        self.is_running = False
        self._left_ms: int | None = None
        self._line_bytes = 0

    def enter(self) -> list[Frame]:
        """BOARD in the application: jump here and answer."""
        self.is_running = True
        self._left_ms = PATIENCE_MS
        return [management.BOARD.reply(self._address, 1)]

    def listen(self, received: list[Frame], dropped: Counter[str]) -> list[Frame]:
        """One millisecond: answers to what came in; only class 7 is heard."""
        sent: list[Frame] = []
        for can_id, data in received:
            if not self.is_running or can_id >> 8 != CLASS_MANAGEMENT or not data:
                dropped["loader"] += 1
            else:
                answer, cause = self._answer(data)
                sent += answer
                if cause:
                    dropped[cause] += 1
        if self._left_ms is not None:
            self._left_ms -= 1
            if not self._left_ms:
                self.leave()
        return sent

    def _answer(self, data: bytes) -> tuple[list[Frame], str]:
        """Answer to a class 7 payload, and why it was dropped; `is_running` ends with END."""
        code = data[0]
        if code == management.DISCOVER.code:
            return [management.DISCOVER_BOOTLOADER.reply(self._address, *self._identity)], ""
        if code == management.BOARD.code:
            self._left_ms = None  # it stays until END
            return [management.BOARD.reply(self._address, 1)], ""
        if code == management.ADDRESS.code and len(data) > 1:
            self._line_bytes = data[1]
            return [], ""
        if code == management.DATA.code:
            return self._take_line(len(data) - 1), ""
        if code == management.START.code:
            return [management.START.reply(self._address, 1)], ""
        if code == management.END.code:
            self.leave()
            return [management.END.reply(self._address, 1)], ""
        return [], "management"

    def _take_line(self, count: int) -> list[Frame]:
        if not self._line_bytes:
            return []
        self._line_bytes = max(0, self._line_bytes - count)
        return [] if self._line_bytes else [management.DATA.reply(self._address, 1)]
