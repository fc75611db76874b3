"""What the Cartesian controller takes, carries from period to period, and gives."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from dforc.arrays import ArrayLike, Matrix, Vector
from dforc.cartesian.aim import Aim
from dforc.cartesian.outer_correction import CorrectionState


class TipKinematics(Protocol):
    """Kinematics of one tip over all joints of the controller; dforc.ik.problem.Tip is one."""

    @property
    def n(self) -> int:
        """Joints."""
        ...

    def pose(self, q_rad: Vector) -> tuple[Matrix, Vector]:
        """Rotation (3, 3) and position (3,) [m]."""
        ...

    def jacobian(self, q_rad: Vector) -> Matrix:
        """Geometric Jacobian (6, n), linear rows first."""
        ...


@dataclass(frozen=True, slots=True, kw_only=True)
class Measurement:
    """What is known of the arm now."""

    q_rad: ArrayLike  # (n,)
    compliant: Sequence[bool]  # (n,), joints without an integrator of their own
    external_force_n: float = 0.0  # norm of the estimated force on the hand


@dataclass(frozen=True, slots=True, eq=False)
class Generators:
    """The two minimum-jerk generators; their errors are read off the plan."""

    joint_velocity: Vector  # (n,)
    joint_acceleration: Vector
    task_velocity: Matrix  # (k, 6)
    task_acceleration: Matrix
    task_error: Matrix  # of the period before: near half a turn it tells on which side a tip is

    @classmethod
    def at_rest(cls, n: int, tips: int) -> "Generators":
        """Nothing moves."""
        return cls(
            np.zeros(n),
            np.zeros(n),
            np.zeros((tips, 6)),
            np.zeros((tips, 6)),
            np.zeros((tips, 6)),
        )

    def copy(self) -> "Generators":
        """Arrays of its own, to be run on."""
        return Generators(
            self.joint_velocity.copy(),
            self.joint_acceleration.copy(),
            self.task_velocity.copy(),
            self.task_acceleration.copy(),
            self.task_error.copy(),
        )


@dataclass(frozen=True, slots=True, eq=False)
class Outside:
    """How far the plan stood outside limits when it began, and what is left of it."""

    distance: Vector  # (m,), of each limit and row; 0 inside
    elapsed_s: float


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class CartesianState:
    """What the controller carries from period to period. The first comes from `start`."""

    q_plan: Vector  # (n,)
    dq_plan: Vector  # mean speed of the last period
    ddq_plan: Vector  # its change against the period before, per second
    generators: Generators
    aim: Aim
    outside: Outside
    limited: bool  # limits changed the speeds of the last period
    in_target: bool
    correction: CorrectionState


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class TipReport:
    """One tip at the time of the measurement."""

    plan_position_m: Vector  # (3,)
    plan_rotation: Matrix
    plan_velocity: Vector  # (6,), linear then angular
    position_error_m: float  # measured tip to its target; nan without one
    orientation_error_rad: float  # nan where orientation is free
    plan_error_m: float  # measured tip to the plan


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class CartesianOutput:
    """The reference for the joints, and what to report."""

    q_rad: Vector  # q_ref (n,): inside the joint ranges
    dq_rad_s: Vector  # velocity of the plan (n,)
    plan_q_rad: Vector  # (n,)
    tips: tuple[TipReport, ...]
    progress: float  # of the motion, 0 to 1, by the way of the plan in joint space
    duration_s: float  # T of this motion, stretched where joints could not be there in time
    in_target: bool  # with hysteresis; never in speed mode or while held
    at_rest: bool  # the plan stands still
    held: bool  # no target
    limited: bool  # limits, rows or speed limits changed the plan's speed
    gated: bool  # the correction stands still because something pushes the arm
    saturated: bool  # the correction is at its bound

    @property
    def position_error_m(self) -> float:
        """Of the worst tip; nan when no tip has a target."""
        return worst([tip.position_error_m for tip in self.tips])

    @property
    def orientation_error_rad(self) -> float:
        """Of the worst tip; nan when no orientation matters."""
        return worst([tip.orientation_error_rad for tip in self.tips])

    @property
    def plan_error_m(self) -> float:
        """Of the worst tip."""
        return worst([tip.plan_error_m for tip in self.tips])


@dataclass(frozen=True, slots=True, eq=False)
class Poses:
    """Where the tips are."""

    position: Matrix  # (k, 3)
    rotation: NDArray[np.float64]  # (k, 3, 3)

    @classmethod
    def of(cls, tips: Sequence[TipKinematics], q_rad: Vector) -> "Poses":
        """In this posture."""
        position, rotation = np.empty((len(tips), 3)), np.empty((len(tips), 3, 3))
        for i, tip in enumerate(tips):
            rotation[i], position[i] = tip.pose(q_rad)
        return cls(position, rotation)


def worst(values: list[float]) -> float:
    """The largest number among them that is one; nan if none is."""
    numbers = [value for value in values if value == value]  # nan differs from itself
    return max(numbers, default=float("nan"))
