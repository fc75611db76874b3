"""The newest samples of several channels with their instants, for filters of finite memory."""

import numpy as np

from dforc.arrays import Vector


class History:
    """A window that slides along in two flat arrays: appending is cheap, reading makes no copy."""

    __slots__ = ("_at_s", "_first", "_last", "_most", "_values")

    def __init__(self, channels: int, most: int) -> None:
        """Empty; keeps the newest `most` samples at least."""
        self._most = most
        self._at_s = np.zeros(2 * most)
        self._values = np.zeros((2 * most, channels))
        self._first = 0
        self._last = 0

    def __len__(self) -> int:
        return self._last - self._first

    @property
    def at_s(self) -> Vector:
        """Instants (k,), rising; a view."""
        return self._at_s[self._first : self._last]

    @property
    def values(self) -> Vector:
        """Samples (k, channels); a view."""
        return self._values[self._first : self._last]

    def append(self, value: Vector, at_s: float) -> None:
        """One sample, newer than all before."""
        if self._last == len(self._at_s):
            kept = min(len(self), self._most)
            self._at_s[:kept] = self._at_s[self._last - kept : self._last].copy()
            self._values[:kept] = self._values[self._last - kept : self._last].copy()
            self._first, self._last = 0, kept
        self._at_s[self._last] = at_s
        self._values[self._last] = value
        self._last += 1

    def forget_before(self, at_s: float) -> None:
        """Drop what is older, but for the newest of the old ones."""
        older = int(np.searchsorted(self.at_s, at_s, side="right"))
        self._first += max(older - 1, 0)

    def clear(self) -> None:
        """Drop all."""
        self._first = self._last = 0
