"""Who in a client wants to hear of which events."""

import math
import threading
from collections.abc import Callable
from dataclasses import dataclass

from services.core.errors import ServiceError
from services.reaching.cartesian_messages import EVENT_KINDS, ONGOING, CartesianEvent

ANY = "*"
CHECKPOINT_ROUNDING = 1e-9

Deliver = Callable[[CartesianEvent], None]


@dataclass(frozen=True, slots=True, eq=False)
class Listener:
    """One registration; `off` takes it back."""

    kind: str  # of EVENT_KINDS, or *
    checkpoint: float | None  # of motion-ongoing; None: every one that anybody watches
    deliver: Deliver

    def wants(self, event: CartesianEvent) -> bool:
        """Whether an event is for this one."""
        if self.kind not in (ANY, event.kind):
            return False
        if self.checkpoint is None or event.kind != ONGOING:
            return True
        return math.isclose(self.checkpoint, event.checkpoint, abs_tol=CHECKPOINT_ROUNDING)


class Listeners:
    """May be used from any thread."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._listeners: list[Listener] = []

    def add(self, kind: str, checkpoint: float | None, deliver: Deliver) -> Listener:
        """From the next event on.

        Raises:
            ServiceError: no such kind, or a checkpoint where there is none.
        """
        if kind not in (ANY, *EVENT_KINDS):
            raise ServiceError(f"no event {kind!r}; there are {', '.join(EVENT_KINDS)} and *")
        if checkpoint is not None and kind != ONGOING:
            raise ServiceError(f"{kind} has no checkpoints, only {ONGOING} has")
        listener = Listener(kind, checkpoint, deliver)
        with self._lock:
            self._listeners.append(listener)
        return listener

    def remove(self, listener: Listener) -> bool:
        """No more events; whether it was there."""
        with self._lock:
            if listener not in self._listeners:
                return False
            self._listeners.remove(listener)
            return True

    def take_all(self) -> list[Listener]:
        """All that there were; from now on there are none."""
        with self._lock:
            taken, self._listeners = self._listeners, []
        return taken

    def tell(self, event: CartesianEvent) -> None:
        """Hand an event to all that want it."""
        with self._lock:
            wanting = [listener for listener in self._listeners if listener.wants(event)]
        for listener in wanting:
            listener.deliver(event)
