"""What a run of the closed loops must have measured, so that what is missing is not passed over."""

from collections.abc import Sequence
from dataclasses import dataclass, field

from services.experiments.loops.limbs import Limb


@dataclass(slots=True, kw_only=True)
class Expected:
    """One name for each measurement that must be there."""

    steps: list[str] = field(default_factory=list)  # joints
    pushes: list[str] = field(default_factory=list)  # places
    guidings: list[str] = field(default_factory=list)  # limbs
    turns: list[str] = field(default_factory=list)  # joints

    def add(self, other: "Expected") -> None:
        """What another run must have measured beside it."""
        self.steps += other.steps
        self.pushes += other.pushes
        self.guidings += other.guidings
        self.turns += other.turns


def expected(
    limbs: Sequence[Limb], trials: Sequence[str], *, rounds: int, only: int | None
) -> Expected:
    """`rounds` of pushes; torque steps of all joints of a limb, or `only` of its first ones."""
    must = Expected()
    for limb in limbs:
        if "torque" in trials:
            must.steps += limb.torque[:only]
        if "impedance" in trials:
            must.pushes += [limb.pushes[k % len(limb.pushes)][0] for k in range(rounds)]
        if "guiding" in trials:
            must.guidings.append(limb.part)
        if "velocity" in trials:
            must.turns += limb.turned
    return must
