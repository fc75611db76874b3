"""Whether points have arrived, go on, or are stuck on their way."""

import numpy as np

from services.fields.mode import PERIOD_S, Goals, HandPoint

ARRIVED_M = 0.005  # as the paper's figures count it
ARRIVED_M_S = 0.005
STUCK_M_S = 0.002
STUCK_S = 1.0
REMEDY = "this mode can be trapped; `ulna field mode ulna` finds a way where there is one"


class Standstill:
    """Of one goal."""

    def __init__(self) -> None:
        self._slow_steps = 0

    def judge(self, hands: tuple[HandPoint, ...], goals: Goals) -> tuple[str, str]:
        """State and reason after a period."""
        asked = [pair for pair in zip(hands, goals, strict=True) if pair[1] is not None]
        away_m, speed_m_s = 0.0, 0.0
        for hand, goal in asked:
            if goal is not None:
                away_m = max(away_m, float(np.linalg.norm(goal.position_m - hand.position_m)))
                beside = hand.velocity_m_s - goal.velocity_m_s
                speed_m_s = max(speed_m_s, float(np.linalg.norm(beside)))
        if away_m <= ARRIVED_M and speed_m_s <= ARRIVED_M_S:
            self._slow_steps = 0
            return "arrived", ""
        self._slow_steps = self._slow_steps + 1 if speed_m_s < STUCK_M_S else 0
        if self._slow_steps * PERIOD_S < STUCK_S:
            return "reaching", ""
        return "waiting", f"forces are in balance {away_m * 1e3:.0f} mm from the goal: {REMEDY}"
