"""The readings of all limbs in one period, made when they are first asked for."""

from collections.abc import Mapping

from services.core.service import Inputs
from services.reaching.limb_reading import Reading, read_limb
from services.reaching.limb_shape import LimbShape

RECENT_S = 0.5  # a motion under way bears a gap as long
NOTHING = Reading(missing="no joint states yet")


class LimbReadings:
    """By limb."""

    def __init__(self, shapes: Mapping[str, LimbShape]) -> None:
        self._shapes = shapes
        self._inputs: Inputs | None = None
        self._read: dict[str, Reading] = {}

    def begin(self, inputs: Inputs) -> None:
        """A new period."""
        self._inputs = inputs
        self._read.clear()

    def of(self, limb: str) -> Reading:
        """A limb's reading."""
        if self._inputs is None:
            return NOTHING
        if limb not in self._read:
            self._read[limb] = read_limb(self._shapes[limb], self._inputs)
        return self._read[limb]

    def recent(self, limb: str) -> Reading:
        """The same for who asks once: joint states that are late now will be there soon."""
        if self._inputs is None:
            return NOTHING
        return read_limb(self._shapes[limb], self._inputs, RECENT_S)
