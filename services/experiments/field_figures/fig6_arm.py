"""A perfect arm behind a virtual point: inverse kinematics, then the Cartesian controller."""

import math

import numpy as np
from numpy.typing import NDArray

from dforc.cartesian.controller import CartesianController
from dforc.cartesian.params import CartesianParams, CouplingParams
from dforc.cartesian.state import Measurement
from dforc.cartesian.targets import PoseTarget, ReachTarget
from dforc.ik.inverse_kinematics import InverseKinematics
from dforc.ik.problem import TipTarget
from services.experiments.cartesian.arm import Arm, Pose
from services.experiments.field_scenes.moving_draw import PERIOD_S
from services.reaching.limb import limb_problem

Array = NDArray[np.float64]

TRAJECTORY_S = 0.6  # T
STEP_RAD = math.radians(4.0)


class PerfectArm:
    """Joint angles are what the controller asks for, and the hand is where they put it."""

    def __init__(self, arm: Arm) -> None:
        self._arm = arm
        self._ik = InverseKinematics(limb_problem(arm.robot, arm.limb.name).changed(free=arm.free))
        self._rotation = arm.pose(arm.home_rad).rotation

    def hand(self, points_m: Array) -> Array:
        """Where the hand goes (k, 3) behind a virtual point (k, 3); it starts at the first."""
        arm = self._arm
        start = arm.reached(Pose(points_m[0], self._rotation), arm.home_rad)
        params = CartesianParams(
            period_s=PERIOD_S,
            trajectory_time_s=TRAJECTORY_S,
            coupling=CouplingParams(speed_limit_rad_s=arm.speed_limits_rad_s),
        )
        controller = CartesianController([arm.tip], arm.limits, params, arm.free.tolist())
        state, q = controller.start(start.q_rad), start.q_rad
        solution, stiff = q, [False] * len(q)
        velocities = np.vstack([np.zeros(3), np.diff(points_m, axis=0) / PERIOD_S])
        places = np.empty_like(points_m)
        for i, (point, velocity) in enumerate(zip(points_m, velocities, strict=True)):
            target = TipTarget.checked(point, self._rotation)
            solution = self._ik.track([target], solution, step_limit_rad=STEP_RAD).q_rad
            pose = arm.pose(solution)
            state, output = controller.step(
                state,
                Measurement(q_rad=q, compliant=stiff),
                ReachTarget(
                    tips=(
                        PoseTarget(
                            position_m=pose.position_m,
                            rotation=pose.rotation,
                            velocity_m_s=velocity,
                            angular_velocity_rad_s=np.zeros(3),
                        ),
                    ),
                    q_rad=solution,
                ),
            )
            q = output.q_rad
            places[i] = arm.pose(q).position_m
        return places
