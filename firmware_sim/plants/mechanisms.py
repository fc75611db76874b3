"""What turns under the drives: joints of the rigid model, joints of their own, and tendons.

Every axis has one coordinate. A body axis is a joint of the URDF; a single axis turns an inertia
that the URDF lacks (the eyes' tilt, version and vergence, the spread of the fingers, a thumb's
opposition); a tendon axis winds a tendon, its angle is that of the fingers it pulls. Where two such
motors are coupled only the diagonal of their inertia counts: exact for two equal motors with an eye
each.
DELIBERATE: the eyes stop where version and vergence do, not each eye at an end of its own.
"""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from firmware_sim.description import AxisSpec
from firmware_sim.plants.tendons import Halls, Tendons

Vector = NDArray[np.float64]
Indices = NDArray[np.intp]

TENDON_KG_M2 = 1e-5  # assumed: the pulleys, beside the motor's rotor


class Mechanisms:
    """The axes of a robot by what they turn, and the hands among them."""

    def __init__(self, axes: Sequence[AxisSpec]) -> None:
        self.body: Indices = _of_kind(axes, "body")
        self.tendon: Indices = _of_kind(axes, "tendon")
        pulling = [axes[i] for i in self.tendon]
        self.tendons = Tendons(pulling)
        self.halls = Halls(pulling)
        self.own_kg_m2: Vector = np.array([_own_inertia(axis) for axis in axes])
        self.start_rad: Vector = np.radians([axis.start_deg for axis in axes])
        for k, i in enumerate(self.tendon):
            self.start_rad[i] = self.tendons.wound_at(k, float(self.start_rad[i]))
        self.stops_rad: tuple[Vector, Vector] = (
            np.radians([-1e9 if a.mechanism == "tendon" else a.hard_stop_deg[0] for a in axes]),
            np.radians([1e9 if a.mechanism == "tendon" else a.hard_stop_deg[1] for a in axes]),
        )

    def hall_bytes(self, pull_nm: Vector) -> list[int]:
        """What the Hall sensors of all hands read, in the order of `halls.places`.

        `pull_nm` is the tendon's pull on each axis.
        """
        return self.halls.read(self.tendons.finger_rad(pull_nm[self.tendon]))


def _own_inertia(axis: AxisSpec) -> float:
    return TENDON_KG_M2 if axis.mechanism == "tendon" else axis.inertia_kg_m2


def _of_kind(axes: Sequence[AxisSpec], kind: str) -> Indices:
    return np.array([i for i, axis in enumerate(axes) if axis.mechanism == kind], dtype=np.intp)
