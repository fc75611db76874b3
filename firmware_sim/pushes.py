"""Pushes on the emulated robot: where, how hard, and how much longer."""

import math
from collections.abc import Sequence

import numpy as np

from firmware_sim.network import RigError
from firmware_sim.plants.plant import STEP_S
from firmware_sim.plants.rigid import Push, RigidBodies


class Pushes:
    """Forces on points of links, each for some milliseconds; at most one at a frame."""

    def __init__(self, rigid: RigidBodies, tip_frame: str) -> None:
        """`tip_frame` is pushed where no frame is named."""
        self._rigid = rigid
        self._tip_frame = tip_frame
        self._under_way: dict[str, tuple[Push, int]] = {}

    def begin(
        self, force_n: Sequence[float], duration_s: float, frame: str, point_m: Sequence[float]
    ) -> None:
        """Push from the next step on, instead of what still pushes at that frame.

        Raises:
            RigError: a value is not finite, the duration is not positive, or no link or joint of
            the model has that name.
        """
        frame = frame or self._tip_frame
        finite = math.isfinite(math.fsum((*force_n, *point_m, duration_s)))
        if not (finite and duration_s > 0.0):
            raise RigError(
                f"cannot push with {tuple(force_n)} N at {tuple(point_m)} m for {duration_s} s"
            )
        point = self._rigid.push_point(frame, point_m)
        if point is None:
            raise RigError(f"cannot push at {frame!r}: the model has no such link or joint")
        push = Push(point, np.array(force_n, dtype=np.float64))
        self._under_way[frame] = (push, max(1, round(duration_s / STEP_S)))

    def step(self) -> tuple[Push, ...]:
        """Those of this millisecond."""
        if not self._under_way:
            return ()
        now = tuple(push for push, _ in self._under_way.values())
        self._under_way = {
            frame: (push, ticks - 1)
            for frame, (push, ticks) in self._under_way.items()
            if ticks > 1
        }
        return now
