"""A ball that somebody moves by hand: strokes of minimum jerk between places, and pauses."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from services.experiments.whole_arm.draw import point_segments

Array = NDArray[np.float64]

PEAK_M_S = (0.1, 0.35)  # of a stroke
PEAK_OVER_MEAN = 1.875  # of minimum jerk
PAUSE_S = (0.2, 1.5)
ACROSS = (0.2, 0.8)  # share of the line between the goals where the ball is held into the way
BESIDE_M = 0.06
AWAY_M = (0.20, 0.30)
AWAY = np.array([-0.8, 0.0, 0.6])  # forward and up, where the person stands
BODY_CLEAR_M = 0.08  # of the parts of the arm that cannot give way
SHORTEST_S = 0.4
LOOKS = 15


@dataclass(frozen=True, eq=False)
class Stroke:
    """One motion and the pause after it."""

    begins_s: float
    lasts_s: float
    from_m: Array
    to_m: Array


class MovedBall:
    """Where the ball is at any time, for as long as a run lasts."""

    def __init__(
        self,
        rng: np.random.Generator,
        goals_m: tuple[Array, Array],
        radius_m: float,
        fixed: tuple[Array, Array],
        length_s: float,
    ) -> None:
        """`fixed`: segments (k, 2, 3) and radii (k,) of what stays where it is."""
        self.radius_m = radius_m
        self._fixed = fixed
        self._strokes: list[Stroke] = []
        place = self._away(rng, goals_m)
        at_s, is_away = float(rng.uniform(0.5, 1.5)), True
        self._first = place
        while at_s < length_s:
            target = self._place(rng, goals_m, place, is_away)
            way = float(np.linalg.norm(target - place))
            lasts_s = max(SHORTEST_S, PEAK_OVER_MEAN * way / float(rng.uniform(*PEAK_M_S)))
            self._strokes.append(Stroke(at_s, lasts_s, place, target))
            at_s += lasts_s + float(rng.uniform(*PAUSE_S))
            place, is_away = target, not is_away

    def at(self, t_s: float) -> Array:
        """Its centre."""
        place = self._first
        for stroke in self._strokes:
            if t_s < stroke.begins_s:
                break
            s = min(1.0, (t_s - stroke.begins_s) / stroke.lasts_s)
            share = s * s * s * (10.0 + s * (6.0 * s - 15.0))
            place = stroke.from_m + share * (stroke.to_m - stroke.from_m)
        return place

    def _place(
        self, rng: np.random.Generator, goals_m: tuple[Array, Array], before: Array, is_away: bool
    ) -> Array:
        """The next place: into the way, or away; the stroke there keeps off what is fixed."""
        for _ in range(10_000):
            if is_away:
                a, b = goals_m
                target = a + rng.uniform(*ACROSS) * (b - a) + rng.normal(0.0, BESIDE_M, 3)
            else:
                target = self._away(rng, goals_m)
            way = before + np.linspace(0.0, 1.0, LOOKS)[:, None] * (target - before)
            if min(self._clearance(place) for place in way) >= BODY_CLEAR_M:
                return np.asarray(target)
        raise RuntimeError("no place for the ball")

    def _away(self, rng: np.random.Generator, goals_m: tuple[Array, Array]) -> Array:
        direction = AWAY + rng.normal(0.0, 0.3, 3)
        middle: Array = 0.5 * (goals_m[0] + goals_m[1])
        return middle + rng.uniform(*AWAY_M) * direction / np.linalg.norm(direction)

    def _clearance(self, place: Array) -> float:
        segments, radii = self._fixed
        return float((point_segments(place, segments) - radii).min()) - self.radius_m
