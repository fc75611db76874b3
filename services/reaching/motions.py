"""Motions of the Cartesian controller: numbers, progress, checkpoints, how each has ended.

Every motion has one onset and one motion-done, whatever happens; the last ones are remembered, so
that who asks late still learns how it went.
"""

import math
from collections import Counter, deque

import msgspec

from services.core.errors import ServiceError
from services.reaching.cartesian_messages import (
    CLOSING,
    DONE,
    ONGOING,
    ONSET,
    CartesianEvent,
    MotionState,
)

REMEMBERED = 64
MOST_CHECKPOINTS = 64


class CheckpointError(ServiceError):
    """A checkpoint that is none, or one too many."""


class Motions:
    """One motion at a time."""

    def __init__(self) -> None:
        self.current = MotionState(motion=0)
        self._over: deque[MotionState] = deque(maxlen=REMEMBERED)
        self._checkpoints: Counter[float] = Counter()
        self._ahead: list[float] = []  # of the motion under way
        self._events: list[CartesianEvent] = []

    @property
    def under_way(self) -> bool:
        """Whether a motion has begun and not ended."""
        return not self.current.done

    def begin(self, now_ns: int, limb: str, out_of_reach: str = "") -> MotionState:
        """A new motion, with what of its pose is out of reach; one under way is replaced."""
        self.end(now_ns, "replaced", "a newer request took its place")
        number = self.current.motion + 1
        self.current = MotionState(motion=number, limb=limb, done=False, out_of_reach=out_of_reach)
        self._ahead = sorted(self._checkpoints)
        self._tell(now_ns, ONSET)
        return self.current

    def advance(self, now_ns: int, progress: float, errors: tuple[float, float]) -> None:
        """How far it is, 0 to 1, with the errors [m, rad] to where it leads."""
        if not self.under_way:
            return
        progress = max(self.current.progress, min(progress, 1.0))
        self.current = msgspec.structs.replace(
            self.current,
            progress=progress,
            position_error_m=errors[0],
            orientation_error_rad=errors[1],
        )
        while self._ahead and self._ahead[0] <= progress:
            self._tell(now_ns, ONGOING, self._ahead.pop(0))

    def end(self, now_ns: int, outcome: str, reason: str = "") -> None:
        """It is over; nothing happens where it was over before."""
        if not self.under_way:
            return
        if outcome == "reached":
            errors = self.current.position_error_m, self.current.orientation_error_rad
            self.advance(now_ns, 1.0, errors)  # the last bit of the way may be a single period
        self.current = msgspec.structs.replace(
            self.current, done=True, outcome=outcome, reason=reason
        )
        self._over.append(self.current)
        self._tell(now_ns, DONE)

    def close(self, now_ns: int) -> None:
        """The controller ends: so does the motion."""
        self.end(now_ns, "closed", "the Cartesian controller has ended")
        self._tell(now_ns, CLOSING)

    def state(self, motion: int = 0) -> MotionState | None:
        """A motion by its number, 0 for the newest; None where it is not known (any more)."""
        if motion in (0, self.current.motion):
            return self.current
        return next((state for state in self._over if state.motion == motion), None)

    def watch(self, checkpoint: float) -> None:
        """Tell when a motion passes it, from the next one on, and in the one under way if ahead.

        Raises:
            CheckpointError: not between 0 and 1, or too many.
        """
        if not 0.0 <= checkpoint <= 1.0:
            raise CheckpointError(f"a checkpoint is 0 to 1 of the way, not {checkpoint}")
        if checkpoint not in self._checkpoints and len(self._checkpoints) >= MOST_CHECKPOINTS:
            raise CheckpointError(f"{MOST_CHECKPOINTS} checkpoints are watched already")
        if self._checkpoints[checkpoint] == 0 and self.current.progress < checkpoint:
            self._ahead = sorted({*self._ahead, checkpoint})
        self._checkpoints[checkpoint] += 1

    def unwatch(self, checkpoint: float) -> None:
        """Once less.

        Raises:
            CheckpointError: nobody watches it.
        """
        if self._checkpoints[checkpoint] <= 0:
            del self._checkpoints[checkpoint]
            raise CheckpointError(f"nobody watches checkpoint {checkpoint}")
        self._checkpoints[checkpoint] -= 1
        if self._checkpoints[checkpoint] == 0:
            del self._checkpoints[checkpoint]
            self._ahead = [ahead for ahead in self._ahead if ahead != checkpoint]

    def take_events(self) -> list[CartesianEvent]:
        """What has happened since the last look."""
        events, self._events = self._events, []
        return events

    def _tell(self, now_ns: int, kind: str, checkpoint: float = math.nan) -> None:
        self._events.append(
            CartesianEvent(stamp_ns=now_ns, kind=kind, motion=self.current, checkpoint=checkpoint)
        )
