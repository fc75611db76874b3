"""How far a whole limb is from a ball: the limb as capsules between its joints.

A capsule is all points within a radius of a segment. Its ends are joint origins or the hand
frame ("tip"), so the model needs joint positions only and no rotations.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from dforc.arrays import ArrayLike, Matrix, Vector, finite_vector
from dforc.errors import DforcError

TIP = "tip"


class CapsuleError(DforcError, ValueError):
    """A capsule names a joint that the limb does not have."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Capsule:
    """One piece of a limb."""

    name: str
    start: str  # joint or TIP
    end: str
    radius_m: float


# Radii: within these distances from the line between the joints lie 95 % of the vertices of the
# link's mesh (icub-models 3.2, iCubLisboa01, the covers of upmc/visual). The chest's mesh does not
# follow its line; 0.08 m is assumed, half its depth.
ICUB_RIGHT_ARM = (
    Capsule(name="torso", start="torso_yaw", end="r_shoulder_pitch", radius_m=0.08),
    Capsule(name="upper arm", start="r_shoulder_yaw", end="r_elbow", radius_m=0.064),
    Capsule(name="forearm", start="r_elbow", end="r_wrist_pitch", radius_m=0.070),
    Capsule(name="hand", start="r_wrist_pitch", end=TIP, radius_m=0.058),
)


def arm_clearance(
    joints: Sequence[str],
    joint_positions_m: Matrix,
    tip_m: Vector,
    centre_m: ArrayLike,
    radius_m: float,
) -> float:
    """Distance [m] from a ball's surface to the right arm and torso; negative when they overlap."""
    apart = clearances(ICUB_RIGHT_ARM, joints, joint_positions_m, tip_m, centre_m, radius_m)
    return min(apart.values())


def clearances(
    capsules: Sequence[Capsule],
    joints: Sequence[str],
    joint_positions_m: Matrix,
    tip_m: Vector,
    centre_m: ArrayLike,
    radius_m: float,
) -> dict[str, float]:
    """Distance [m] from a ball's surface to each capsule's, by name.

    Args:
        capsules: the limb's pieces.
        joints: names in the order of the positions.
        joint_positions_m: origins of the joints (n, 3), as RobotModel.joint_positions gives.
        tip_m: origin of the hand frame (3,).
        centre_m: the ball's centre (3,), same frame.
        radius_m: the ball's radius.

    Raises:
        CapsuleError: a capsule ends at something else than a joint or TIP.
        NotFiniteError: a position holds NaN or infinity.
    """
    names = (*joints, TIP)
    points = np.vstack([joint_positions_m, tip_m])
    finite_vector("joint positions", points.ravel(), 3 * len(names))
    centre = finite_vector("ball centre", centre_m, 3)
    a = points[[_index(capsule.name, capsule.start, names) for capsule in capsules]]
    b = points[[_index(capsule.name, capsule.end, names) for capsule in capsules]]
    along = b - a
    length2 = np.maximum((along * along).sum(axis=1), 1e-18)  # a capsule of no length is a ball
    share = np.clip(((centre - a) * along).sum(axis=1) / length2, 0.0, 1.0)
    distances = np.linalg.norm(a + share[:, None] * along - centre, axis=1)
    return {
        capsule.name: float(distance) - capsule.radius_m - radius_m
        for capsule, distance in zip(capsules, distances, strict=True)
    }


def _index(capsule: str, end: str, names: tuple[str, ...]) -> int:
    if end not in names:
        raise CapsuleError(f"capsule {capsule!r}: no {end!r} among {', '.join(names)}")
    return names.index(end)
