"""What the Cartesian controller is asked, and what it tells.

Poses are of the limb's tips in their order (both_arms: left, right), base frame. Joints go by name.
"""

import math

import msgspec

from services.messages import Floats, Message, Vector3
from services.reaching.messages import IkAnswer, TipOffset, TipPose

NamedFloats = tuple[tuple[str, float], ...]

ONSET = "motion-onset"
ONGOING = "motion-ongoing"
DONE = "motion-done"
CLOSING = "closing"
EVENT_KINDS = (ONSET, ONGOING, DONE, CLOSING)


class TipVelocity(msgspec.Struct, frozen=True, kw_only=True, array_like=True):
    """How a tip moves."""

    linear_m_s: Vector3 = (0.0, 0.0, 0.0)
    angular_rad_s: Vector3 = (0.0, 0.0, 0.0)


class CartesianSettings(msgspec.Struct, frozen=True, kw_only=True, array_like=True):
    """How a limb is used.

    In a request: what is to change, None and empty leave the rest as it is. In a reply: everything.
    """

    free: tuple[tuple[str, bool], ...] = ()  # joints that may move
    rest_rad: NamedFloats = ()
    rest_weights: NamedFloats = ()  # 0: the joint is drawn nowhere
    limits_rad: tuple[tuple[str, float, float], ...] = ()  # inside the robot file's
    tip_offsets: tuple[TipOffset, ...] | None = None  # the frames that go to the poses, one per tip
    priority: str | None = None  # position | orientation
    position_tolerance_m: float | None = None  # of inverse kinematics; 0 = its own, so below
    orientation_tolerance_rad: float | None = None
    rest_beta: float | None = None  # what the rest posture is worth; negative = the robot file's
    iterations: int | None = None  # most of one search
    solver: str | None = None  # empty = the service's own
    trajectory_time_s: float | None = None
    in_target_m: float | None = None
    in_target_rad: float | None = None
    tracking: bool | None = None  # go on controlling once the motion is done
    reference_mode: bool | None = None  # poses are those of the set-points, not of the joints
    law: str | None = None  # time_to_go | reference
    straightness: float | None = None  # gamma: how much the straight path outweighs the posture


class CartesianRequest(msgspec.Struct, frozen=True, kw_only=True, array_like=True):
    """Something for the Cartesian controller to do.

    go          move to `poses` in duration_s (0 = trajectory time); with `nearest` also where that
                is out of reach. Answered once the motion begins, or why it does not
    ask         posture for `poses`, from start_rad (empty = as it stands); nothing moves
    pose        where the tips are, or the joint named in `axis`
    desired     the poses and the posture of the motion's end
    velocity    move the tips with `velocities` for duration_s (0 = 0.5 s), then stop
    plan        velocities of joints and tips now
    stop        come to rest; what is not answered yet is refused
    done        whether the motion `motion` (0 = the newest) has ended, how, and its progress
    set, get    settings
    store, restore, delete    settings, under the number `context`
    watch, unwatch            tell when a motion passes `checkpoint`, 0 to 1 of its way in joint
                              space
    info        limbs, joints, modes
    """

    action: str
    limb: str = ""  # a limb, both_arms, or auto: the nearer hand; empty = the main job's
    poses: tuple[TipPose | None, ...] = ()
    velocities: tuple[TipVelocity, ...] = ()
    duration_s: float = 0.0
    nearest: bool = False
    start_rad: Floats = ()
    axis: str = ""
    motion: int = 0
    context: int = 0
    checkpoint: float = 0.0
    settings: CartesianSettings = CartesianSettings()


class MotionState(msgspec.Struct, frozen=True, kw_only=True, array_like=True):
    """A motion, under way or over."""

    motion: int  # counts up from 1; 0 = there was none
    limb: str = ""
    done: bool = True
    outcome: str = ""  # reached | stopped | replaced | taken over | missed | lost | closed
    reason: str = ""  # of every outcome but reached
    progress: float = 0.0  # 0 to 1, in joint space
    position_error_m: float = math.nan  # of the worst tip, to where the motion leads
    orientation_error_rad: float = math.nan
    out_of_reach: str = ""  # what of the pose asked for is, so that it leads elsewhere


class LimbInfo(msgspec.Struct, frozen=True, kw_only=True, array_like=True):
    """One limb that can be asked for."""

    name: str
    joints: tuple[str, ...]
    tips: tuple[str, ...]
    limits_rad: tuple[tuple[str, float, float], ...]  # of the robot file
    together: tuple[tuple[str, ...], ...]  # joints that are freed and blocked together


class CartesianInfo(msgspec.Struct, frozen=True, kw_only=True, array_like=True):
    """What this controller offers."""

    version: str
    limbs: tuple[LimbInfo, ...]
    actions: tuple[str, ...]
    events: tuple[str, ...] = EVENT_KINDS
    laws: tuple[str, ...] = ()
    period_s: float = 0.0
    contexts: tuple[int, ...] = ()


class CartesianReply(msgspec.Struct, frozen=True, kw_only=True, array_like=True):
    """Answer to a request; what it does not ask for is empty."""

    ok: bool
    reason: str = ""
    limb: str = ""  # that it is about; the chosen one for auto
    joints: tuple[str, ...] = ()  # the order of q_rad
    poses: tuple[TipPose, ...] = ()
    q_rad: Floats = ()
    dq_rad_s: Floats = ()
    velocities: tuple[TipVelocity, ...] = ()
    answer: IkAnswer | None = None
    motion: MotionState | None = None
    settings: CartesianSettings | None = None
    context: int = 0
    info: CartesianInfo | None = None


class CartesianEvent(Message, frozen=True, kw_only=True):
    """Something has happened to a motion; each has one onset and one motion-done."""

    kind: str  # of EVENT_KINDS
    motion: MotionState
    checkpoint: float = math.nan  # that was passed
