"""Which limb a request is about."""

from collections.abc import Mapping, Sequence

from dforc.arrays import ArrayLike
from services.reaching.arm_choice import nearer_arm
from services.reaching.cartesian_errors import RefusedError

AUTO = "auto"


class LimbNames:
    """The limbs there are, the main job's first among them, and the arm that auto chose last."""

    def __init__(self, limbs: Sequence[str], arms: Sequence[str], main: str) -> None:
        """`arms` are those of the limbs that have one hand."""
        self._limbs = tuple(limbs)
        self._main = main
        self._chosen = main if main in arms else arms[0]
        self.arms = tuple(arms)

    def one(self, name: str) -> str:
        """The limb that is meant; for auto the arm that was chosen last.

        Raises:
            RefusedError: there is none of that name.
        """
        if name == AUTO:
            return self._chosen
        if name and name not in self._limbs:
            raise RefusedError(f"unknown limb {name!r}; there are {', '.join(self._limbs)}, {AUTO}")
        return name or self._main

    def all_of(self, name: str) -> tuple[str, ...]:
        """The same; for auto every arm."""
        return self.arms if name == AUTO else (self.one(name),)

    def nearest(self, target_m: ArrayLike, hands_m: Mapping[str, ArrayLike]) -> str:
        """The arm that auto means for a target; `hands_m` are those whose place is known."""
        self._chosen = nearer_arm(target_m, hands_m, self._chosen)
        return self._chosen
