"""Texts that a board sends in pieces: PRINT messages and its 32-character label.

Boards empty their transmit buffer last-in-first-out, so pieces arrive in any order.
"""

from collections.abc import Iterable

from hal.wire.can import Frame
from hal.wire.motor_periodic import PRINT

PRINT_HEAD = 0x06
PRINT_LAST = 0x80
PIECE_CHARACTERS = 6
PIECES = 16

LABEL_PIECES = 8
LABEL_PIECE_CHARACTERS = 4


def print_frames(source: int, string_id: int, text: str) -> list[Frame]:
    """PRINT frames of one text; what exceeds 16 pieces of 6 characters is cut."""
    raw = text.encode("ascii", "replace")[: PIECES * PIECE_CHARACTERS]
    pieces = [raw[i : i + PIECE_CHARACTERS] for i in range(0, len(raw), PIECE_CHARACTERS)] or [b""]
    last = len(pieces) - 1
    return [
        PRINT.frame(
            source,
            PRINT_HEAD | (PRINT_LAST if sequence == last else 0),
            string_id << 4 | sequence,
            *piece,
        )
        for sequence, piece in enumerate(pieces)
    ]


class PrintReader:
    """Puts the PRINT pieces of one board together; holds at most one text per string number.

    After a lost piece the next text of that number may be mixed with it: for people, not logic.
    """

    def __init__(self) -> None:
        self._pieces: dict[int, dict[int, bytes]] = {}
        self._last: dict[int, int] = {}

    def add(self, data: bytes) -> str | None:
        """The text that this piece completes, None while pieces are missing."""
        if not 2 <= len(data) <= 8 or data[0] & ~PRINT_LAST != PRINT_HEAD:
            return None
        string_id, sequence = data[1] >> 4, data[1] & 0xF
        pieces = self._pieces.setdefault(string_id, {})
        pieces[sequence] = data[2:]
        if data[0] & PRINT_LAST:
            self._last[string_id] = sequence
        last = self._last.get(string_id)
        if last is None or any(i not in pieces for i in range(last + 1)):
            return None
        del self._pieces[string_id], self._last[string_id]
        return _readable(b"".join(pieces[i] for i in range(last + 1)))


def label_pieces(label: str) -> list[tuple[int, ...]]:
    """Values of the eight GET_ADDITIONAL_INFO replies: index and four characters."""
    size = LABEL_PIECE_CHARACTERS
    raw = label.encode("ascii", "replace")[: LABEL_PIECES * size].ljust(LABEL_PIECES * size, b"\0")
    return [(index, *raw[index * size : (index + 1) * size]) for index in range(LABEL_PIECES)]


def label_text(pieces: Iterable[tuple[int, ...]]) -> str | None:
    """Label from the values of the replies in any order, None while one of the eight is missing."""
    by_index = {index: bytes(characters) for index, *characters in pieces}
    if any(index not in by_index for index in range(LABEL_PIECES)):
        return None
    return _readable(b"".join(by_index[index] for index in range(LABEL_PIECES)))


def _readable(raw: bytes) -> str:
    return raw.split(b"\0")[0].decode("ascii", "replace")
