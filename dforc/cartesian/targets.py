"""What the Cartesian controller can be told to do: reach poses, or move tips at a speed."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from dforc.arrays import ArrayLike, Matrix, Vector, constant, finite_vector
from dforc.cartesian.scalar_kernel import largest_difference
from dforc.errors import ShapeError
from dforc.ik.problem import checked_rotation

STILL = (0.0, 0.0, 0.0)
UPRIGHT = constant(np.eye(3))
JUMP_M = 0.005  # a target this far from where it was expected has jumped
JUMP_OF_ROTATION = 0.05  # of an element of the rotation matrix


@dataclass(frozen=True, slots=True, kw_only=True)
class PoseTarget:
    """Where one tip is to be now, and how that moves; base frame."""

    position_m: ArrayLike  # x_d (3,)
    rotation: Matrix | None  # R_d (3, 3); None: the tip may turn as it likes
    velocity_m_s: ArrayLike = STILL  # dx_d (3,)
    angular_velocity_rad_s: ArrayLike = STILL  # (3,)


@dataclass(frozen=True, slots=True, kw_only=True)
class ReachTarget:
    """Poses of the tips, and the posture that reaches them."""

    tips: Sequence[PoseTarget | None]  # one per tip; None: only the posture draws this one
    q_rad: ArrayLike  # q_d (n,): the answer of inverse kinematics for (almost) these poses


@dataclass(frozen=True, slots=True, kw_only=True)
class TipSpeed:
    """How one tip is to move; base frame."""

    linear_m_s: ArrayLike  # (3,)
    angular_rad_s: ArrayLike | None = STILL  # (3,); None: it may turn as it likes


@dataclass(frozen=True, slots=True, kw_only=True)
class SpeedTarget:
    """Speeds of the tips; the posture follows by itself."""

    tips: Sequence[TipSpeed | None]  # one per tip; None: this one may do what it likes


Target = ReachTarget | SpeedTarget


@dataclass(frozen=True, slots=True, eq=False)
class Wanted:
    """A target, checked, as arrays; k tips, n joints."""

    position: Matrix  # (k, 3)
    rotation: NDArray[np.float64]  # (k, 3, 3)
    velocity: Matrix  # (k, 6), linear then angular
    active: Matrix  # (k, 6): 1 where it counts, else 0
    q: Vector | None  # (n,); None: only the speed counts

    @classmethod
    def checked(cls, target: Target, tips: int, n: int) -> "Wanted":
        """A copy as arrays.

        Raises:
            NotFiniteError: NaN or infinity.
            ShapeError: another number of tips or joints, or no rotation matrix.
        """
        if len(target.tips) != tips:
            raise ShapeError(f"a target for {len(target.tips)} tips, the controller has {tips}")
        wanted = cls(
            position=np.zeros((tips, 3)),
            rotation=np.empty((tips, 3, 3)),
            velocity=np.zeros((tips, 6)),
            active=np.zeros((tips, 6)),
            q=finite_vector("target posture", target.q_rad, n)
            if isinstance(target, ReachTarget)
            else None,
        )
        wanted.rotation[:] = UPRIGHT
        for i, tip in enumerate(target.tips):
            if isinstance(tip, PoseTarget):
                wanted._take_pose(i, tip)
            elif tip is not None:
                wanted._take_speed(i, tip)
        return wanted

    def is_beside(self, position: Matrix, rotation: NDArray[np.float64]) -> bool:
        """Whether any tip is to be further than a jump from these places (k, 3), (k, 3, 3)."""
        for i, active in enumerate(self.active):
            if active[0] and largest_difference(self.position[i], position[i]) > JUMP_M:
                return True
            if active[3]:
                turned = largest_difference(self.rotation[i].ravel(), rotation[i].ravel())
                if turned > JUMP_OF_ROTATION:
                    return True
        return False

    def _take_pose(self, i: int, tip: PoseTarget) -> None:
        self.position[i] = finite_vector("target position", tip.position_m, 3)
        if tip.velocity_m_s is not STILL:
            self.velocity[i, :3] = finite_vector("target velocity", tip.velocity_m_s, 3)
        self.active[i, :3] = 1.0
        if tip.rotation is not None:
            self.rotation[i] = checked_rotation(tip.rotation)
            self.active[i, 3:] = 1.0
            if tip.angular_velocity_rad_s is not STILL:
                turning = finite_vector("target angular velocity", tip.angular_velocity_rad_s, 3)
                self.velocity[i, 3:] = turning

    def _take_speed(self, i: int, tip: TipSpeed) -> None:
        self.velocity[i, :3] = finite_vector("linear velocity", tip.linear_m_s, 3)
        self.active[i, :3] = 1.0
        if tip.angular_rad_s is not None:
            self.velocity[i, 3:] = finite_vector("angular velocity", tip.angular_rad_s, 3)
            self.active[i, 3:] = 1.0
