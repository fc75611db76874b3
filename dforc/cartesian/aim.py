"""The target of the Cartesian controller over time: does it move or did it jump, and time to go."""

from dataclasses import dataclass

import numpy as np

from dforc.arrays import ArrayLike, Matrix, Vector, finite_vector

JUMP_M = 0.005  # a target this far from where its velocity led has jumped
JUMP_RAD = 0.05  # of a joint of the target posture; also an element of the rotation matrix


@dataclass(frozen=True, slots=True, eq=False)
class Target:
    """A pose with its velocity, and the posture that reaches it."""

    position: Vector  # (3,)
    rotation: Matrix  # (3, 3)
    velocity: Vector  # (6,), linear then angular
    q: Vector  # (n,)

    @classmethod
    def checked(
        cls,
        position_m: ArrayLike,
        rotation: Matrix,
        velocity_m_s: ArrayLike,
        q_rad: ArrayLike,
        n: int,
    ) -> "Target":
        """A copy. Raises NotFiniteError or ShapeError."""
        velocity = np.zeros(6)
        velocity[:3] = finite_vector("target velocity", velocity_m_s, 3)
        return cls(
            finite_vector("target position", position_m, 3),
            finite_vector("target rotation", np.ravel(rotation), 9).reshape(3, 3),
            velocity,
            finite_vector("target posture", q_rad, n),
        )


@dataclass(frozen=True, slots=True, kw_only=True)
class AimTimes:
    """Times to go."""

    trajectory_s: float  # after a jump
    following_s: float  # floor of the task's
    posture_s: float  # floor of the joints'


@dataclass(frozen=True, slots=True, eq=False)
class Aim:
    """The target and the time that is left to reach it."""

    target: Target
    joint_time_s: float
    task_time_s: float
    held: bool  # no target was given: stopping or stopped

    def followed(self, target: Target, times: AimTimes, period_s: float) -> "Aim":
        """The next target. A jump gives the generators the whole trajectory time again."""
        before = self.target
        task_time_s = max(self.task_time_s - period_s, times.following_s)
        joint_time_s = max(self.joint_time_s - period_s, times.posture_s)
        expected = before.position + before.velocity[:3] * period_s
        moved = np.abs(target.position - expected).max() > JUMP_M
        if moved or np.abs(target.rotation - before.rotation).max() > JUMP_RAD:
            task_time_s = times.trajectory_s
        if np.abs(target.q - before.q).max() > JUMP_RAD:
            joint_time_s = times.trajectory_s
        return Aim(target, joint_time_s, task_time_s, held=False)
