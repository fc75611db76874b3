"""Requests of the Python client that read: poses, postures, motions, what there is."""

from collections.abc import Callable, Sequence

from dforc.arrays import ArrayLike
from services.core.errors import ServiceError
from services.reaching.cartesian_messages import (
    CartesianInfo,
    CartesianReply,
    CartesianRequest,
    MotionState,
)
from services.reaching.client_types import (
    PlanSpeeds,
    Pose,
    Posture,
    RequestRefusedError,
    Rotation,
    tip_pose,
)
from services.reaching.messages import TipPose

Ask = Callable[[CartesianRequest], CartesianReply]
"""Sends a request and waits for its reply; a refusal comes back as it is."""


class Requests:
    """One limb's conversation with the Cartesian controller."""

    def __init__(self, limb: str, ask: Ask) -> None:
        self.limb = limb
        self._send = ask

    def pose(self, axis: str | int = "") -> Pose:
        """Where the hand is: of the only tip, or of the first.

        Args:
            axis: a joint, by name or number: the pose of the link that it moves, instead.

        Raises:
            RequestRefusedError: it is not known, for instance because joints are not calibrated.
        """
        reply = self._ask(CartesianRequest(action="pose", limb=self.limb, axis=str(axis)))
        return Pose.of(reply.poses[0])

    def poses(self) -> tuple[Pose, ...]:
        """Where all hands of the limb are, both arms: left, right.

        Raises:
            RequestRefusedError: as `pose`.
        """
        reply = self._ask(CartesianRequest(action="pose", limb=self.limb))
        return tuple(Pose.of(pose) for pose in reply.poses)

    def desired(self) -> tuple[tuple[Pose, ...], dict[str, float]]:
        """Poses and posture that the newest motion of this limb leads to.

        Raises:
            RequestRefusedError: there was none.
        """
        reply = self._ask(CartesianRequest(action="desired", limb=self.limb))
        angles = dict(zip(reply.joints, reply.q_rad, strict=True))
        return tuple(Pose.of(pose) for pose in reply.poses), angles

    def ask_for_pose(
        self,
        position_m: ArrayLike | None,
        rotation: Rotation | None = None,
        start_rad: Sequence[float] = (),
    ) -> Posture:
        """The posture that would reach a pose; nothing moves.

        Args:
            position_m: where to; None: anywhere.
            rotation: None: the hand may turn as it likes.
            start_rad: posture where the search starts; empty: as it stands.

        Raises:
            RequestRefusedError: no answer. A pose out of reach has one: the nearest posture.
        """
        return self.ask_for_poses((tip_pose(position_m, rotation),), start_rad)

    def ask_for_poses(
        self, poses: Sequence[TipPose | None], start_rad: Sequence[float] = ()
    ) -> Posture:
        """The same for a limb with several tips; None: that one may be anywhere."""
        reply = self._ask(
            CartesianRequest(
                action="ask", limb=self.limb, poses=tuple(poses), start_rad=tuple(start_rad)
            )
        )
        if reply.answer is None:
            raise ServiceError("a reply without the answer that was asked for")
        return Posture(
            angles_rad=dict(zip(reply.joints, reply.q_rad, strict=True)),
            poses=tuple(Pose.of(pose) for pose in reply.poses),
            answer=reply.answer,
        )

    def speeds(self) -> PlanSpeeds:
        """How the plan moves now; all zero while nothing does."""
        reply = self._ask(CartesianRequest(action="plan", limb=self.limb))
        joints = dict(zip(reply.joints, reply.dq_rad_s, strict=True))
        return PlanSpeeds(joints, reply.velocities)

    def motion(self, number: int = 0) -> MotionState:
        """A motion, under way or over; 0: the newest one, whoever asked for it."""
        reply = self._ask(CartesianRequest(action="done", motion=number))
        if reply.motion is None:
            raise ServiceError("a reply without the motion that was asked for")
        return reply.motion

    def info(self) -> CartesianInfo:
        """Limbs and what can be asked for."""
        reply = self._ask(CartesianRequest(action="info"))
        if reply.info is None:
            raise ServiceError("a reply without the information that was asked for")
        return reply.info

    def _ask(self, request: CartesianRequest) -> CartesianReply:
        reply = self._send(request)
        if not reply.ok:
            raise RequestRefusedError(reply.reason, reply.answer)
        return reply
