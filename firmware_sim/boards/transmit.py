"""The transmit path of a DSP board: two registers and a software buffer (can-protocol 1).

The buffer holds ten frames, is handled last-in-first-out, and is emptied when it overflows: frames
of a long answer arrive out of order (worked example 2) or not at all.

The sheet gives size and order, not speed. Assumed here, so that the eight pieces of a label arrive
as observed (0, 1, 3, 4, 5, 6, 7, 2): the controller has two registers; of a burst that finds them
empty it sends the first frame while the program makes the fourth; from then on one frame leaves
while the next is made, nine in a millisecond at most (1 Mbit/s, 111 bits).
"""

from hal.wire.can import Frame

REGISTERS = 2
BUFFER_FRAMES = 10
FRAMES_PER_MS = 9
_LEAD_FRAMES = 3  # made before the first of a burst has left
_KEEPS_ORDER = REGISTERS + 1  # so few need no more than one place in the buffer


class TransmitBuffer:
    """Frames on their way out of one board."""

    __slots__ = ("_buffer", "_is_faithful", "_registers", "lost")

    def __init__(self, *, is_faithful: bool = True) -> None:
        """A buffer that is not faithful keeps every frame, in order."""
        self._is_faithful = is_faithful
        self.clear()

    def clear(self) -> None:
        """Forget what has not left."""
        self._registers: list[Frame] = []
        self._buffer: list[Frame] = []
        self.lost = 0  # frames, since whoever reports it looked

    def step(self, made: list[Frame]) -> list[Frame]:
        """One millisecond: frames that the program made, in order; frames that leave, in order."""
        if not self._is_faithful or (not self._registers and len(made) <= _KEEPS_ORDER):
            return made
        sent: list[Frame] = []
        lead = 0 if self._registers else _LEAD_FRAMES
        for number, frame in enumerate(made):
            self._put(frame)
            if number >= lead:
                self._send_one(sent)
        while self._registers and len(sent) < FRAMES_PER_MS:
            self._send_one(sent)
        return sent

    def _put(self, frame: Frame) -> None:
        if len(self._registers) < REGISTERS:
            self._registers.append(frame)
            return
        if len(self._buffer) == BUFFER_FRAMES:
            self.lost += len(self._buffer)
            self._buffer.clear()
        self._buffer.append(frame)

    def _send_one(self, sent: list[Frame]) -> None:
        if len(sent) == FRAMES_PER_MS:
            return
        sent.append(self._registers.pop(0))
        if self._buffer:
            self._registers.append(self._buffer.pop())
