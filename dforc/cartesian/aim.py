"""What the plan is drawn to, over time: did the target jump or does it move, and time to go."""

from dataclasses import dataclass, replace
from enum import StrEnum

import numpy as np
from numpy.typing import NDArray

from dforc.arrays import Matrix, Vector
from dforc.cartesian.params import CartesianParams
from dforc.cartesian.scalar_kernel import largest, largest_difference
from dforc.cartesian.targets import Wanted
from dforc.rotation import matrix

JUMP_RAD = 0.05  # a joint of the target posture that is this far from before has jumped
SLOW = 0.005  # m/s, rad/s: a target slower than this is at rest
JUMP_OF_SPEED = 1e-9  # m/s, rad/s: a speed that differs by more is a new one
REST_BAND_JOINT_RAD = 0.01  # a posture that trembles by less, for a pose at rest, is not followed
MIN_JERK_PEAK = 1.875  # peak over mean speed of a minimum-jerk move

Places = tuple[Matrix, NDArray[np.float64]]  # positions (k, 3), rotations (k, 3, 3)


class Mode(StrEnum):
    """What the plan does."""

    HOLD = "hold"  # stopping or stopped
    REACH = "reach"  # poses and posture
    SPEED = "speed"  # speeds of the tips


@dataclass(frozen=True, slots=True, eq=False)
class Aim:
    """The target and the times that are left."""

    mode: Mode
    position: Matrix  # (k, 3); in speed mode where the tips would be without any error
    rotation: NDArray[np.float64]  # (k, 3, 3)
    velocity: Matrix  # (k, 6), linear then angular
    active: Matrix  # (k, 6): 1 where it counts, else 0
    q: Vector  # (n,)
    q_onset: Vector  # (n,): the plan when this motion began
    task_time_s: float
    joint_time_s: float
    brake_time_s: float  # of joints that come to rest whatever the target
    duration_s: float  # of this motion

    @classmethod
    def at_rest(cls, q: Vector, tips: int) -> "Aim":
        """Hold a posture."""
        turns = np.tile(np.eye(3), (tips, 1, 1))
        nothing = np.zeros((tips, 6))
        where = np.zeros((tips, 3))
        return cls(Mode.HOLD, where, turns, nothing, nothing, q, q, 0.0, 0.0, 0.0, 0.0)

    def stopping(self, poses: Places, params: CartesianParams) -> "Aim":
        """No target: brake along the way, from `poses`, or go on braking; then hold."""
        h = params.period_s
        if self.mode is Mode.HOLD:
            left_s = max(self.brake_time_s - h, 0.0)
            active = self.active if left_s > 0.0 else np.zeros_like(self.active)
            return replace(self, active=active, task_time_s=left_s, brake_time_s=left_s)
        return replace(
            self,
            mode=Mode.HOLD,
            position=poses[0],
            rotation=poses[1],
            velocity=np.zeros_like(self.velocity),
            task_time_s=params.stop_time_s,
            brake_time_s=params.stop_time_s,
            duration_s=params.stop_time_s,
        )

    def keeps_pattern(self, wanted: Wanted) -> bool:
        """Whether the same coordinates count as before, in the same mode."""
        mode = Mode.SPEED if wanted.q is None else Mode.REACH
        return (
            self.mode is mode
            and largest_difference(self.active.ravel(), wanted.active.ravel()) == 0.0
        )

    def reached(
        self,
        wanted: Wanted,
        q_plan: Vector,
        poses: Places,
        slowest_s: float,
        params: CartesianParams,
    ) -> "Aim":
        """The next poses. A jump gives the generators the whole trajectory time again.

        So does the first target of a motion, unless it is in motion itself and begins at the tips:
        that one is followed.

        Args:
            wanted: poses and posture.
            q_plan: the plan now (n,).
            poses: where its tips are.
            slowest_s: what the slowest joint needs for the way to the target posture.
            params: times.
        """
        assert wanted.q is not None
        h = params.period_s
        task_time_s = max(self.task_time_s - h, params.following_time_s)
        joint_time_s = max(self.joint_time_s - h, params.posture_time_s)
        whole_s = max(params.trajectory_time_s, slowest_s)
        afresh = not self.keeps_pattern(wanted)
        if afresh:
            moves = largest(wanted.velocity.ravel()) > SLOW
            pose_jumped = not moves or wanted.is_beside(*poses)
            posture_jumped = pose_jumped or largest_difference(wanted.q, q_plan) > JUMP_RAD
        else:
            expected = self.position + self.velocity[:, :3] * h
            pose_jumped = wanted.is_beside(expected, self.rotation)
            posture_jumped = largest_difference(wanted.q, self.q) > JUMP_RAD
        if pose_jumped:
            task_time_s = whole_s
        if posture_jumped:
            joint_time_s = whole_s
        jumped = pose_jumped or posture_jumped
        return Aim(
            mode=Mode.REACH,
            position=wanted.position,
            rotation=wanted.rotation,
            velocity=wanted.velocity,
            active=wanted.active,
            q=wanted.q,
            q_onset=q_plan if jumped else self.q_onset,
            task_time_s=task_time_s,
            joint_time_s=joint_time_s,
            brake_time_s=max(self.brake_time_s - h, 0.0),
            duration_s=whole_s if jumped else self.duration_s,
        )

    def trembles(self, wanted: Wanted, params: CartesianParams) -> bool:
        """Whether a target differs from the one reached only by what is not worth following."""
        if wanted.q is None or not self.keeps_pattern(wanted):
            return False
        return (
            largest(wanted.velocity.ravel()) == 0.0
            and largest_difference(wanted.position.ravel(), self.position.ravel())
            <= params.rest_band_m
            and largest_difference(wanted.rotation.ravel(), self.rotation.ravel())
            <= params.rest_band_rad
            and largest_difference(wanted.q, self.q) <= REST_BAND_JOINT_RAD
        )

    def waited(self, params: CartesianParams) -> "Aim":
        """The same target one period later."""
        h = params.period_s
        return replace(
            self,
            task_time_s=max(self.task_time_s - h, params.following_time_s),
            joint_time_s=max(self.joint_time_s - h, params.posture_time_s),
            brake_time_s=max(self.brake_time_s - h, 0.0),
        )

    def speeding(
        self,
        wanted: Wanted,
        poses: Places,
        params: CartesianParams,
        *,
        anchored: bool,
    ) -> "Aim":
        """The next speeds. `anchored`: where the tips would be is where they are, `poses`."""
        h = params.period_s
        afresh = not self.keeps_pattern(wanted)
        position, rotation = (self.position, self.rotation) if not (afresh or anchored) else poses
        task_time_s = max(self.task_time_s - h, 0.0)
        if afresh or np.abs(wanted.velocity - self.velocity).max() > JUMP_OF_SPEED:
            task_time_s = params.speed_time_s
        brake_time_s = params.stop_time_s if afresh else max(self.brake_time_s - h, 0.0)
        return replace(
            self,
            mode=Mode.SPEED,
            position=position,
            rotation=rotation,
            velocity=wanted.velocity,
            active=wanted.active,
            task_time_s=task_time_s,
            joint_time_s=0.0,
            brake_time_s=brake_time_s,
            duration_s=params.speed_time_s,
        )

    def moved_on(self, way: Matrix) -> "Aim":
        """Speed mode, one period later: `way` (k, 6) is what the tips were to cover."""
        turned = np.stack([matrix(way[i, 3:]) @ R for i, R in enumerate(self.rotation)])
        return replace(self, position=self.position + way[:, :3], rotation=turned)


def slowest_joint_s(way_rad: Vector, speed_limit_rad_s: Vector) -> float:
    """Shortest minimum-jerk move that keeps every joint to its speed limit."""
    return float(np.max(MIN_JERK_PEAK * np.abs(way_rad) / speed_limit_rad_s, initial=0.0))
