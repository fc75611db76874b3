"""The controllers of the Cartesian experiment, behind one interface.

Each makes joint references from the pose, the posture and (where it can use them) the speeds of a
course, on a plan of its own: none looks at the arm, which is stiff here.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from dforc.arrays import Vector
from dforc.baselines.damped_least_squares import DampedLeastSquares
from dforc.baselines.vite import VelocityLoop, Vite, ViteParams
from dforc.cartesian.controller import CartesianController
from dforc.cartesian.params import CartesianParams, CouplingParams, Law
from dforc.cartesian.state import Measurement
from dforc.cartesian.targets import PoseTarget, ReachTarget
from services.experiments.cartesian.arm import Arm
from services.experiments.cartesian.course import PERIOD_S, Course


class Moving(Protocol):
    """A controller under way along one course."""

    def step(self, period: int, q_measured_rad: Vector) -> tuple[Vector, Vector]:
        """References (n,) of a period: angles and speeds."""
        ...


@dataclass(frozen=True, slots=True, kw_only=True)
class Contender:
    """One of the controllers."""

    name: str
    what: str
    begin: Callable[[Arm, Course], Moving]


class _Ulna:
    def __init__(self, arm: Arm, course: Course, law: Law) -> None:
        params = CartesianParams(
            law=law,
            period_s=PERIOD_S,
            trajectory_time_s=course.trajectory_time_s,
            coupling=CouplingParams(speed_limit_rad_s=arm.speed_limits_rad_s),
        )
        self._controller = CartesianController([arm.tip], arm.limits, params, arm.free.tolist())
        self._state = self._controller.start(course.q_start_rad)
        self._stiff = [False] * len(arm.joints)
        self._course = course
        self._feeds_speed = law is Law.TIME_TO_GO

    def step(self, period: int, q_measured_rad: Vector) -> tuple[Vector, Vector]:
        course, zero = self._course, np.zeros(3)
        target = PoseTarget(
            position_m=course.position_m[period],
            rotation=course.rotation[period],
            velocity_m_s=course.velocity_m_s[period] if self._feeds_speed else zero,
            angular_velocity_rad_s=(
                course.angular_velocity_rad_s[period] if self._feeds_speed else zero
            ),
        )
        self._state, output = self._controller.step(
            self._state,
            Measurement(q_rad=q_measured_rad, compliant=self._stiff),
            ReachTarget(tips=(target,), q_rad=course.q_rad[period]),
        )
        return output.q_rad, output.dq_rad_s


class _Vite:
    def __init__(self, arm: Arm, course: Course, loop: VelocityLoop | None) -> None:
        self._vite = Vite(arm.kinematics, arm.own_limits, ViteParams(period_s=PERIOD_S, loop=loop))
        self._state = self._vite.start(course.q_start_rad)
        self._course = course

    def step(self, period: int, q_measured_rad: Vector) -> tuple[Vector, Vector]:  # noqa: ARG002
        course = self._course
        self._state = self._vite.step(
            self._state,
            course.position_m[period],
            course.rotation[period],
            course.q_rad[period],
        )
        return self._state.q_ref_rad, self._state.dq_ref_rad_s


class _Damped:
    def __init__(self, arm: Arm, course: Course) -> None:
        self._damped = DampedLeastSquares(arm.kinematics, arm.own_limits)
        self._state = self._damped.start(course.q_start_rad)
        self._course = course

    def step(self, period: int, q_measured_rad: Vector) -> tuple[Vector, Vector]:  # noqa: ARG002
        course = self._course
        self._state = self._damped.step(
            self._state, course.position_m[period], course.rotation[period]
        )
        return self._state.q_ref_rad, self._state.dq_ref_rad_s


CONTENDERS = (
    Contender(
        name="ulna",
        what="time-to-go minimum jerk under limits and rows (this project's)",
        begin=lambda arm, course: _Ulna(arm, course, Law.TIME_TO_GO),
    ),
    Contender(
        name="reference",
        what="third-order minimum-jerk filters coupled by multipliers (iKin's law)",
        begin=lambda arm, course: _Ulna(arm, course, Law.REFERENCE),
    ),
    Contender(
        name="vite",
        what="VITE in joint and task space (Hersch and Billard), plan sent as it is",
        begin=lambda arm, course: _Vite(arm, course, None),
    ),
    Contender(
        name="vite-loop",
        what="the same behind a velocity loop of 3/s and 30 deg/s, as on the robot in 2010",
        begin=lambda arm, course: _Vite(arm, course, VelocityLoop()),
    ),
    Contender(
        name="dls",
        what="damped least squares with gradient projection",
        begin=_Damped,
    ),
)
