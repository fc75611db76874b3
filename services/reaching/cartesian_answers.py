"""Requests to the Cartesian controller that are answered at once: what is, and how limbs are used.

A pose that is not known is refused, never zero.
"""

from collections.abc import Callable, Mapping

import numpy as np

from dforc.arrays import Vector
from dforc.cartesian.params import Law
from services.reaching.cartesian_errors import RefusedError
from services.reaching.cartesian_messages import (
    CartesianInfo,
    CartesianReply,
    CartesianRequest,
    LimbInfo,
    TipVelocity,
)
from services.reaching.contexts import Contexts
from services.reaching.limb_control import LimbControl
from services.reaching.limb_driver import LimbDriver, Mode
from services.reaching.limb_names import LimbNames
from services.reaching.limb_readings import LimbReadings
from services.reaching.limb_settings import LimbSettings, changed_settings, told
from services.reaching.limb_shape import LimbShape
from services.reaching.messages import TipPose
from services.reaching.tip_poses import PoseError, joint_pose, tip_pose, tip_velocity

VERSION = "1.0"  # of requests, replies and events
PERIOD_S = 0.01
MOVES = ("go", "ask", "velocity", "stop")  # answered elsewhere

Answer = Callable[[CartesianRequest], CartesianReply]


class CartesianAnswers:
    """Knows all limbs; moves none, but stops one whose settings change."""

    def __init__(
        self,
        limbs: Mapping[str, LimbControl],
        names: LimbNames,
        driver: LimbDriver,
        readings: LimbReadings,
    ) -> None:
        self._changed: list[LimbSettings] = []  # to be told to inverse kinematics
        self._limbs = limbs
        self._names = names
        self._driver = driver
        self._readings = readings
        self._contexts = Contexts({name: limb.settings for name, limb in limbs.items()})
        self._now_ns = 0  # of the request that is being answered
        self._answers: dict[str, Answer] = {
            "pose": self._pose,
            "desired": self._desired,
            "plan": self._plan,
            "done": self._done,
            "set": self._set,
            "get": self._get,
            "store": self._store,
            "restore": self._restore,
            "delete": self._delete,
            "watch": self._watch,
            "unwatch": self._unwatch,
            "info": self._info,
        }

    def answer(self, now_ns: int, request: CartesianRequest) -> CartesianReply:
        """One reply.

        Raises:
            ServiceError: refused, and why.
        """
        if request.action not in self._answers:
            known = ", ".join((*MOVES, *self._answers))
            raise RefusedError(f"unknown action {request.action!r}; known: {known}")
        self._now_ns = now_ns
        return self._answers[request.action](request)

    def take_changed(self) -> list[LimbSettings]:
        """Settings that inverse kinematics has not been told yet."""
        changed, self._changed = self._changed, []
        return changed

    def _pose(self, request: CartesianRequest) -> CartesianReply:
        limb = self._limbs[self._names.one(request.limb)]
        q = self._posture(limb)
        if request.axis:
            poses: tuple[TipPose, ...] = (_axis_pose(limb, q, request.axis),)
        else:
            poses = tuple(tip_pose(tip.pose(q)) for tip in limb.problem.tips)
        return CartesianReply(
            ok=True,
            limb=limb.shape.name,
            joints=limb.shape.joints,
            poses=poses,
            q_rad=tuple(q.tolist()),
        )

    def _desired(self, request: CartesianRequest) -> CartesianReply:
        driver = self._driver
        if driver.target is None or self._names.one(request.limb) != driver.target_limb:
            raise RefusedError("nothing is desired: there has been no motion of this limb")
        limb = self._limbs[driver.target_limb]
        q = np.array(driver.target.q_rad)
        return CartesianReply(
            ok=True,
            limb=driver.target_limb,
            joints=limb.shape.joints,
            poses=tuple(tip_pose(tip.pose(q)) for tip in limb.problem.tips),
            q_rad=tuple(q.tolist()),
        )

    def _plan(self, request: CartesianRequest) -> CartesianReply:
        limb, output = self._limbs[self._names.one(request.limb)], self._driver.output
        if output is None or limb is not self._driver.control:  # nothing moves it
            velocities: tuple[TipVelocity, ...] = (TipVelocity(),) * len(limb.shape.tips)
            dq = (0.0,) * limb.shape.n
        else:
            velocities = tuple(tip_velocity(tip.plan_velocity) for tip in output.tips)
            dq = tuple(output.dq_rad_s.tolist())
        return CartesianReply(
            ok=True,
            limb=limb.shape.name,
            joints=limb.shape.joints,
            dq_rad_s=dq,
            velocities=velocities,
        )

    def _done(self, request: CartesianRequest) -> CartesianReply:
        state = self._driver.motions.state(request.motion)
        if state is None:
            raise RefusedError(f"motion {request.motion} is not known, or over for long")
        return CartesianReply(ok=True, limb=state.limb, motion=state)

    def _set(self, request: CartesianRequest) -> CartesianReply:
        limbs = self._names.all_of(request.limb)
        after = {
            name: changed_settings(
                self._limbs[name].shape, self._limbs[name].settings, request.settings
            )
            for name in limbs
        }
        self._use(after)
        return self._get(request)

    def _get(self, request: CartesianRequest) -> CartesianReply:
        limb = self._limbs[self._names.one(request.limb)]
        return CartesianReply(
            ok=True,
            limb=limb.shape.name,
            joints=limb.shape.joints,
            settings=told(limb.shape, limb.settings),
        )

    def _store(self, request: CartesianRequest) -> CartesianReply:
        limbs = self._names.all_of(request.limb)
        number = self._contexts.store({name: self._limbs[name].settings for name in limbs})
        return CartesianReply(ok=True, context=number)

    def _restore(self, request: CartesianRequest) -> CartesianReply:
        stored = self._contexts.settings(request.context)
        limbs = [name for name in self._names.all_of(request.limb) if name in stored]
        if not limbs:
            raise RefusedError(
                f"context {request.context} is of {', '.join(stored)}, not of {request.limb}"
            )
        self._use({name: stored[name] for name in limbs})
        return CartesianReply(ok=True, context=request.context)

    def _delete(self, request: CartesianRequest) -> CartesianReply:
        self._contexts.delete(request.context)
        return CartesianReply(ok=True)

    def _watch(self, request: CartesianRequest) -> CartesianReply:
        self._driver.motions.watch(request.checkpoint)
        return CartesianReply(ok=True)

    def _unwatch(self, request: CartesianRequest) -> CartesianReply:
        self._driver.motions.unwatch(request.checkpoint)
        return CartesianReply(ok=True)

    def _info(self, request: CartesianRequest) -> CartesianReply:  # noqa: ARG002
        info = CartesianInfo(
            version=VERSION,
            limbs=tuple(_limb_info(limb.shape) for limb in self._limbs.values()),
            actions=(*MOVES, *self._answers),
            laws=tuple(str(law) for law in Law),
            period_s=PERIOD_S,
            contexts=self._contexts.numbers,
        )
        return CartesianReply(ok=True, info=info)

    def _posture(self, limb: LimbControl) -> Vector:
        reading = self._readings.recent(limb.shape.name)
        if reading.missing:
            raise RefusedError(f"the pose is not known: {reading.missing}")
        if limb.settings.reference_mode:
            return limb.references(reading)
        return np.array(reading.q_rad)

    def _use(self, after: Mapping[str, LimbSettings]) -> None:
        driver = self._driver
        for name, settings in after.items():
            limb = self._limbs[name]
            if settings.setup != limb.settings.setup:
                self._changed.append(settings)
                if limb is driver.control and driver.mode is not Mode.FIELD:
                    driver.stop(self._now_ns, "stopped", "the settings of the limb have changed")
            limb.use(settings)


def _axis_pose(limb: LimbControl, q: Vector, axis: str) -> TipPose:
    joints = limb.shape.joints
    if axis in joints:
        index = joints.index(axis)
    elif axis.isdecimal() and int(axis) < len(joints):
        index = int(axis)
    else:
        raise RefusedError(f"no axis {axis!r}; there are 0 to {len(joints) - 1}: {joints}")
    for tip in limb.problem.tips:
        try:
            return tip_pose(joint_pose(tip, q, index))
        except PoseError:
            continue
    raise RefusedError(f"no tip hangs on {axis}")


def _limb_info(shape: LimbShape) -> LimbInfo:
    limits = shape.problem.limits
    ends = zip(shape.joints, limits.lower_rad.tolist(), limits.upper_rad.tolist(), strict=True)
    return LimbInfo(
        name=shape.name,
        joints=shape.joints,
        tips=shape.tips,
        limits_rad=tuple(ends),
        together=shape.together,
    )
