"""What is assumed about the world: where it may touch the robot, and how the base moves."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

from dforc.errors import DforcError

Kind = Literal["wrench", "force", "direction"]
Point = tuple[float, float, float]
Wrench = tuple[float, float, float, float, float, float]

UNKNOWNS: dict[Kind, int] = {"wrench": 6, "force": 3, "direction": 1}
UNIT_TOLERANCE = 1e-9


class AssumptionError(DforcError, ValueError):
    """An assumption names a frame that the model has not got, or contradicts itself."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Contact:
    """A point where the world may touch the robot, and what it may do there.

    "wrench": force and moment; "force": no moment; "direction": a force along `direction` only.
    A fallback is a default: of all in one sub-model the first counts, and none of them where the
    mainstay or a contact that is no fallback stands in that sub-model.
    """

    frame: str  # link or frame of the URDF
    point_m: Point = (0.0, 0.0, 0.0)  # in that frame
    kind: Kind = "wrench"
    direction: Point | None = None  # unit vector in the frame's axes, for kind "direction" only
    fallback: bool = False

    def __post_init__(self) -> None:
        """Refuse a contact that cannot be meant."""
        if self.kind not in UNKNOWNS:
            raise AssumptionError(f"contact at {self.frame}: kind {self.kind!r}; {list(UNKNOWNS)}")
        _require_finite(f"contact at {self.frame}", self.point_m, 3)
        if (self.kind == "direction") != (self.direction is not None):
            raise AssumptionError(f"contact at {self.frame}: kind {self.kind!r}, {self.direction=}")
        if self.direction is not None:
            _require_finite(f"direction at {self.frame}", self.direction, 3)
            length = math.hypot(*self.direction)
            if abs(length - 1.0) > UNIT_TOLERANCE:
                raise AssumptionError(f"direction at {self.frame} has the length {length}, not 1")


@dataclass(frozen=True, slots=True, kw_only=True)
class KnownWrench:
    """A wrench of the world on the robot that is known: a load, or a contact measured by skin."""

    frame: str
    wrench: Wrench  # force [N], moment about the point [Nm]; the frame's axes
    point_m: Point = (0.0, 0.0, 0.0)  # in that frame

    def __post_init__(self) -> None:
        """Refuse what is not finite."""
        _require_finite(f"known wrench at {self.frame}", self.point_m, 3)
        _require_finite(f"known wrench at {self.frame}", self.wrench, 6)


@dataclass(frozen=True, slots=True, kw_only=True)
class Assumption:
    """Contacts, mainstay and kinematic source."""

    contacts: tuple[Contact, ...] = ()
    source: str = ""  # frame of the IMU that says how the robot moves; "": the base stands still
    mainstay: bool = True  # the base may be held by an unknown wrench
    known: tuple[KnownWrench, ...] = ()


@dataclass(frozen=True, slots=True, kw_only=True)
class BaseMotion:
    """Motion of the kinematic source, in its own axes."""

    omega_rad_s: Point
    domega_rad_s2: Point
    acceleration_m_s2: Point  # proper: what an accelerometer reads, +9.81 upwards at rest


def standing(
    hands: Sequence[str] = ("l_hand", "r_hand"), feet: Sequence[str] = ("l_foot", "r_foot")
) -> Assumption:
    """The paper's first set: held by the mainstay, touched at the ends of the limbs."""
    return Assumption(contacts=tuple(Contact(frame=frame) for frame in (*hands, *feet)))


def crawling(
    source: str = "imu_frame",
    wrists: Sequence[str] = ("l_wrist_1", "r_wrist_1"),
    knees: Sequence[str] = ("l_lower_leg", "r_lower_leg"),
) -> Assumption:
    """The paper's second set: no mainstay, carried by wrists and knees, moving with the IMU."""
    contacts = tuple(Contact(frame=frame) for frame in (*wrists, *knees))
    return Assumption(contacts=contacts, source=source, mainstay=False)


def _require_finite(name: str, values: Sequence[float], size: int) -> None:
    if len(values) != size or not all(math.isfinite(value) for value in values):
        raise AssumptionError(f"{name}: expected {size} finite numbers, got {tuple(values)}")
