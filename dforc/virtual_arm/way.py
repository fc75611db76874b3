"""A planned path of postures, and how the arm goes along it."""

import numpy as np

from dforc.arrays import Matrix, Vector

PULL_1_S = 4.0  # of the posture towards the path
LEAD_RAD = 0.20  # the point on the path waits when a joint is this far behind it
AT_END_RAD = 0.03
SHARE = 0.7  # of the joints' speeds that the point on the path moves at
END_S = 0.25  # it slows down within this time of the end
MIN_SHARE = 0.05


class Way:
    """Postures (k, n), and a point that moves along the straight pieces between them."""

    def __init__(self, path: Matrix, speeds: Vector) -> None:
        """`speeds` (n,) are the joints' limits [rad/s]; they set how long each piece takes."""
        self.path = path
        pieces = np.abs(np.diff(path, axis=0)) / (SHARE * speeds)
        self._ends_s = np.concatenate([[0.0], np.cumsum(pieces.max(axis=1, initial=0.0))])
        self._at_s = 0.0

    @property
    def end(self) -> Vector:
        """The last posture (n,)."""
        last: Vector = self.path[-1]
        return last

    @property
    def at(self) -> float:
        """Where the point on the path is, in pieces from the beginning."""
        piece = self._piece()
        long_s = self._ends_s[piece + 1] - self._ends_s[piece] if len(self.path) > 1 else 0.0
        share = (self._at_s - self._ends_s[piece]) / long_s if long_s > 0.0 else 0.0
        return float(piece + min(1.0, share))

    def left_rad(self, q: Vector) -> float:
        """Joint-space length from the posture to the end, along the path."""
        at = self._piece()
        ahead = self.path[at + 1 :]
        if not len(ahead):
            return 0.0
        length = float(np.linalg.norm(ahead[0] - q))
        return length + float(np.linalg.norm(np.diff(ahead, axis=0), axis=1).sum())

    def is_at_end(self, q: Vector) -> bool:
        """Whether the posture is where the path ends."""
        return self._at_s >= self._ends_s[-1] and float(np.abs(q - self.end).max()) < AT_END_RAD

    def wanted(self, q: Vector, share: float, period_s: float) -> Vector:
        """Speeds (n,) that follow the path, `share` of them; the point moves on by one period."""
        before = self._point()
        behind = float(np.abs(before - q).max())
        pace = max(0.0, 1.0 - behind / LEAD_RAD)
        left_s = self._ends_s[-1] - self._at_s
        pace *= min(1.0, max(MIN_SHARE, left_s / END_S))
        self._at_s = min(self._ends_s[-1], self._at_s + share * pace * period_s)
        point = self._point()
        wanted: Vector = share * PULL_1_S * (point - q) + (point - before) / period_s
        return wanted

    def _piece(self) -> int:
        last = len(self.path) - 2
        return max(0, min(last, int(np.searchsorted(self._ends_s, self._at_s, side="right")) - 1))

    def _point(self) -> Vector:
        if len(self.path) == 1:
            return self.end
        at = self._piece()
        long_s = self._ends_s[at + 1] - self._ends_s[at]
        share = 1.0 if long_s <= 0.0 else (self._at_s - self._ends_s[at]) / long_s
        point: Vector = self.path[at] + share * (self.path[at + 1] - self.path[at])
        return point
