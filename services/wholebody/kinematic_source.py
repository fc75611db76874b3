"""How the robot's base moves: not at all, or as an IMU somewhere on it says.

An IMU's angular acceleration is the derivative of its gyroscope. For torques it is that of the
newest reading, from the differentiator that joints have, on the integral of the readings; then the
joints between IMU and base need their accelerations too, else a nod of the head would turn the
robot. The filtered motion has the delay of all filtered signals.
"""

import math

import numpy as np

from dforc.arrays import Vector
from dforc.estimation.assumption import BaseMotion
from dforc.signals.delay_match import MatchedFilter
from dforc.signals.differentiation import GAP_S, Differentiator
from services.core.service import Inputs
from services.messages import Imu
from services.streams import IMU
from services.wholebody.assumed_contacts import source_name
from services.wholebody.body import Body

AGE_S = 0.05  # a few readings
ABSURD = 1000.0  # rad/s, m/s2: a hundred times gravity
# Of the integral, rad: ten times what a step of 1/16 deg/s adds to it in a reading of 10 ms. Less
# makes a still robot restless, more makes the estimate slow.
GYRO_QUANTUM_RAD = 1e-4
NS_TO_S = 1e-9


class KinematicSource:
    """The source in force and its newest motion, unfiltered and filtered."""

    def __init__(self, body: Body) -> None:
        self.streams = tuple(IMU[name] for name in body.imus)
        self.frame = ""  # of the IMU; empty = the base
        self.trouble = ""  # why there is no motion where there should be one
        self.parts: tuple[str, ...] = ()  # whose joints lie between the IMU and the base
        self.motion: BaseMotion | None = None
        self.ddq_rad_s2: Vector = np.zeros(len(body.joints))  # of those joints, of others zero
        self._body = body
        self._name = ""
        self._between: list[int] = []  # joints
        self._joints = Differentiator(0)
        self._gyro = Differentiator(3, quantum_rad=GYRO_QUANTUM_RAD)
        self._turned: Vector = np.zeros(3)  # integral of the gyroscope, rad
        self._last: tuple[Vector, float] = (np.zeros(3), -math.inf)  # gyroscope, instant
        self._filter = MatchedFilter(6)

    def use(self, frame: str) -> None:
        """Take the motion from here from now on."""
        above = set(self._body.tree.joints_above(frame)) if frame else set()
        self.frame = frame
        self._name = source_name(self._body, frame) if frame else ""
        self.parts = tuple(part.name for part in self._body.parts if above & set(part.joints))
        self.motion = None
        self.trouble = f"no readings of {self._name}" if frame else ""
        self.ddq_rad_s2 = np.zeros(len(self._body.joints))
        self._between = [i for i, joint in enumerate(self._body.joints) if joint in above]
        self._joints = Differentiator(len(self._between))
        self._gyro.reset()
        self._filter.reset()

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
        elif self.motion is None:
            self.trouble = f"readings of {self._name} cannot be believed"
        else:
            self.trouble = ""

    def add_joints(self, q_rad: Vector, now_ns: int) -> None:
        """A step's new joint states."""
        if self._between:
            motion = self._joints.add(q_rad[self._between], now_ns * NS_TO_S)
            self.ddq_rad_s2[self._between] = motion.ddq_rad_s2

    def filtered(self, now_ns: int) -> BaseMotion | None:
        """The motion with the delay of all filtered signals; None where there is none."""
        if self.motion is None or not self._filter.settled:
            return None
        at_s = now_ns * NS_TO_S
        return _motion(self._filter.value(at_s), self._filter.slope(at_s)[:3])

    @property
    def is_ready(self) -> bool:
        """Whether the base's motion is known."""
        return not self.frame or self.motion is not None

    def _accept(self, now_ns: int, reading: Imu) -> None:
        values = reading.gyro_rad_s + reading.acceleration_m_s2
        if not math.hypot(*values) < ABSURD:  # also fails for what is not finite
            self.motion = None
            return
        row: Vector = np.array(values)
        at_s = now_ns * NS_TO_S
        self.motion = _motion(row, self._angular_acceleration(row[:3], at_s))
        self._filter.push(row, at_s)

    def _angular_acceleration(self, omega_rad_s: Vector, at_s: float) -> Vector:
        last, last_s = self._last
        step_s = at_s - last_s
        if step_s <= GAP_S:  # else the differentiator starts anew
            self._turned = self._turned + 0.5 * step_s * (last + omega_rad_s)
        self._last = omega_rad_s, at_s
        return self._gyro.add(self._turned, at_s).ddq_rad_s2


def _motion(values: Vector, domega_rad_s2: Vector) -> BaseMotion:
    """Of gyroscope and accelerometer (6,)."""
    wx, wy, wz, ax, ay, az = values.tolist()
    dx, dy, dz = domega_rad_s2.tolist()
    return BaseMotion(
        omega_rad_s=(wx, wy, wz),
        domega_rad_s2=(dx, dy, dz),
        acceleration_m_s2=(ax, ay, az),
    )
