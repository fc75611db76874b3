"""Whether points have arrived, go on, or are stuck on their way."""

import numpy as np

from dforc.arrays import Vector
from services.fields.mode import PERIOD_S, Goals, HandGoal, HandPoint

ARRIVED_M = 0.005  # as the paper's figures count it
ARRIVED_M_S = 0.005
WINDOW_STEPS = round(0.5 / PERIOD_S)
STUCK_M = 0.001  # that the mean place moves from one window to the next: a stuck point may tremble
STUCK_WINDOWS = 2
TRAPPED = "this mode can be trapped; `ulna field mode ulna` finds a way where there is one"


class Standstill:
    """Of one goal."""

    def __init__(self, remedy: str = TRAPPED) -> None:
        """`remedy` is what to say of points that are stuck."""
        self._remedy = remedy
        self._sum_m: Vector | None = None
        self._mean_m: Vector | None = None
        self._steps = 0
        self._stuck = 0

    def judge(self, hands: tuple[HandPoint, ...], goals: Goals) -> tuple[str, str]:
        """State and reason after a period."""
        asked = [(hand, goal) for hand, goal in zip(hands, goals, strict=True) if goal is not None]
        away_m = max((_away_m(*pair) for pair in asked), default=0.0)
        speed_m_s = max((_speed_m_s(*pair) for pair in asked), default=0.0)
        if away_m <= ARRIVED_M and speed_m_s <= ARRIVED_M_S:
            self._stuck = 0
            return "arrived", ""
        self._note(np.concatenate([hand.position_m for hand in hands]))
        if self._stuck < STUCK_WINDOWS:
            return "reaching", ""
        return (
            "waiting",
            f"forces are in balance {away_m * 1e3:.0f} mm from the goal: {self._remedy}",
        )

    def _note(self, place_m: Vector) -> None:
        self._sum_m = place_m if self._sum_m is None else self._sum_m + place_m
        self._steps += 1
        if self._steps < WINDOW_STEPS:
            return
        mean_m: Vector = self._sum_m / self._steps
        if self._mean_m is not None:
            still = float(np.linalg.norm(mean_m - self._mean_m)) < STUCK_M
            self._stuck = self._stuck + 1 if still else 0
        self._mean_m, self._sum_m, self._steps = mean_m, None, 0


def _away_m(hand: HandPoint, goal: HandGoal) -> float:
    return float(np.linalg.norm(goal.position_m - hand.position_m))


def _speed_m_s(hand: HandPoint, goal: HandGoal) -> float:
    """Beside the goal's own."""
    return float(np.linalg.norm(hand.velocity_m_s - goal.velocity_m_s))
