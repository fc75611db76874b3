"""The field's status as a client hears it, and waiting for what it says."""

import asyncio
import threading
from collections.abc import Sequence
from dataclasses import dataclass

from services.core.clock import NS_PER_S, Clock
from services.core.errors import ServiceError
from services.fields.messages import STATES, FieldStatus
from services.reaching.client_types import WaitTimeoutError

FIRST_S = 3.0  # for a status
SILENT_NS = NS_PER_S  # a status that is older says nothing of now
SLICE_S = 0.1  # in which a wait that is awaited looks whether it has been given up


@dataclass(frozen=True, slots=True)
class Wanted:
    """States to wait for, of a goal or a later one."""

    states: Sequence[str]
    goal: int

    @classmethod
    def checked(cls, states: Sequence[str], goal: int) -> "Wanted":
        """`arrived` where no state is named.

        Raises:
            ServiceError: no such state.
        """
        for state in states:
            if state not in STATES:
                raise ServiceError(f"no state {state!r}; there are {', '.join(STATES)}")
        return cls(states or ("arrived",), goal)


class StatusWatch:
    """The newest status of one stack's field; from any thread."""

    def __init__(self, stack: str, clock: Clock) -> None:
        self._stack = stack
        self._clock = clock
        self._heard = threading.Condition()
        self._newest: FieldStatus | None = None

    def hear(self, status: FieldStatus) -> None:
        """Runs in a thread of Zenoh's."""
        with self._heard:
            self._newest = status
            self._heard.notify_all()

    def newest(self) -> FieldStatus:
        """The newest one.

        Raises:
            ServiceError: none comes.
        """
        return self._next(None)

    def following(self) -> FieldStatus:
        """The next one to come.

        Raises:
            ServiceError: none comes.
        """
        return self._next(self._newest)

    def wait(self, wanted: Wanted, timeout_s: float) -> FieldStatus:
        """Wait until the field is in one of the states.

        Raises:
            WaitTimeoutError: it is in another; the text says which, and why.
            ServiceError: the field is silent.
        """
        return self._told(self._within(wanted, timeout_s), timeout_s)

    async def wait_awaited(self, wanted: Wanted, timeout_s: float) -> FieldStatus:
        """The same, for asyncio: where it is cancelled no thread goes on waiting."""
        end_ns = self._clock.now_ns() + round(timeout_s * NS_PER_S)
        while True:
            left_s = max(0.0, (end_ns - self._clock.now_ns()) / NS_PER_S)
            found = await asyncio.to_thread(self._within, wanted, min(left_s, SLICE_S))
            if found is not None or left_s <= SLICE_S:
                return self._told(found, timeout_s)

    def silence(self) -> ServiceError:
        """The error that a silent field is."""
        return ServiceError(
            f"no field process in stack {self._stack!r}: it is still starting, its parts make up "
            "no limb, or it has ended; see `ulna up`'s log"
        )

    def _next(self, before: FieldStatus | None) -> FieldStatus:
        def is_there() -> bool:
            return self._newest is not before and self._fresh() is not None

        with self._heard:
            if self._heard.wait_for(is_there, FIRST_S) and self._newest is not None:
                return self._newest
        raise self.silence()

    def _within(self, wanted: Wanted, patience_s: float) -> FieldStatus | None:
        def is_there() -> bool:
            newest = self._fresh()
            if newest is None or newest.last_goal < wanted.goal:
                return False
            return newest.state in wanted.states

        with self._heard:
            return self._newest if self._heard.wait_for(is_there, patience_s) else None

    def _told(self, found: FieldStatus | None, timeout_s: float) -> FieldStatus:
        if found is not None:
            return found
        newest = self._fresh()
        if newest is None:
            raise self.silence()
        why = f": {newest.reason}" if newest.reason else ""
        raise WaitTimeoutError(f"after {timeout_s:g} s the field is {newest.state}{why}")

    def _fresh(self) -> FieldStatus | None:
        """The newest one, if it says anything of now."""
        newest = self._newest
        if newest is None or self._clock.now_ns() - newest.stamp_ns > SILENT_NS:
            return None
        return newest
