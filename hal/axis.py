"""One motor axis as the host knows it: its state, read from frames, and the commands it takes."""

import math
from collections import deque
from collections.abc import Callable, Sequence

from hal.description import Joint
from hal.line import Line
from hal.readings import JointReadings
from hal.units import AxisUnits
from hal.wire.message import AxisCommand
from hal.wire.modes import ControlMode, InteractionMode
from hal.wire.motor import SET_IMPEDANCE_OFFSET

WINDOW = 7  # POSITION frames behind a velocity estimate: about 30 ms, as on BLL boards
WINDOW_COUNT = 1 / 29  # ticks/ms that the window resolves; coarser VELOCITY frames are not used
PERIOD_S = 0.004  # between two POSITION frames
FASTEST_RAD_S = math.radians(1000.0)  # no joint is: 4 degrees from frame to frame

POWERED = frozenset(
    {
        ControlMode.POSITION,
        ControlMode.VELOCITY,
        ControlMode.TORQUE,
        ControlMode.IMPEDANCE_POSITION,
        ControlMode.IMPEDANCE_VELOCITY,
        ControlMode.MIXED,
        ControlMode.DIRECT,
        ControlMode.OPENLOOP,
        ControlMode.CALIBRATION,
    }
)


class Axis:
    """State of one axis; `index` is its place in the robot description.

    `mode` and `interaction` are what the board last reported, NO_REQUEST and UNKNOWN before. While
    `switching` the board is about to clear its references, so no set-point goes out.
    """

    __slots__ = (
        "_doubted",
        "_readings",
        "_uses_velocity_frames",
        "_velocity_rad_s",
        "_window",
        "address",
        "calibrating",
        "calibration_failure",
        "fault_bits",
        "full_pwm",
        "heard_ns",
        "index",
        "interaction",
        "joint",
        "line",
        "mode",
        "number",
        "offset_counts",
        "on_change",
        "on_limits",
        "partners",
        "replies",
        "said",
        "said_ns",
        "suspects",
        "switching",
        "ticks",
        "units",
        "wanted_mode",
    )

    def __init__(
        self,
        index: int,
        joint: Joint,
        line: Line,
        readings: JointReadings,
        velocity_shift: int,
        velocity_count: float | None,
        full_pwm: int,
    ) -> None:
        """What depends on the board's type stands last.

        `velocity_count`: ticks/ms of a VELOCITY frame's count, None when none is broadcast.
        `full_pwm`: PWM count of a bridge that is always on.
        """
        self.index = index
        self.joint = joint
        self.line = line
        self.address = joint.address
        self.number = joint.axis
        self.units = AxisUnits(joint, velocity_shift)
        self.ticks = 0
        self.heard_ns = 0
        self.mode: int = ControlMode.NO_REQUEST
        self.wanted_mode: int = ControlMode.NO_REQUEST
        self.interaction: int = InteractionMode.UNKNOWN
        self.fault_bits = 0
        self.switching = False
        self.offset_counts = 0
        self.calibrating = False  # the board has been asked to, and is at it
        self.calibration_failure = ""
        self.full_pwm = full_pwm
        self.partners: tuple[Axis, ...] = ()  # switched together with this one by the firmware
        self.suspects: list[Callable[[int], str]] = []  # why it may fault without a bit, by now_ns
        self.said = ""  # last text that its board has printed
        self.said_ns = 0
        self.replies: dict[int, tuple[int, ...]] = {}
        self.on_change: Callable[[], None] = _nothing
        self.on_limits: Callable[[], None] = _nothing
        self._doubted: int | None = None  # ticks of the last frame, if it was not believed
        self._readings = readings
        count = velocity_count or 0.0
        self._velocity_rad_s = 1000.0 * self.units.rad_per_tick * count
        self._uses_velocity_frames = 0.0 < count <= WINDOW_COUNT
        self._window: deque[tuple[int, int]] = deque(maxlen=WINDOW)

    @property
    def name(self) -> str:
        """The joint's name."""
        return self.joint.name

    @property
    def is_powered(self) -> bool:
        """Whether the bridge is on, as far as the board has said."""
        return self.mode in POWERED

    @property
    def is_compliant(self) -> bool:
        """Whether the board runs the axis as a spring."""
        return self.interaction == InteractionMode.COMPLIANT

    @property
    def can_be_compliant(self) -> bool:
        """Whether the description has everything that compliant mode needs."""
        joint = self.joint
        return None not in (joint.torque_source, joint.impedance, joint.torque_pid)

    @property
    def is_available(self) -> bool:
        """Whether its board is there and gets commands."""
        return self.address not in self.line.muted

    @property
    def calibration(self) -> str:
        """Done, pending, or failed with the reason."""
        if self.is_calibrated:
            return "done"
        return f"failed: {self.calibration_failure}" if self.calibration_failure else "pending"

    @property
    def is_calibrated(self) -> bool:
        """Whether the board has said so."""
        return self._readings.calibrated[self.index]

    def set_calibrated(self, calibrated: bool) -> None:
        """Note what the board says."""
        self._readings.calibrated[self.index] = calibrated

    def set_moving(self, moving: bool) -> None:
        """Note that a movement of the board's own begins or ends."""
        self._readings.moving[self.index] = moving

    @property
    def motion(self) -> tuple[float, float]:
        """Angle and speed, rad and rad/s."""
        return self._readings.q_rad[self.index], self._readings.dq_rad_s[self.index]

    @property
    def recent(self) -> Sequence[tuple[int, int]]:
        """The last POSITION frames, oldest first: ticks, and when they came in ns."""
        return self._window

    @property
    def fault_text(self) -> str:
        """Why the axis does not run, empty when nothing is wrong."""
        return self._readings.fault[self.index]

    def set_fault_text(self, text: str) -> None:
        """Note why the axis does not run, empty when nothing is wrong."""
        self._readings.fault[self.index] = text

    def on_position(self, ticks: int, stamp_ns: int) -> bool:
        """A POSITION frame: ticks after the board's own decoupling.

        A jump that no joint makes is believed when the next frame says the same, as after a board
        has found its zero. False when the frame before turns out to have been wrong.
        """
        doubted, self._doubted = self._doubted, None
        if self.heard_ns and not self._could_reach(ticks, self.ticks, stamp_ns):
            if doubted is None or not self._could_reach(ticks, doubted, self.heard_ns):
                self._doubted = ticks
                return doubted is None
            doubted = None
            self._window.clear()  # the jump was no motion
        self.ticks = ticks
        self.heard_ns = stamp_ns
        units, readings, index = self.units, self._readings, self.index
        readings.q_rad[index] = ticks * units.rad_per_tick - units.zero_rad
        readings.heard_ns[index] = stamp_ns
        window = self._window
        window.append((ticks, stamp_ns))
        if not self._uses_velocity_frames:
            first_ticks, first_ns = window[0]
            if stamp_ns > first_ns:
                rate = (ticks - first_ticks) * 1e9 / (stamp_ns - first_ns)
                readings.dq_rad_s[index] = rate * units.rad_per_tick
        return doubted is None

    def _could_reach(self, ticks: int, before: int, stamp_ns: int) -> bool:
        """Whether a joint gets from one angle to another by now; frames come together at times."""
        passed_s = max((stamp_ns - self.heard_ns) * 1e-9, PERIOD_S)
        return abs((ticks - before) * self.units.rad_per_tick) <= FASTEST_RAD_S * passed_s

    def on_velocity(self, counts: int) -> None:
        """A VELOCITY frame."""
        if self._uses_velocity_frames:
            self._readings.dq_rad_s[self.index] = counts * self._velocity_rad_s

    def on_mode(self, mode: int) -> None:
        """The board reports its control mode."""
        if mode != self.mode:
            self.mode = mode
            self._readings.control_mode[self.index] = mode
            self.on_change()

    def on_interaction(self, interaction: int) -> None:
        """The board reports its interaction mode."""
        if interaction != self.interaction:
            self.interaction = interaction
            self._readings.compliant[self.index] = interaction == InteractionMode.COMPLIANT
            self.on_change()

    def command(self, row: AxisCommand, *values: int) -> None:
        """Queue a command, one per address and millisecond."""
        self.line.command(self.address, row.request(self.address, self.number, *values))

    def send(self, row: AxisCommand, *values: int) -> None:
        """Send a command with this step."""
        self.line.send(self.address, row.request(self.address, self.number, *values))

    def switch(self, row: AxisCommand, value: int) -> None:
        """Queue a mode or interaction switch with the impedance offset directly behind it.

        A switch clears the offset, and a limb without it sags by 1 mm in 10 ms.
        """
        frames = [row.request(self.address, self.number, value)]
        if self.can_be_compliant:
            offset = SET_IMPEDANCE_OFFSET.request(self.address, self.number, self.offset_counts)
            frames.append(offset)
        self.line.command(self.address, *frames)


def _nothing() -> None:
    """What happens on a change before anyone is interested."""
