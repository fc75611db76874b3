"""The set-points that joints hold after the last command, for the next plan to start from.

They hold as long as a joint stays in position-direct mode and where it was; otherwise somebody else
moves it, and the plan starts at the measured angle.
"""

import math
from collections.abc import Sequence
from typing import NamedTuple

MOVED_RAD = math.radians(1.5)


class Held(NamedTuple):
    """Of one joint."""

    plan_rad: float
    offset_rad: float  # of the set-point from the plan: the correction of a compliant joint
    measured_rad: float  # when the set-point was sent


class HeldReferences:
    """By joint name."""

    def __init__(self) -> None:
        self._held: dict[str, Held] = {}

    def note(self, joints: Sequence[str], held: Sequence[Held]) -> None:
        """Set-points have been sent."""
        self._held.update(zip(joints, held, strict=True))

    def forget(self, joints: Sequence[str]) -> None:
        """They hold none any more."""
        for joint in joints:
            self._held.pop(joint, None)

    def at(self, joints: Sequence[str], measured_rad: Sequence[float]) -> list[Held]:
        """Where a plan of these joints starts."""
        starts = []
        for joint, q_rad in zip(joints, measured_rad, strict=True):
            held = self._held.get(joint)
            if held is None or abs(q_rad - held.measured_rad) > MOVED_RAD:
                held = Held(q_rad, 0.0, q_rad)
            starts.append(held)
        return starts
