"""A limb as the field moves it: its hands, its limits, and how it is set up."""

from dataclasses import dataclass, field

import numpy as np

from dforc.arrays import Matrix, Vector
from dforc.ik.problem import IkProblem
from services.core.errors import ConfigError
from services.fields.reach import Reach
from services.reaching.limb_setup import apply_setup
from services.reaching.limb_shape import LimbShape
from services.reaching.messages import LimbSetup


@dataclass(slots=True, eq=False)
class FieldLimb:
    """What is kept of a limb."""

    shape: LimbShape
    problem: IkProblem  # tips and limits as the limb is set up
    setup: LimbSetup
    reaches: tuple[Reach, ...] = field(init=False)  # of its hands

    def __post_init__(self) -> None:
        self.reaches = tuple(Reach.of(tip) for tip in self.problem.tips)

    @classmethod
    def of(cls, shape: LimbShape) -> "FieldLimb":
        """As the robot file has it."""
        return cls(shape, shape.problem, LimbSetup(limb=shape.name))

    @property
    def name(self) -> str:
        """Of the limb."""
        return self.shape.name

    @property
    def hands(self) -> int:
        """How many it has."""
        return len(self.shape.tips)

    def set_up(self, setup: LimbSetup) -> bool:
        """Take a set-up; whether it differs from the one before.

        Raises:
            ConfigError: it does not fit; the one before stays.
        """
        if setup == self.setup:
            return False
        if setup.limb not in ("", self.name):
            raise ConfigError(f"a set-up of {setup.limb!r} for {self.name!r}")
        self.problem = apply_setup(self.shape.problem, setup)
        self.setup = setup
        self.reaches = tuple(Reach.of(tip) for tip in self.problem.tips)
        return True

    def poses(self, q_rad: Vector) -> tuple[tuple[Matrix, Vector], ...]:
        """Rotation (3, 3) and position (3,) of every hand in a posture."""
        return tuple(tip.pose(q_rad) for tip in self.problem.tips)

    def velocities(self, q_rad: Vector, dq_rad_s: Vector) -> tuple[Vector, ...]:
        """Velocity (3,) of every hand."""
        return tuple(tip.jacobian(q_rad)[:3] @ dq_rad_s for tip in self.problem.tips)

    def speeds_for(self, q_rad: Vector, velocities_m_s: tuple[Vector, ...]) -> Vector:
        """Joint speeds (n,) that move the hands so, as small as can be."""
        jacobian = np.vstack([tip.jacobian(q_rad)[:3] for tip in self.problem.tips])
        wanted = np.concatenate(velocities_m_s)
        speeds = np.asarray(np.linalg.pinv(jacobian, rcond=1e-2) @ wanted, dtype=np.float64)
        limit = np.array(self.shape.speed_limits_rad_s)
        return np.clip(np.where(self.problem.free, speeds, 0.0), -limit, limit)
