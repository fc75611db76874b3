"""When a learner of contact-free dynamics may learn: never while something touches the robot.

An ungated learner takes a push for dynamics: it reports less and less of it, and a ghost of
opposite sign after the release. The gate closes at once when the residual exceeds a threshold, and
opens a while after it has fallen below a lower one. The residual's size is that of its force, or of
its moment at a lever of 0.2 m where that is more: who twists a limb hardly pushes it. A push that
grows slowly is learned in part before it reaches the threshold; hence the memory of `ContactSafe`:
when the gate closes, everything learned in the last seconds is taken back.

What no gate can tell from dynamics: a push that stays below the thresholds, and one that grows so
slowly that the learner follows it (slower than threshold per memory), as long as the whole of what
was learned beyond the rigid-body model stays below `model_n`. Above that the gate closes however
slow the push was. Skin or contact detection, where there is any, closes it by `touched`.
Nor can it tell the end of a push from an arm that went to unknown postures meanwhile: it then stays
closed, until the residual falls or `release` says that nothing touches.
"""

from dataclasses import dataclass
from typing import Generic, Protocol, TypeVar

import numpy as np

from dforc.arrays import ArrayLike, Vector, finite_vector
from dforc.errors import ShapeError

StateT = TypeVar("StateT")

TWIST_LEVER_M = 0.2


@dataclass(frozen=True, slots=True, kw_only=True)
class GateLimits:
    """Thresholds of the force that the learner cannot explain."""

    close_n: float = 2.0  # residual of the learner: above, learning stops at once
    open_n: float = 1.5  # below, for `quiet` samples in a row, it starts again
    quiet: int = 10  # samples
    model_n: float = np.inf  # residual of the model without the learner

    def __post_init__(self) -> None:
        if not 0 < self.open_n <= self.close_n <= self.model_n or self.quiet < 1:
            raise ShapeError(f"thresholds out of order: {self}")


def size_n(wrench: Vector) -> float:
    """One number for a wrench (6,): its force, or what its moment is at the lever of a twist."""
    force, moment = np.linalg.norm(wrench[:3]), np.linalg.norm(wrench[3:])
    return float(max(force, moment / TWIST_LEVER_M))


class UpdateGate:
    """Hysteresis over the residual force."""

    __slots__ = ("_calm", "closings", "limits", "open")

    def __init__(self, limits: GateLimits | None = None) -> None:
        """Begin open."""
        self.limits = limits or GateLimits()
        self.open = True
        self.closings = 0
        self._calm = 0

    def admit(
        self,
        residual_n: float,
        model_n: float = 0.0,
        allowance_n: float = 0.0,
        *,
        touched: bool = False,
    ) -> bool:
        """Whether a sample may be learned.

        Args:
            residual_n: size of measured minus predicted wrench, before learning.
            model_n: the same against the rigid-body model alone; 0 where there is none.
            allowance_n: raises both thresholds: the learner may be this wrong, not knowing better.
            touched: skin or contact detection says so.
        """
        residual_n -= allowance_n
        limits = self.limits
        # written so that NaN closes: no comparison with NaN holds
        calm = residual_n <= limits.open_n and model_n <= limits.model_n and not touched
        bearable = residual_n <= limits.close_n and model_n <= limits.model_n and not touched
        if not bearable:
            self.closings += self.open
            self.open = False
        self._calm = self._calm + 1 if calm else 0
        if not self.open and self._calm >= limits.quiet:
            self.open = True
        return self.open

    def release(self) -> None:
        """Open it by hand: somebody knows that nothing touches the robot."""
        self.open = True
        self._calm = 0


class Learner(Protocol[StateT]):
    """What ContactSafe asks of a learner."""

    def predict(self, x: ArrayLike) -> Vector:
        """The wrench (6,): forces first."""
        ...

    def novelty(self, x: ArrayLike) -> float:
        """How little is known about this input: 1 = nothing, 0 = everything."""
        ...

    def update(self, x: ArrayLike, y: ArrayLike) -> Vector:
        """Take in one sample."""
        ...

    def state(self) -> StateT:
        """A copy of everything learned."""
        ...

    def restore(self, state: StateT) -> None:
        """Continue from it."""
        ...


class ContactSafe(Generic[StateT]):
    """A learner of what a model leaves over, behind a gate, with a memory to go back to."""

    __slots__ = (
        "_age",
        "_memory",
        "_newer",
        "_older",
        "_unknown_n",
        "gate",
        "learner",
        "taken_back",
    )

    def __init__(
        self, learner: Learner[StateT], gate: UpdateGate, memory: int, unknown_n: float = 0.0
    ) -> None:
        """Remember the state of between `memory` and twice as many admitted samples ago.

        Args:
            learner: the learner, which nobody else may update.
            gate: its gate.
            memory: samples; 0 = take nothing back.
            unknown_n: allowance of the gate where the learner knows nothing yet.
        """
        self._unknown_n = unknown_n
        self.learner = learner
        self.gate = gate
        self.taken_back = 0
        self._memory = memory
        self._age = 0
        self._older = self._newer = learner.state() if memory else None

    def predict(self, x: ArrayLike) -> Vector:
        """The learner's prediction (6,)."""
        return self.learner.predict(x)

    def update(self, x: ArrayLike, rest: ArrayLike, *, touched: bool = False) -> bool:
        """Learn `rest` = measured minus rigid-body model (6,) where the gate permits it.

        Raises:
            NotFiniteError: NaN or infinity in the sample; nothing was changed.
        """
        rest = finite_vector("rest", rest, 6)
        was_open = self.gate.open
        residual_n = size_n(rest - self.learner.predict(x))
        model_n = size_n(rest)
        allowance_n = self._unknown_n * self.learner.novelty(x) if self._unknown_n else 0.0
        if self.gate.admit(residual_n, model_n, allowance_n, touched=touched):
            self._remember()
            self.learner.update(x, rest)
            return True
        if was_open and self._older is not None:
            self.learner.restore(self._older)
            self._newer = self._older
            self._age = 0
            self.taken_back += 1
        return False

    def forget(self) -> None:
        """The learner has been reset or restored: its state now is all there is to go back to."""
        self._age = 0
        self._older = self._newer = self.learner.state() if self._memory else None
        self.gate.release()

    def _remember(self) -> None:
        if not self._memory:
            return
        if self._age >= self._memory:
            self._older, self._newer = self._newer, self.learner.state()
            self._age = 0
        self._age += 1
