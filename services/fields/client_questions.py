"""What a Python client asks the field for: modes, goals, paths."""

from collections.abc import Callable, Mapping

from dforc.arrays import ArrayLike
from services.core.errors import ServiceError
from services.fields.client_goals import make_goal
from services.fields.client_objects import STILL
from services.fields.messages import FieldInfo, FieldReply, FieldRequest, Preview
from services.reaching.client_types import RequestRefusedError, Rotation

Ask = Callable[[FieldRequest], FieldReply]
"""Sends a request and waits for its reply; a refusal comes back as it is."""


class FieldQuestions:
    """A conversation with the field."""

    def __init__(self, ask: Ask) -> None:
        self._send = ask

    def info(self) -> FieldInfo:
        """Modes with their gains, limbs, and what the sources have sent."""
        info = self.ask(FieldRequest(action="info")).info
        if info is None:
            raise ServiceError("a reply without the information that was asked for")
        return info

    def gains(self) -> dict[str, float]:
        """Of the mode in use."""
        return dict(self.ask(FieldRequest(action="info")).gains)

    def set(
        self, mode: str = "", *, preset: str = "", gains: Mapping[str, float] | None = None
    ) -> dict[str, float]:
        """Change mode and gains, also on the way; all gains of the mode then.

        Args:
            mode: ulna, dforc or pmp; empty: the one in use.
            preset: default or paper: all gains of the mode, before `gains` change some.
            gains: K [N/m], D [Ns/m], G [N], T [s], margin [m] and what else the mode has.

        Raises:
            RequestRefusedError: no such mode or gain, or out of bounds; nothing has changed.
        """
        pairs = tuple((name, float(value)) for name, value in (gains or {}).items())
        request = FieldRequest(action="set", mode=mode, preset=preset, gains=pairs)
        return dict(self.ask(request).gains)

    def go(
        self,
        position_m: ArrayLike,
        rotation: Rotation | None = None,
        *,
        limb: str = "",
        velocity_m_s: ArrayLike = STILL,
        second_position_m: ArrayLike | None = None,
        second_rotation: Rotation | None = None,
    ) -> int:
        """Send a hand, or both, to a pose; the number of the goal.

        Args:
            position_m: base frame; of both arms' left hand.
            rotation: a matrix, a rotation vector, or axis and angle; None: any.
            limb: right_arm, left_arm or both_arms; empty: the main job's.
            velocity_m_s: of the goal itself.
            second_position_m: of both arms' right hand; None: it is free.
            second_rotation: of both arms' right hand; None: any.

        Raises:
            RequestRefusedError: that is no goal; the one before stays.
        """
        goal = make_goal(
            position_m,
            rotation,
            limb=limb,
            velocity_m_s=velocity_m_s,
            second_position_m=second_position_m,
            second_rotation=second_rotation,
        )
        return self.ask(FieldRequest(action="goal", goal=goal)).goal

    def follow(self, name: str, rotation: Rotation | None = None, *, limb: str = "") -> int:
        """Send a hand to the centre of an object, wherever that goes; the number of the goal.

        Raises:
            RequestRefusedError: there is no such object.
        """
        goal = make_goal(STILL, rotation, limb=limb, follow=name)
        return self.ask(FieldRequest(action="goal", goal=goal)).goal

    def stop(self) -> None:
        """Withdraw the goal; the hand comes to rest."""
        self.ask(FieldRequest(action="stop"))

    def preview(
        self,
        position_m: ArrayLike | None = None,
        rotation: Rotation | None = None,
        *,
        limb: str = "",
        mode: str = "",
        gains: Mapping[str, float] | None = None,
        preset: str = "",
        duration_s: float = 0.0,
    ) -> Preview:
        """The path to a goal, without moving: from the point on, or else from the hand.

        Args:
            position_m: base frame; None: the goal in use.
            rotation: None: any.
            limb: empty: the main job's.
            mode: empty: the one in use.
            gains: that differ from those in use.
            preset: default or paper.
            duration_s: at most; 0: 15 s.

        Raises:
            RequestRefusedError: no goal, mode or gain, or the hand's place is not known.
        """
        goal = None if position_m is None else make_goal(position_m, rotation, limb=limb)
        pairs = tuple((name, float(value)) for name, value in (gains or {}).items())
        request = FieldRequest(
            action="preview",
            goal=goal,
            mode=mode,
            gains=pairs,
            preset=preset,
            duration_s=duration_s,
        )
        found = self.ask(request).preview
        if found is None:
            raise ServiceError("a reply without the path that was asked for")
        return found

    def forget(self, source: str) -> int:
        """Drop all objects of a source; how many those were.

        Raises:
            RequestRefusedError: there is no such source.
        """
        return self.ask(FieldRequest(action="forget", source=source)).forgotten

    def ask(self, request: FieldRequest) -> FieldReply:
        """Any request.

        Raises:
            RequestRefusedError: it is refused; and why.
            ServiceError: no answer comes.
        """
        reply = self._send(request)
        if not reply.ok:
            raise RequestRefusedError(reply.reason)
        return reply
