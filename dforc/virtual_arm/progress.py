"""Whether what is wanted also happens."""

import math

LEAST_SHARE = 0.2  # of the wanted motion


class Progress:
    """Motion against wanted motion over the last moments; older ones are forgotten."""

    def __init__(self, window_s: float) -> None:
        """`window_s` is how long nothing may happen."""
        self._window_s = window_s
        self.restart()

    def restart(self) -> None:
        """Something else is wanted from now on."""
        self._done = self._wanted = 0.0
        self._since_s = 0.0

    def note(self, done: float, wanted: float, period_s: float) -> None:
        """One period: `done` is motion . wanted, `wanted` is |wanted|^2, in any one unit."""
        keep = math.exp(-period_s / self._window_s)
        self._done = keep * self._done + done
        self._wanted = keep * self._wanted + wanted
        self._since_s += period_s

    @property
    def is_advancing(self) -> bool:
        """Whether some of it has happened over the whole window."""
        return self._since_s >= self._window_s and self._done >= LEAST_SHARE * self._wanted

    @property
    def is_stuck(self) -> bool:
        """Whether hardly any of it has happened for the whole window."""
        return self._since_s >= self._window_s and self._done < LEAST_SHARE * self._wanted
