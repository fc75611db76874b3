"""Requests of the Python client about how a limb is used: settings, tip frame, contexts."""

from collections.abc import Mapping

from dforc.arrays import ArrayLike
from dforc.rotation import rotation_vector
from services.messages import Vector3
from services.reaching.cartesian_messages import CartesianRequest, CartesianSettings
from services.reaching.client_requests import Requests
from services.reaching.client_types import Rotation, Settings, pairs, rotation_numbers
from services.reaching.ik_targets import rotation_of
from services.reaching.messages import TipOffset
from services.reaching.tip_poses import vector3


class SettingRequests(Requests):
    """Reads and changes the settings of the limb; of `auto`, those of every arm."""

    def settings(self) -> Settings:
        """All of them."""
        return self._settings(CartesianRequest(action="get", limb=self.limb))

    def change(
        self,
        *,
        free: Mapping[str, bool] | None = None,
        rest_rad: Mapping[str, float] | None = None,
        rest_weights: Mapping[str, float] | None = None,
        limits_rad: Mapping[str, tuple[float, float]] | None = None,
        priority: str | None = None,
        trajectory_time_s: float | None = None,
        in_target_m: float | None = None,
        in_target_rad: float | None = None,
        tracking: bool | None = None,
        reference_mode: bool | None = None,
        law: str | None = None,
        straightness: float | None = None,
        solving: CartesianSettings | None = None,
    ) -> Settings:
        """Change some of them; all as they are afterwards.

        A motion under way stops where joints are freed or blocked, or the limits, the priority or
        the tip frame change; times and tolerances are those of the next motion.

        Args:
            free: joints that may move, and that may not. The shoulder's go together.
            rest_rad: posture that is preferred where the target leaves a choice.
            rest_weights: how strongly; 0 pulls a joint nowhere.
            limits_rad: narrower than the robot's.
            priority: position or orientation: which is kept where both cannot be.
            trajectory_time_s: how long a motion takes, at least 0.1 s.
            in_target_m: how near is there.
            in_target_rad: and how well turned.
            tracking: keep the pose after the motion, also when blocked joints are moved.
            reference_mode: `pose` tells where the set-points are, not the joints.
            law: time_to_go, or reference: that of the iCub's own controller.
            straightness: how much a straight path outweighs that of the joints.
            solving: tuning of inverse kinematics: tolerances, rest_beta, iterations, solver.

        Raises:
            RequestRefusedError: something does not fit; nothing has changed then.
        """
        told = solving or CartesianSettings()
        wanted = CartesianSettings(
            free=tuple((free or {}).items()),
            rest_rad=pairs(rest_rad),
            rest_weights=pairs(rest_weights),
            limits_rad=tuple((name, *ends) for name, ends in (limits_rad or {}).items()),
            priority=priority,
            position_tolerance_m=told.position_tolerance_m,
            orientation_tolerance_rad=told.orientation_tolerance_rad,
            rest_beta=told.rest_beta,
            iterations=told.iterations,
            solver=told.solver,
            trajectory_time_s=trajectory_time_s,
            in_target_m=in_target_m,
            in_target_rad=in_target_rad,
            tracking=tracking,
            reference_mode=reference_mode,
            law=law,
            straightness=straightness,
        )
        return self._set(wanted)

    def attach_tip(self, position_m: ArrayLike, rotation: Rotation = (0.0, 0.0, 0.0)) -> Settings:
        """Place another frame at the poses: this one, in axes of the hand (of the first tip)."""
        before = self.settings().tip_offsets
        x, y, z = (float(part) for part in position_m)
        offset = TipOffset(position_m=(x, y, z), rotation_rad=as_vector(rotation))
        return self._set(CartesianSettings(tip_offsets=(offset, *before[1:])))

    def tip(self) -> TipOffset:
        """The frame that is placed at the poses, in axes of the hand."""
        return self.settings().tip_offsets[0]

    def remove_tip(self) -> Settings:
        """Place the hand itself at the poses again; every hand of the limb."""
        offsets = (TipOffset(),) * len(self.settings().tip_offsets)
        return self._set(CartesianSettings(tip_offsets=offsets))

    def store_context(self) -> int:
        """Put the settings aside under a number; 0 is those of the start."""
        return self._ask(CartesianRequest(action="store", limb=self.limb)).context

    def restore_context(self, context: int) -> None:
        """Take up again what was stored."""
        self._ask(CartesianRequest(action="restore", limb=self.limb, context=context))

    def delete_context(self, context: int) -> None:
        """Forget what was stored."""
        self._ask(CartesianRequest(action="delete", limb=self.limb, context=context))

    def _set(self, wanted: CartesianSettings) -> Settings:
        return self._settings(CartesianRequest(action="set", limb=self.limb, settings=wanted))

    def _settings(self, request: CartesianRequest) -> Settings:
        return Settings.of(self._ask(request).settings or CartesianSettings())


def as_vector(turned: Rotation) -> Vector3:
    """A rotation of any kind as a rotation vector."""
    return vector3(rotation_vector(rotation_of(rotation_numbers(turned))))
