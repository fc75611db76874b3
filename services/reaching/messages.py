"""What the IK service is asked and says, and how a limb is set up for it.

Joint vectors go from the limb's base to its tip, in the order of `limb_joints`. Poses are of the
limb's tips in their order (both_arms: left, right), base frame.
"""

import msgspec

from services.messages import Floats, Message, Vector3


class TipPose(msgspec.Struct, frozen=True, kw_only=True, array_like=True):
    """Where one tip is to be; what is None does not matter.

    An orientation is a rotation vector (3 numbers) or an axis and an angle (4; any length of axis).
    """

    position_m: Vector3 | None = None
    rotation_rad: Floats | None = None


class PoseTarget(msgspec.Struct, frozen=True, kw_only=True, array_like=True):
    """One pose of a limb: a tip left out, or None, goes where it likes."""

    tips: tuple[TipPose | None, ...]


class TipOffset(msgspec.Struct, frozen=True, kw_only=True, array_like=True):
    """The frame that is driven to the target, in the limb's own tip frame."""

    position_m: Vector3 = (0.0, 0.0, 0.0)
    rotation_rad: Vector3 = (0.0, 0.0, 0.0)


class LimbSetup(msgspec.Struct, frozen=True, kw_only=True, array_like=True):
    """How a limb is used; what is left empty is as the robot file has it."""

    limb: str  # empty = the main job's
    free: tuple[bool, ...] = ()  # joints that may move; empty = all
    rest_rad: Floats = ()
    rest_weights: Floats = ()
    lower_rad: Floats = ()  # narrow the robot's limits, never widen them
    upper_rad: Floats = ()
    tip_offsets: tuple[TipOffset, ...] = ()  # one per tip
    priority: str = ""  # position | orientation: which is kept where both cannot be
    position_tolerance_m: float = 0.0  # 0 = the solver's own
    orientation_tolerance_rad: float = 0.0
    solver: str = ""  # sqp | ipopt | fatrop
    rest_beta: float | None = None  # what one rad^2 of weighted posture is worth, in rad^2 of turn
    iterations: int = 0  # most of one search; 0 = the solver's own


class SetupInUse(Message, frozen=True, kw_only=True):
    """What the Cartesian controller wants the answers of its limb to keep to."""

    setup: LimbSetup


class IkRequest(msgspec.Struct, frozen=True, kw_only=True, array_like=True):
    """Postures for poses, without moving anything."""

    poses: tuple[PoseTarget, ...]
    limb: str = ""  # empty = the main job's
    setup: LimbSetup | None = None  # None = the one in use for the limb
    start_rad: Floats = ()  # where the first search starts; empty = as measured
    deadline_ms: float = 0.0  # of each pose, kept by counting iterations; 0 = the solver's budget
    warm: bool = True  # every search starts from the answer before it; else all from start_rad
    suggest: bool = True  # where a pose is out of reach: look whether blocked joints would help


class IkAnswer(msgspec.Struct, frozen=True, kw_only=True, array_like=True):
    """One pose's posture: finite and inside all limits and rows, whatever the status."""

    q_rad: Floats
    status: str  # converged | infeasible | out_of_time
    position_error_m: float  # of the worst tip
    orientation_error_rad: float
    distance_rad: float  # largest joint move from where the search started
    iterations: int
    reason: str = ""  # why it is not reached, and what would help
    tip_errors: tuple[tuple[float, float] | None, ...] = ()  # m and rad of each tip that has a pose
    limited: bool = False  # held back by the joint step of one tick


class IkStatistics(msgspec.Struct, frozen=True, kw_only=True, array_like=True):
    """Searches since the start; iterations are of the newest ones."""

    solves: int = 0
    converged: int = 0
    infeasible: int = 0
    out_of_time: int = 0
    refused: int = 0  # inputs that were none
    missed: int = 0  # searches that used up their budget
    iterations_p50: float = 0.0
    iterations_p99: float = 0.0


class IkReply(msgspec.Struct, frozen=True, kw_only=True, array_like=True):
    """One answer per pose, in their order; or fewer where time ran out, or none; and why."""

    ok: bool  # every pose has an answer; whether it is reached says the answer
    reason: str = ""
    joints: tuple[str, ...] = ()  # of the limb: the order of q_rad
    answers: tuple[IkAnswer, ...] = ()
    start_rad: Floats = ()
    taken_ms: float = 0.0  # from the request's arrival to the last answer; steps of 1 in virtual
    statistics: IkStatistics = IkStatistics()


class IkStatusReport(Message, frozen=True, kw_only=True):
    """How the IK service does: the stream of points, and requests."""

    limb: str  # that the points are for
    solver: str
    joints: tuple[str, ...]
    status: str  # of the newest point's answer; empty before the first
    reason: str
    stream: IkStatistics
    requests: IkStatistics
    waiting: int = 0  # poses that are still to be solved
    setup_refused: str = ""  # why the newest LimbSetup was not taken up
