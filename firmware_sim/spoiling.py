"""Frames that do not arrive as they were sent: dropped, corrupted, delayed or duplicated."""

import random
from collections import deque
from collections.abc import Callable, Sequence
from enum import Enum

from firmware_sim.boards.board import Board
from hal.wire.can import Frame

INVERTED = 0xFF


class Effect(Enum):
    """What happens to a frame that is struck."""

    DROP = "drop"
    CORRUPT = "corrupt"  # its data bytes arrive inverted
    DELAY = "delay"
    DUPLICATE = "duplicate"  # it arrives twice


class Spoiler:
    """One fault of frames: which it strikes, and what becomes of them.

    It strikes frames of one identifier or of any, a `share` of them drawn from `seed`, and stops
    after `count` of them (0: never). `struck` counts.
    """

    __slots__ = ("_can_id", "_count", "_draw", "_share", "delay_ms", "effect", "struck")

    def __init__(
        self,
        effect: Effect,
        *,
        can_id: int | None = None,
        count: int = 0,
        share: float = 1.0,
        seed: int = 0,
        delay_ms: int = 0,
    ) -> None:
        self.effect = effect
        self.delay_ms = delay_ms
        self.struck = 0
        self._can_id = can_id
        self._count = count
        self._share = share
        self._draw = random.Random(seed)

    def strikes(self, can_id: int) -> bool:
        """Whether this frame is struck; counts it."""
        if self._can_id is not None and can_id != self._can_id:
            return False
        if self._count and self.struck >= self._count:
            return False
        if self._share < 1.0 and self._draw.random() >= self._share:
            return False
        self.struck += 1
        return True


class Path:
    """One way that frames take, past the spoilers that lie on it in turn."""

    __slots__ = ("_held", "_ms", "spoilers")

    def __init__(self) -> None:
        self.spoilers: list[Spoiler] = []
        self._held: deque[tuple[int, Frame]] = deque()  # (leaves in millisecond, frame)
        self._ms = 0

    @property
    def is_idle(self) -> bool:
        """Nothing lies on it and nothing is held."""
        return not self.spoilers and not self._held

    def step(self, frames: Sequence[Frame]) -> list[Frame]:
        """One millisecond: frames that set out, in; frames that arrive, out."""
        self._ms += 1
        arrived: list[Frame] = []
        if self._held:
            waiting = list(self._held)
            self._held.clear()
            for due_ms, frame in waiting:
                if due_ms <= self._ms:
                    arrived.append(frame)
                else:
                    self._held.append((due_ms, frame))
        for frame in frames:
            self._pass(frame, arrived)
        return arrived

    def _pass(self, frame: Frame, arrived: list[Frame]) -> None:
        copies, delay_ms = 1, 0
        for spoiler in self.spoilers:
            if not spoiler.strikes(frame[0]):
                continue
            if spoiler.effect is Effect.DROP:
                return
            if spoiler.effect is Effect.CORRUPT:
                can_id, data = frame
                frame = (can_id, bytes(byte ^ INVERTED for byte in data))
            elif spoiler.effect is Effect.DUPLICATE:
                copies = 2
            else:
                delay_ms += spoiler.delay_ms
        if delay_ms:
            self._held += [(self._ms + delay_ms, frame)] * copies
        else:
            arrived += [frame] * copies


class Gate:
    """Lies between one board and its bus while a switch is on: what it sends and what it hears."""

    __slots__ = ("_arrived", "_deliver", "inward", "outward")

    def __init__(self, board: Board) -> None:
        self._deliver: Callable[[int, bytes], None] = board.on_frame
        self._arrived: list[Frame] = []
        self.inward = Path()
        self.outward = Path()

    @property
    def is_idle(self) -> bool:
        """It changes nothing any more."""
        return self.inward.is_idle and self.outward.is_idle

    def on_frame(self, can_id: int, data: bytes) -> None:
        """Stands in for the board's own."""
        self._arrived.append((can_id, data))

    def release(self) -> None:
        """Once per millisecond, before the board runs: what gets through reaches it."""
        arrived, self._arrived = self._arrived, []
        for can_id, data in self.inward.step(arrived):
            self._deliver(can_id, data)
