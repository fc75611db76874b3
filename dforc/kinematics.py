"""What the numerics ask of a robot model: the pose of the hand and its Jacobian.

dforc.robot_model.RobotModel is one; a test may bring its own.
"""

from collections.abc import Sequence
from typing import Protocol

from dforc.arrays import Matrix, Vector
from dforc.robot_model import ChainElement


class HandKinematics(Protocol):
    """Kinematics of the hand, base frame, joint vectors (n,)."""

    n: int

    def tip_pose(self, q_rad: Vector) -> tuple[Matrix, Vector]:
        """Rotation (3, 3) and position (3,) [m] of the hand."""
        ...

    def tip_jacobian(self, q_rad: Vector) -> Matrix:
        """Geometric Jacobian (6, n) of the hand, linear rows first."""
        ...


class ChainKinematics(HandKinematics, Protocol):
    """The same, with the chain it is computed from."""

    def chain_description(self) -> Sequence[ChainElement]:
        """Placements and axes from the base to the hand."""
        ...
