"""What the field service is asked, and what it tells.

Gains go by the papers' letters and units; `services/fields/gains.py` lists those of every mode.
"""

import math

import msgspec

from services.messages import NAN3, Floats, Goal, Message, Vector3, WorldObject

NamedFloats = tuple[tuple[str, float], ...]

MODES = ("ulna", "dforc", "pmp")
STATES = ("idle", "reaching", "planning", "waiting", "unreachable", "arrived")
ACTIONS = ("goal", "stop", "set", "info", "preview", "forget")


class FieldRequest(msgspec.Struct, frozen=True, kw_only=True, array_like=True):
    """Something for the field service to do.

    goal     go there
    stop     withdraw the goal; the hand comes to rest
    set      change mode and gains, at once and without a jump of the point
    info     modes, gains, limbs, objects
    preview  the path to `goal` (None: the one in use) by `mode` and `gains`, without moving
    forget   drop the objects of a source
    """

    action: str
    goal: Goal | None = None
    mode: str = ""  # empty = the one in use
    gains: NamedFloats = ()  # what is to change; the rest stays
    preset: str = ""  # default | paper: all gains of the mode, before `gains` change some
    source: str = ""
    duration_s: float = 0.0  # of a preview, at most; 0 = the service's own


class GainInfo(msgspec.Struct, frozen=True, kw_only=True, array_like=True):
    """One constant of a mode."""

    name: str
    value: float
    unit: str
    meaning: str
    default: float
    paper: float  # NaN: the papers have no such constant
    lowest: float
    highest: float


class ModeInfo(msgspec.Struct, frozen=True, kw_only=True, array_like=True):
    """One mode and its constants now."""

    name: str
    promises: str
    gains: tuple[GainInfo, ...]


class SourceInfo(msgspec.Struct, frozen=True, kw_only=True, array_like=True):
    """What a source has sent, as it was sent."""

    source: str
    objects: tuple[WorldObject, ...]
    age_s: float  # since its newest message


class FieldInfo(msgspec.Struct, frozen=True, kw_only=True, array_like=True):
    """What there is."""

    version: str
    mode: str  # in use
    modes: tuple[ModeInfo, ...]
    limbs: tuple[str, ...]
    limb: str  # the main job's
    sources: tuple[SourceInfo, ...]
    period_s: float


class PathPoint(msgspec.Struct, frozen=True, kw_only=True, array_like=True):
    """One instant of a preview."""

    t_s: float
    position_m: Vector3
    clearance_m: float
    goal_distance_m: float
    q_rad: Floats = ()
    second_position_m: Vector3 | None = None


class Preview(msgspec.Struct, frozen=True, kw_only=True, array_like=True):
    """A path that was not gone."""

    mode: str
    limb: str
    arrives: bool
    arrival_s: float  # NaN where it does not
    state: str  # at the end of the path
    reason: str  # of that state
    closest_m: float  # approach to an obstacle, of its surface; inf without any
    closest_to: str
    closest_s: float
    final_distance_m: float  # from the goal
    path: tuple[PathPoint, ...]


class FieldReply(msgspec.Struct, frozen=True, kw_only=True, array_like=True):
    """Answer to a request; what it does not ask for is empty."""

    ok: bool
    reason: str = ""  # why it is refused; of a goal that is taken up: why it cannot be had now
    goal: int = 0  # number of the goal, as FieldStatus has it
    mode: str = ""  # in use after the request
    gains: NamedFloats = ()  # of that mode
    info: FieldInfo | None = None
    preview: Preview | None = None
    forgotten: int = 0  # objects


class FieldState(msgspec.Struct, frozen=True, kw_only=True, array_like=True):
    """One field that acts on the hand, or could."""

    name: str
    kind: str  # target | obstacle | limits
    on: bool
    distance_m: float  # from the hand to its surface, negative inside; of a target to its centre
    force_n: float  # on the point's mass of 1 kg; NaN in a mode without forces
    position_m: Vector3 = NAN3
    velocity_m_s: Vector3 = (0.0, 0.0, 0.0)
    sigma_m: float = 0.0  # of the position
    age_s: float = 0.0  # since it was last seen
    source: str = ""
    note: str = ""  # what is odd about it


class FieldStatus(Message, frozen=True, kw_only=True):
    """What the field does."""

    mode: str
    gains: NamedFloats
    limb: str  # in use, or last in use
    state: str  # of STATES
    reason: str = ""  # what the state is due to, and what would help
    goal: int = 0  # number of the one in use; 0 = none is, or not any more
    goal_position_m: Vector3 = NAN3
    goal_distance_m: float = math.nan  # of the worst hand
    goal_angle_rad: float = math.nan  # NaN where the orientation does not matter
    point_position_m: Vector3 = NAN3
    point_velocity_m_s: Vector3 = NAN3
    lag_m: float = math.nan  # from the point to the measured hand
    fields: tuple[FieldState, ...] = ()
    clearance_m: float = math.nan  # the smallest, of surfaces; inf with nothing near
    nearest: tuple[str, str] = ("", "")  # between what
    refused: int = 0  # goals and objects that were none
    refusal: str = ""  # why the newest was
    iterations: int = 0  # of this tick
    budget: int = 0  # most of one tick; 0 = the mode needs no search
    held: int = 0  # ticks so far that held the last safe velocity
    nodes: int = 0  # of the planner
    assumed: tuple[str, ...] = ()  # parts that are not heard: taken to be where they were last
    last_goal: int = 0  # number of the newest one, withdrawn or not; 0 = there was none
    late_ms: float = 0.0  # how late the latest period of the last second began; 0 in virtual time
    late_count: int = 0  # times since the start that this was over 50 ms
