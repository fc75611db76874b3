"""Whether somebody else moves the hand, or nobody can: then the point waits, silent.

A goal that a request has taken over from stays withdrawn until it is given again: the newest
commander wins. Joints that take no set-points are waited for.
"""

from services.core.clock import NS_PER_MS
from services.messages import CartesianStatus

OTHERS = ("pose", "tracking", "velocity")
STOPPING = "stopping"  # of our limb: asked for; of another: it makes room for ours
SURE_NS = 100 * NS_PER_MS  # for so long, or it was a moment between two commanders
SILENCE_NS = 120 * NS_PER_MS  # that the controller asks of a stream before it takes over again
TAKEN = "a request moves the hand (mode {mode}); give the goal again to go on"


class Takeover:
    """What the Cartesian controller says of whom it obeys."""

    def __init__(self) -> None:
        self._other_since_ns: int | None = None
        self._stuck_since_ns: int | None = None
        self._silent_until_ns = 0
        self.taken = ""  # why the goal rests

    def begin(self, now_ns: int, limb: str, status: CartesianStatus | None) -> None:
        """A new goal: where another commands, its points first pause."""
        self.taken = ""
        self._other_since_ns = None
        if status is not None and _commands(status, limb):
            self._silent_until_ns = now_ns + SILENCE_NS

    def reason(self, now_ns: int, limb: str, status: CartesianStatus | None) -> str:
        """Why the point waits; empty when it may go."""
        if status is None:
            return ""
        if now_ns < self._silent_until_ns:
            return "taking over from a request"
        other = _commands(status, limb)
        self._other_since_ns = _since(now_ns, self._other_since_ns, now=other)
        halted = status.mode == "field" and bool(status.reason)
        self._stuck_since_ns = _since(now_ns, self._stuck_since_ns, now=halted)
        if _lasts(now_ns, self._other_since_ns):
            self.taken = TAKEN.format(mode=status.mode)
        if self.taken:
            return self.taken
        return status.reason if _lasts(now_ns, self._stuck_since_ns) else ""


def _commands(status: CartesianStatus, limb: str) -> bool:
    """Whether a request does."""
    return status.mode in OTHERS or (status.mode == STOPPING and status.limb == limb)


def _since(now_ns: int, since_ns: int | None, *, now: bool) -> int | None:
    if not now:
        return None
    return now_ns if since_ns is None else since_ns


def _lasts(now_ns: int, since_ns: int | None) -> bool:
    return since_ns is not None and now_ns - since_ns >= SURE_NS
