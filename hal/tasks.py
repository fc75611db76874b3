"""Work that takes many milliseconds, written as generators that are resumed once per step.

A sequence yields to wait for the next step and returns the reason why it failed, empty when it did
not.
"""

from collections.abc import Generator, Iterable

Sequence = Generator[None, None, str]


class Task:
    """A request under way: `done` says whether it has ended, `ok` and `reason` how.

    While it runs `ok` is True and `reason` empty. A refused request is done at once.
    """

    __slots__ = ("_sequence", "action", "done", "joints", "ok", "reason")

    def __init__(self, action: str, joints: Iterable[int], sequence: Sequence | None) -> None:
        self.action = action
        self.joints = frozenset(joints)
        self.done = False
        self.ok = True
        self.reason = ""
        self._sequence = sequence

    @classmethod
    def refused(cls, action: str, reason: str) -> "Task":
        """A request that is not taken up."""
        task = cls(action, (), None)
        task.finish(reason)
        return task

    def resume(self) -> None:
        """Run the sequence up to its next wait."""
        if self.done or self._sequence is None:
            return
        try:
            next(self._sequence)
        except StopIteration as stop:
            self.finish(stop.value)

    def finish(self, reason: str) -> None:
        """End it, with the reason of failure or an empty text."""
        self.done = True
        self.ok = not reason
        self.reason = reason
        if self._sequence is not None:
            self._sequence.close()
            self._sequence = None


def together(sequences: Iterable[Sequence]) -> Sequence:
    """Run several sequences side by side; the reasons of those that failed, joined."""
    running = list(sequences)
    reasons: list[str] = []
    while running:
        still = []
        for sequence in running:
            try:
                next(sequence)
                still.append(sequence)
            except StopIteration as stop:
                if stop.value:
                    reasons.append(stop.value)
        running = still
        if running:
            yield
    return "; ".join(reasons)


class Tasks:
    """The tasks under way. Two of them never share a joint."""

    def __init__(self) -> None:
        self._running: list[Task] = []

    @property
    def actions(self) -> tuple[str, ...]:
        """What is being done."""
        return tuple(task.action for task in self._running)

    def conflict(self, joints: Iterable[int]) -> Task | None:
        """A running task that uses one of these joints."""
        wanted = frozenset(joints)
        return next((task for task in self._running if wanted & task.joints), None)

    def start(self, task: Task) -> Task:
        """Run a task with the following steps; its first part runs now."""
        task.resume()
        if not task.done:
            self._running.append(task)
        return task

    def end_all(self, reason: str) -> None:
        """Break off everything."""
        running, self._running = self._running, []
        for task in running:
            task.finish(reason)

    def step(self) -> None:
        """Resume every task."""
        if self._running:
            for task in self._running:
                task.resume()
            self._running = [task for task in self._running if not task.done]
