"""How the robot's base moves: not at all, or as an IMU somewhere on it says.

The IMU's angular acceleration is taken as zero: differentiating a gyroscope of 16 bits adds more
noise than a robot that is held or stands still has angular acceleration.
"""

import math

from dforc.estimation.assumption import BaseMotion
from dforc.signals.delay_match import MatchedFilter
from services.assumed_contacts import source_name
from services.body import Body
from services.core.service import Inputs
from services.messages import Imu
from services.streams import IMU

AGE_S = 0.05  # a few readings
ABSURD = 1000.0  # rad/s, m/s2: a hundred times gravity
NS_TO_S = 1e-9


class KinematicSource:
    """The source in force and its newest motion, unfiltered and filtered."""

    def __init__(self, body: Body) -> None:
        self.streams = tuple(IMU[name] for name in body.imus)
        self.frame = ""  # of the IMU; empty = the base
        self.trouble = ""  # why there is no motion where there should be one
        self.parts: tuple[str, ...] = ()  # whose joints lie between the IMU and the base
        self.motion: BaseMotion | None = None
        self._body = body
        self._name = ""
        self._filter = MatchedFilter(6)
        self._is_filled = False

    def use(self, frame: str) -> None:
        """Take the motion from here from now on."""
        above = set(self._body.tree.joints_above(frame)) if frame else set()
        self.frame = frame
        self._name = source_name(self._body, frame) if frame else ""
        self.parts = tuple(part.name for part in self._body.parts if above & set(part.joints))
        self.motion = None
        self.trouble = f"no readings of {self._name}" if frame else ""
        self._filter.reset()
        self._is_filled = False

    def take(self, now_ns: int, inputs: Inputs) -> None:
        """Look at what has arrived."""
        if not self.frame:
            return
        stream = IMU[self._name]
        reading = inputs.new(stream)
        if reading is not None:
            self._accept(now_ns, reading)
        if inputs.age_s(stream) > AGE_S:
            self.trouble, self.motion = f"no readings of {self._name}", None
            self._is_filled = False
        elif self.motion is None:
            self.trouble = f"readings of {self._name} cannot be believed"
        else:
            self.trouble = ""

    def filtered(self, now_ns: int) -> BaseMotion | None:
        """The motion with the delay of all filtered signals; None where there is none."""
        if self.motion is None or not self._is_filled:
            return None
        return _motion(tuple(self._filter.value(now_ns * NS_TO_S).tolist()))

    @property
    def is_ready(self) -> bool:
        """Whether the base's motion is known."""
        return not self.frame or self.motion is not None

    def _accept(self, now_ns: int, reading: Imu) -> None:
        values = reading.gyro_rad_s + reading.acceleration_m_s2
        if math.hypot(*values) < ABSURD:  # also fails for what is not finite
            self.motion = _motion(values)
            self._filter.push(values, now_ns * NS_TO_S)
            self._is_filled |= self._filter.settled
        else:
            self.motion = None


def _motion(values: tuple[float, ...]) -> BaseMotion:
    wx, wy, wz, ax, ay, az = values
    return BaseMotion(
        omega_rad_s=(wx, wy, wz),
        domega_rad_s2=(0.0, 0.0, 0.0),
        acceleration_m_s2=(ax, ay, az),
    )
