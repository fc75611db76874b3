"""What the Cartesian controller asks inverse kinematics, and who waits for each answer."""

from collections.abc import Callable

from services.core.service import CallFailed, Inputs, Outputs
from services.messages import Floats
from services.reaching.cartesian_errors import RefusedError
from services.reaching.limb_control import LimbControl
from services.reaching.messages import IkAnswer, IkRequest, PoseTarget, TipPose
from services.streams import IK_CALL

MOST = 32  # under way

Heard = Callable[[int, IkAnswer | None, str], None]
"""Takes the time, and the answer, or None and why there is none."""


class IkQuestions:
    """Questions under way, by token."""

    def __init__(self) -> None:
        self._waiting: dict[int, Heard] = {}

    def ask(
        self,
        outputs: Outputs,
        control: LimbControl,
        poses: tuple[TipPose | None, ...],
        start_rad: Floats,
        heard: Heard,
    ) -> int:
        """Ask for a posture, with the limb's settings; the token finds the question again.

        Raises:
            RefusedError: too many are under way.
        """
        if len(self._waiting) >= MOST:
            raise RefusedError(f"{MOST} requests wait for inverse kinematics already")
        request = IkRequest(
            poses=(PoseTarget(tips=poses),),
            limb=control.shape.name,
            setup=control.settings.setup,
            start_rad=start_rad,
        )
        token = outputs.call(IK_CALL, request)
        self._waiting[token] = heard
        return token

    def drop(self, token: int) -> None:
        """Nobody wants that answer any more."""
        self._waiting.pop(token, None)

    def hear(self, now_ns: int, inputs: Inputs) -> None:
        """Hand over what has been answered."""
        for token, reply in inputs.replies(IK_CALL):
            heard = self._waiting.pop(token, None)
            if heard is None:
                continue
            if isinstance(reply, CallFailed) or not reply.ok or not reply.answers:
                heard(now_ns, None, f"inverse kinematics: {reply.reason}")
            else:
                heard(now_ns, reply.answers[0], reply.answers[0].reason)
