"""What the emulated robot is asked, and what it tells. No controller reads it."""

import msgspec

from services.messages import Floats, Message, Vector3


class FaultRequest(msgspec.Struct, frozen=True, kw_only=True, array_like=True):
    """A fault of the emulated robot, on or off; see `ulna board faults` for kinds and needs."""

    kind: str
    on: bool = True
    bus: int | None = None
    address: int | None = None
    axis: int | None = None
    value: int | None = None
    can_id: int | None = None
    count: int = 0
    share: float = 1.0
    seed: int = 0
    milliseconds: int = 0


class PushRequest(msgspec.Struct, frozen=True, kw_only=True, array_like=True):
    """A force on the emulated robot, base frame; for experiments."""

    force_n: Vector3
    duration_s: float
    frame: str = ""  # link or joint of the model that is pushed; empty = the tip
    point_m: Vector3 = (0.0, 0.0, 0.0)  # where, in the axes of that frame


class PlantTruth(Message, frozen=True, kw_only=True):
    """What the emulated robot really does. No controller reads it."""

    joints: tuple[str, ...]
    q_rad: Floats
    dq_rad_s: Floats
    tau_nm: Floats  # motor torque at the joint
    tip_position_m: Vector3
    tip_rotation_rad: Vector3
    limit_violations: int
    board_faults: int
    ticks: int = 0  # milliseconds simulated so far
    frames: int = 0
    frames_lost: int = 0
    limits_waiting: tuple[str, ...] = ()  # joints that are not yet held to their limits
