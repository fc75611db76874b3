"""What comes out of one tick of the whole-body estimate."""

import math
from dataclasses import dataclass

from dforc.arrays import Matrix, Vector
from dforc.estimation.plan import LEVER_M, SUB_MODEL_NUMBERS, Plan


@dataclass(frozen=True, slots=True, eq=False)
class SubModel:
    """What lies between sensors, and how well the assumption fits there."""

    links: tuple[str, ...]
    sensors: tuple[str, ...]  # the valid ones around it; the one towards the base first
    unknowns: int
    rank: int  # fewer than unknowns: the answer is the one of least norm
    residual: Vector  # (6,), base axes, about the middle of its contacts, else where it begins

    @property
    def residual_n(self) -> float:
        """Norm of what no contact explains; 0.1 Nm counts as 1 N."""
        x, y, z, a, b, c = self.residual.tolist()
        return math.hypot(x, y, z, a / LEVER_M, b / LEVER_M, c / LEVER_M)


class BodyEstimate:
    """All results of one tick: views into one vector that no later tick writes to.

    The estimator reads the poses in it until its next estimate (`frame_pose`, `jacobian`).
    """

    __slots__ = ("numbers", "plan")

    def __init__(self, plan: Plan, numbers: Vector) -> None:
        self.plan = plan
        self.numbers = numbers

    @property
    def tau_nm(self) -> Vector:
        """Torques of the drives (n,), Nm."""
        return self.numbers[self.plan.layout.tau]

    @property
    def contact_wrenches(self) -> Matrix:
        """World on robot (k, 6) in the order of the assumption: base axes, about the points."""
        return self.numbers[self.plan.layout.wrenches].reshape(-1, 6)

    @property
    def contact_points_m(self) -> Matrix:
        """Where those wrenches act (k, 3), base frame."""
        return self.numbers[self.plan.layout.points].reshape(-1, 3)

    @property
    def base_wrench(self) -> Vector:
        """What the mainstay exerts on the base (6,), about the base's origin; zero without one."""
        return self.numbers[self.plan.layout.base]

    @property
    def internal(self) -> Matrix:
        """What every sensor would read (m, 6) if nothing touched the robot; sensor frames."""
        return self.numbers[self.plan.layout.internal].reshape(-1, 6)

    @property
    def poses(self) -> Matrix:
        """Every body's rotation (9, column by column) and origin (3) in the base frame."""
        return self.numbers[self.plan.layout.poses].reshape(-1, 12)

    @property
    def residuals(self) -> Matrix:
        """Of each sub-model: what no contact explains (6), and the rank."""
        rows = self.numbers[self.plan.layout.subs].reshape(-1, SUB_MODEL_NUMBERS)
        return rows[: len(self.plan.tops)]

    @property
    def sub_models(self) -> tuple[SubModel, ...]:
        """The sub-models; the first holds the base, the others follow the valid sensors."""
        return tuple(
            SubModel(
                links=self.plan.links(sub),
                sensors=self.plan.sensors(sub),
                unknowns=self.plan.unknowns(sub),
                rank=int(row[6]),
                residual=row[:6],
            )
            for sub, row in enumerate(self.residuals)
        )
