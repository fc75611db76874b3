"""The virtual torque sensors that the host broadcasts, and what happens when their torques stop.

A board whose force-controlled axis hears no torque for 200 ms faults and the limb goes limp. So
after 60 ms without a fresh estimate the axes are made stiff, and the last torques are repeated
until every board has confirmed it.

DELIBERATE: the iCub's PC also answers whoever asks such a sensor for its full scales. No board
does, so nobody is answered here.
"""

from collections.abc import Sequence

from hal.axis import POWERED, Axis
from hal.faults import FaultLog
from hal.line import Line
from hal.stalls import Stalls
from hal.wire import motor
from hal.wire.analog import CHANNELS, virtual_torque_frames
from hal.wire.modes import ControlMode, InteractionMode

STALE_NS = 60_000_000
NEVER_NS = -(1 << 62)
LOOK_NS = 4_000_000  # for an axis that becomes force controlled while there are no torques
REPEAT_NS = 10_000_000  # of the last torques, and of the commands that make stiff, until confirmed


class VirtualSensor:
    """One virtual sensor: up to six joint torques in two frames."""

    def __init__(
        self,
        line: Line,
        address: int,
        axes: Sequence[Axis],
        faults: FaultLog,
        stalls: Stalls,
    ) -> None:
        """`axes` are those that take their torque from it."""
        self.line = line
        self.axes = tuple(axes)
        self.fresh_ns = NEVER_NS  # arrival of the FT sample behind the last torques
        self.is_falling_back = False
        self.address = address
        self._faults = faults
        self._stalls = stalls
        self._torques_nm = [0.0] * CHANNELS
        self._full_scales_nm = [1.0] * CHANNELS
        self._channel: dict[int, int] = {}
        for axis in axes:
            source = axis.joint.torque_source
            if source is not None:
                self._channel[axis.index] = source.channel
                self._full_scales_nm[source.channel] = source.full_scale_nm
        self._due = False
        self._repeat_ns = 0

    def set(self, joint: int, tau_nm: float) -> bool:
        """Take the torque of one joint; False when it has no channel here."""
        channel = self._channel.get(joint)
        if channel is None:
            return False
        self._torques_nm[channel] = tau_nm
        return True

    def refresh(self, arrival_ns: int) -> None:
        """The torques are complete: send both frames with this step."""
        self.fresh_ns = arrival_ns
        self._due = True

    def is_fresh(self, now_ns: int) -> bool:
        """Whether a force-controlled axis may rely on the torques."""
        return self._stalls.age_ns(now_ns, self.fresh_ns) <= STALE_NS

    def step(self, now_ns: int) -> bool:
        """Watch the age, send what is due; True when new torques left."""
        if not self.is_fresh(now_ns):
            self._fall_back(now_ns)
        elif self.is_falling_back:
            self.is_falling_back = False
            self._repeat_ns = 0
        if self._due:
            self._due = False
            self._send()
            return True
        return False

    def _send(self) -> None:
        first, second, clamped = virtual_torque_frames(
            self.address, self._torques_nm, self._full_scales_nm
        )
        for _ in range(clamped):
            self._faults.clamp("joint torque")
        self.line.broadcast(first)
        self.line.broadcast(second)

    def _fall_back(self, now_ns: int) -> None:
        if now_ns < self._repeat_ns:
            return
        driven = [axis for axis in self.axes if is_force_controlled(axis)]
        if not driven:
            self.is_falling_back = False
            self._repeat_ns = now_ns + LOOK_NS
            return
        if not self.is_falling_back:
            names = ", ".join(axis.name for axis in driven)
            age = f"torques {(now_ns - self.fresh_ns) / 1e9:.3f} s old"
            if self.fresh_ns == NEVER_NS:
                age = "no torques"
            self._faults.report(now_ns, f"{age}: {names} made stiff")
        self.is_falling_back = True
        self._repeat_ns = now_ns + REPEAT_NS
        self._due = True
        for axis in driven:
            make_stiff(axis)


def is_force_controlled(axis: Axis) -> bool:
    """Whether the board needs torques for this axis."""
    return axis.is_compliant or axis.mode == ControlMode.TORQUE


def make_stiff(axis: Axis) -> None:
    """Leave force control or open loop with this step, reference at the present position.

    An axis that this host has not switched on is switched off.
    """
    axis.send(motor.SET_INTERACTION_MODE, InteractionMode.STIFF)
    if axis.mode in (ControlMode.TORQUE, ControlMode.OPENLOOP):
        # Position mode switches on an axis that is off, and the board's last word may be wrong.
        asked_for = axis.wanted_mode in POWERED
        axis.wanted_mode = ControlMode.POSITION if asked_for else ControlMode.IDLE
        axis.send(motor.SET_CONTROL_MODE, axis.wanted_mode)
