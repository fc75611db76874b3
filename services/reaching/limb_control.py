"""One limb under the Cartesian controller: its settings, its plan, and its commands.

A plan starts at the set-points that the joints hold; without any at the measured posture, which is
what a board holds that enters position-direct mode.
"""

from dataclasses import replace

import numpy as np

from dforc.arrays import Vector
from dforc.cartesian.aim import Mode as Aiming
from dforc.cartesian.controller import CartesianController
from dforc.cartesian.params import CartesianParams, CouplingParams, Law
from dforc.cartesian.state import CartesianOutput, CartesianState, Measurement
from dforc.cartesian.targets import Target
from dforc.cartesian.warm import warm
from services.messages import JointCommand
from services.reaching.held_references import Held, HeldReferences
from services.reaching.limb_reading import Reading
from services.reaching.limb_settings import LimbSettings, initial_settings
from services.reaching.limb_setup import apply_setup
from services.reaching.limb_shape import LimbShape

DRIFTED_RAD = np.radians(0.3)  # of a blocked joint: the plan takes over where it is
STANDING_RAD_S = 1e-6


class LimbControl:
    """Settings, controller and plan of one limb."""

    def __init__(
        self,
        shape: LimbShape,
        references: HeldReferences,
        params: CartesianParams | None = None,
    ) -> None:
        """`params` is the tuning that no setting touches."""
        self.shape = shape
        self.settings = initial_settings(shape)
        self.problem = shape.problem
        self.state: CartesianState | None = None
        self._params = params or CartesianParams(
            coupling=CouplingParams(speed_limit_rad_s=shape.speed_limits_rad_s)
        )
        self._controller = CartesianController(
            self.problem.tips, self.problem.limits, self._params, tuple(self.problem.free)
        )
        self._references = references

    def warm(self) -> None:
        """Compile what is compiled before somebody waits for it."""
        warm(self._controller)

    @property
    def free(self) -> tuple[bool, ...]:
        """Joints that may move."""
        return self.settings.setup.free

    def use(self, settings: LimbSettings) -> None:
        """Change the settings; a plan in motion goes on without a step in its speed."""
        self.settings = settings
        self.problem = apply_setup(self.shape.problem, settings.setup)
        self._switch(
            self._controller.changed(
                tips=self.problem.tips, limits=self.problem.limits, free=tuple(self.problem.free)
            )
        )

    def pace(self, trajectory_time_s: float, *, following: bool = False) -> None:
        """How fast the next target is gone to; `following` a stream keeps the robot file's law."""
        settings = self.settings
        coupling = self._params.coupling
        law = Law.TIME_TO_GO if following else Law(settings.law)
        if settings.straightness is not None and not following:
            coupling = replace(coupling, gamma=settings.straightness)
        params = replace(
            self._params,
            law=law,
            trajectory_time_s=trajectory_time_s,
            position_tolerance_m=settings.in_target_m,
            orientation_tolerance_rad=settings.in_target_rad,
            coupling=coupling,
        )
        if params != self._controller.params:
            self._switch(self._controller.changed(params=params))

    def begin(self) -> None:
        """The next target starts a motion with the whole trajectory time, however near it is."""
        if self.state is not None:
            self.state = replace(self.state, aim=replace(self.state.aim, mode=Aiming.HOLD))

    def start_posture(self, reading: Reading) -> Vector:
        """Where the next motion starts: what inverse kinematics is to start from."""
        if self.state is None:
            return self.references(reading)
        resting = self._controller.resting_posture(self.state)
        return np.where(self.free, resting, reading.q_rad)

    def references(self, reading: Reading) -> Vector:
        """The plan's posture; of joints that nothing commands, the set-point or measured angle."""
        if self.state is not None:
            return np.where(self.free, self.state.q_plan, reading.q_rad)
        held = self._references.at(self.shape.joints, reading.q_rad)
        return np.where(self.free, [start.plan_rad for start in held], reading.q_rad)

    def step(self, reading: Reading, force_n: float, target: Target | None) -> CartesianOutput:
        """One period.

        Raises:
            DforcError: the target is none; nothing has changed.
        """
        q = np.array(reading.q_rad)
        state = self._begun(reading) if self.state is None else self._in_step(self.state, q)
        measured = Measurement(q_rad=q, compliant=reading.compliant, external_force_n=force_n)
        self.state, output = self._controller.step(state, measured, target)
        held = zip(
            self.state.q_plan.tolist(),
            (output.q_rad - self.state.q_plan).tolist(),
            reading.q_rad,
            strict=True,
        )
        self._references.note(self.shape.joints, [Held(*values) for values in held])
        return output

    def commands(self, now_ns: int, output: CartesianOutput) -> dict[str, JointCommand]:
        """Set-points by part; none for joints that are blocked and stand."""
        moving = np.abs(output.dq_rad_s) > STANDING_RAD_S
        q, dq = output.q_rad.tolist(), output.dq_rad_s.tolist()
        commands, start = {}, 0
        for part, joints in self.shape.parts.items():
            indices = range(start, start + len(joints))
            start += len(joints)
            chosen = [i for i in indices if self.free[i] or moving[i]]
            if chosen:
                commands[part] = JointCommand(
                    stamp_ns=now_ns,
                    mode="direct",
                    q_rad=tuple(q[i] for i in chosen),
                    dq_rad_s=tuple(dq[i] for i in chosen),
                    joints=()
                    if len(chosen) == len(joints)
                    else tuple(self.shape.joints[i] for i in chosen),
                )
        return commands

    def _switch(self, controller: CartesianController) -> None:
        self._controller = controller
        if self.state is not None:
            self.state = controller.take_over(self.state)

    def _begun(self, reading: Reading) -> CartesianState:
        """At rest where the set-points are, with the correction that is in them."""
        held = self._references.at(self.shape.joints, reading.q_rad)
        state = self._controller.start([start.plan_rad for start in held])
        offset = np.array([start.offset_rad for start in held])
        return replace(state, correction=replace(state.correction, offset_rad=offset))

    def _in_step(self, state: CartesianState, q: Vector) -> CartesianState:
        """The plan with blocked joints where they are: somebody else may move them."""
        standing = ~np.array(self.free) & (np.abs(state.dq_plan) <= STANDING_RAD_S)
        away = standing & (np.abs(q - state.q_plan) > DRIFTED_RAD)
        if not away.any():
            return state
        return replace(state, q_plan=np.where(away, q, state.q_plan))
