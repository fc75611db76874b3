"""State of one axis of a motor board: settings, mode, what it measures and what it drives."""

from firmware_sim.boards.axis import AxisPort
from firmware_sim.boards.hardware import AxisWiring, Encoder, Hardware
from firmware_sim.boards.law import I16_MAX, Pid, divide, saturate_i16
from firmware_sim.boards.modes import (
    ALWAYS_TORQUE,
    HW_FAULT,
    IDLE,
    IMPEDANCE,
    TORQUE_WHEN_COMPLIANT,
)
from firmware_sim.boards.node import Node, Pair, TorqueSensor
from firmware_sim.boards.torque import Impedance, TorqueLoop
from firmware_sim.boards.trajectory import Reference
from hal.wire.motor_periodic import AxisFault

_ENCODER_MASK = {Encoder.ABSOLUTE: 0xFFF, Encoder.INCREMENTAL: -1}
_HALL_BITS = (AxisFault.HALL_A, AxisFault.HALL_B, AxisFault.HALL_C)
STICTION_WINDOW_MS = 29  # the sign of the commanded velocity is taken over this time


class Axis:
    """One axis: its methods keep mode and bridge consistent, laws and commands work on it."""

    __slots__ = (
        "_encoder_mask",
        "_history",
        "_pwm_limit",
        "acceleration_setting",
        "calibrated",
        "compliant",
        "creep",
        "creep_ms",
        "creep_position",
        "creep_pwm",
        "current_limit_ma",
        "debug",
        "desired_torque",
        "duty",
        "duty_limit",
        "enabled",
        "encoder_offset",
        "fault_entries",
        "faults_once",
        "force_controlled",
        "hardware",
        "i2t",
        "impedance",
        "index",
        "max_velocity",
        "mode",
        "moved",
        "node",
        "openloop_pwm",
        "pair",
        "pid_flags",
        "port",
        "position",
        "position_pid",
        "pwm",
        "pwm_wanted",
        "reference",
        "reference_history",
        "speed_shift",
        "stiction_down",
        "stiction_up",
        "torque_loop",
        "torque_place",
        "torque_sensor",
        "undefined_mode",
        "velocity_setting",
        "was_enabled",
        "wiring",
    )

    def __init__(
        self, index: int, hardware: Hardware, wiring: AxisWiring, node: Node, pair: Pair
    ) -> None:
        """`index` is 0 or 1 within the address."""
        self.index = index
        self.hardware = hardware
        self.wiring = wiring
        self.node = node
        self.pair = pair
        self.port = AxisPort()
        self.fault_entries = 0  # times this axis went into HW_FAULT
        self._encoder_mask = _ENCODER_MASK[wiring.encoder]
        self.boot()

    def boot(self) -> None:
        """State at power-up: idle, not calibrated, gains of an unconfigured board."""
        hardware = self.hardware
        self.mode = IDLE
        self.compliant = False
        self.force_controlled = False  # the torque law runs, now or as soon as the mode is entered
        self.undefined_mode = False
        self.enabled = False  # what the board asks of the bridge
        self.was_enabled = False  # the same at the end of the millisecond before
        self.calibrated = False
        self.pid_flags = 0
        self.faults_once = 0  # AxisFault bits reported once, then cleared
        self.i2t = 0
        self.position_pid = Pid(
            hardware.derivative_samples, kp=10, kd=40, ki=0, shift=3, integral_limit=0x7FFF
        )
        self.stiction_up = 0
        self.stiction_down = 0
        self.torque_loop = TorqueLoop(hardware.derivative_samples)
        self.impedance = Impedance(hardware.derivative_samples)
        self.reference = Reference()
        self.reference_history = [0] * STICTION_WINDOW_MS
        self.velocity_setting = 0
        self.acceleration_setting = 0
        self.max_velocity = 0x7FFF
        self.pwm_limit = 1333
        self.current_limit_ma = hardware.max_current_limit_ma
        self.speed_shift = 5
        self.debug: dict[int, int] = {}
        self.desired_torque = 0
        self.openloop_pwm = 0
        self.creep = self.creep_ms = self.creep_position = self.creep_pwm = 0
        self.set_torque_source(self.wiring.torque_source)
        incremental = self.wiring.encoder is Encoder.INCREMENTAL
        self.encoder_offset = self.port.raw_encoder if incremental else 0
        self.pwm_wanted = 0  # before the coupling of motors
        self.pwm = 0  # after every limit
        self.duty = 0  # what the bridge has reached
        self.rebase()
        self.switch_off()

    @property
    def pwm_limit(self) -> int:
        """Last limit before the bridge, counts."""
        return self._pwm_limit

    @pwm_limit.setter
    def pwm_limit(self, counts: int) -> None:
        self._pwm_limit = counts
        self.duty_limit = max(0, min(counts, self.hardware.max_duty))

    def set_torque_source(self, source: tuple[int, int] | None) -> None:
        """Take the joint torque from a virtual sensor's channel, or from nowhere."""
        self.torque_sensor: TorqueSensor | None = None
        self.torque_place = (0, 0)  # frame of the sensor and word in it
        if source is not None:
            address, channel = source
            self.torque_sensor = self.node.sensor(address)
            self.torque_place = divmod(channel, 3)

    def rebase(self) -> None:
        """Begin afresh after a jump of the encoder's zero: speed counts from here."""
        self.position = (self.port.raw_encoder - self.encoder_offset) & self._encoder_mask
        self.moved = 0  # ticks in the speed window
        self._history = [self.position] * self.hardware.speed_window_ms

    def sense(self, slot: int) -> None:
        """Read encoder and drive faults; `slot` counts milliseconds modulo the speed window."""
        port = self.port
        if port.external_fault or port.encoder_fault or port.hall_fault:
            self._sense_faults()
        if not port.encoder_fault:
            self.position = (port.raw_encoder - self.encoder_offset) & self._encoder_mask
        history = self._history
        self.moved = self.position - history[slot]
        history[slot] = self.position

    def _sense_faults(self) -> None:
        port = self.port
        if port.external_fault and self.was_enabled and self.enabled:
            self.idle()  # the hardware has opened the bridge
        if port.encoder_fault:
            self.fault()
        if port.hall_fault and self.mode != HW_FAULT:
            self.faults_once |= sum(
                bit for number, bit in enumerate(_HALL_BITS) if port.hall_fault >> number & 1
            )
            self.fault()

    def speed(self) -> int:
        """Speed estimate: ticks/ms * 2^speed_shift over 29 ms (BLL), ticks of the last ms (4DC)."""
        speed = self.moved
        if self.hardware.scales_speed:
            speed = divide(speed << self.speed_shift, self.hardware.speed_window_ms)
        return speed if -0x8000 <= speed <= I16_MAX else saturate_i16(speed)

    def enter(self, mode: int) -> None:
        """Run in a mode, bridge on. A different mode starts from where the axis is."""
        changed = mode != self.mode
        self.mode = mode
        if mode in IMPEDANCE:
            self.compliant = True
        self.enabled = True
        if changed:
            self.undefined_mode = False
            self.clear()

    def set_compliant(self, compliant: bool) -> None:
        """Change the interaction mode; a real change starts from where the axis is."""
        if compliant != self.compliant:
            self.compliant = compliant
            self.clear()

    def clear(self) -> None:
        """Hold the present position; forget velocity, torque, offset, PWM and integral."""
        self.reference.hold(self.position)
        self.reference_history[:] = [self.position] * STICTION_WINDOW_MS
        self.position_pid.clear()
        self.torque_loop.pid.clear()
        if not self.force_controlled:
            self.torque_loop.low_pass.start(self.pwm)
        self.impedance.clear()
        self.desired_torque = 0
        self.openloop_pwm = 0
        self.force_controlled = self.mode in ALWAYS_TORQUE or (
            self.compliant and self.mode in TORQUE_WHEN_COMPLIANT
        )

    def idle(self) -> None:
        """Bridge off, IDLE."""
        self.mode = IDLE
        self.switch_off()

    def fault(self) -> None:
        """Bridge off, HW_FAULT."""
        if self.mode != HW_FAULT:
            self.fault_entries += 1
        self.mode = HW_FAULT
        self.switch_off()

    def switch_off(self) -> None:
        """Take the bridge down at once."""
        self.enabled = self.was_enabled = False
        self.force_controlled = False
        self.pwm = self.duty = 0
        self.port.pwm = 0
        self.port.enabled = False
