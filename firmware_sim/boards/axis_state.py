"""One axis of a motor board: names for its row in the bank, and what commands do to its mode."""

from firmware_sim.boards.axis import AxisPort
from firmware_sim.boards.bank import AxisBank
from firmware_sim.boards.fields import (
    ACCELERATION_SETTING,
    BOARD,
    BOARD_FIRST,
    CALIBRATED,
    COMPLIANT,
    CURRENT_LIMIT_MA,
    DAMPS_SPEED,
    DESIRED_TORQUE,
    DROPS_INTEGRAL,
    DUTY,
    DUTY_LIMIT,
    DUTY_STEP,
    ENABLED,
    ENCODER_MASK,
    ENCODER_OFFSET,
    EXTRA_DAMPING,
    FAULT_ENTRIES,
    FAULTS_ONCE,
    FORCE_CONTROLLED,
    FROM_HALL,
    HALL_TICKS,
    I2T,
    I2T_SHIFT,
    I2T_TRIP,
    MAX_DUTY,
    MAX_VELOCITY,
    MODE,
    MOTOR_HIGH,
    MOTOR_LOW,
    MOVED,
    OPENLOOP_PWM,
    PEERS,
    PID_FLAGS,
    POSITION,
    POSITION_PID,
    PULSES_STICTION,
    PWM,
    PWM_LIMIT,
    PWM_WANTED,
    REFERENCE_HISTORY,
    SAMPLES,
    SCALES_SPEED,
    SPEED,
    SPEED_SHIFT,
    SPEED_WINDOW,
    STICTION_DOWN,
    STICTION_UP,
    STICTION_WINDOW_MS,
    TORQUE_CHANNEL,
    TORQUE_SOURCE,
    TRIP_MA,
    UNDEFINED_MODE,
    VELOCITY_SETTING,
    WAS_ENABLED,
)
from firmware_sim.boards.hardware import AxisWiring, Encoder, Hardware
from firmware_sim.boards.kernel import rebase
from firmware_sim.boards.kernel_modes import fault, idle, switch_off
from firmware_sim.boards.modes import ALWAYS_TORQUE, IDLE, IMPEDANCE, TORQUE_WHEN_COMPLIANT
from firmware_sim.boards.node import Node, Pair
from firmware_sim.boards.pid import Pid
from firmware_sim.boards.torque import Impedance, TorqueLoop
from firmware_sim.boards.trajectory import Reference
from firmware_sim.boards.view import Flag, View, Word

_ENCODER_MASK = {Encoder.ABSOLUTE: 0xFFF, Encoder.INCREMENTAL: -1}
_NEVER_TRIPS_MA = 1 << 31
_FAR_TICKS = 1 << 62


class Axis(View):
    """One axis: its methods keep mode and bridge consistent, laws and commands work on it."""

    __slots__ = (
        "_bank",
        "creep",
        "creep_ms",
        "creep_position",
        "creep_pwm",
        "debug",
        "hardware",
        "impedance",
        "index",
        "node",
        "number",
        "pair",
        "peers",
        "port",
        "position_pid",
        "reference",
        "row_number",
        "torque_loop",
        "wiring",
    )

    mode = Word(MODE)
    compliant = Flag(COMPLIANT)
    force_controlled = Flag(FORCE_CONTROLLED)
    undefined_mode = Flag(UNDEFINED_MODE)
    enabled = Flag(ENABLED)  # what the board asks of the bridge
    was_enabled = Flag(WAS_ENABLED)
    calibrated = Flag(CALIBRATED)
    pid_flags = Word(PID_FLAGS)
    faults_once = Word(FAULTS_ONCE)
    fault_entries = Word(FAULT_ENTRIES)
    i2t = Word(I2T)
    current_limit_ma = Word(CURRENT_LIMIT_MA)
    encoder_offset = Word(ENCODER_OFFSET)
    hall_ticks = Word(HALL_TICKS)  # input of an axis whose position comes from Hall sensors
    motor_low = Word(MOTOR_LOW)  # limits of port.raw_encoder: not driven further out
    motor_high = Word(MOTOR_HIGH)
    position = Word(POSITION)
    moved = Word(MOVED)
    speed_shift = Word(SPEED_SHIFT)
    max_velocity = Word(MAX_VELOCITY)
    velocity_setting = Word(VELOCITY_SETTING)
    acceleration_setting = Word(ACCELERATION_SETTING)
    stiction_up = Word(STICTION_UP)
    stiction_down = Word(STICTION_DOWN)
    desired_torque = Word(DESIRED_TORQUE)
    extra_damping = Word(EXTRA_DAMPING)  # PWM for the speed, shifted as the torque loop
    openloop_pwm = Word(OPENLOOP_PWM)
    pwm_wanted = Word(PWM_WANTED)  # before the coupling of motors
    pwm = Word(PWM)  # after every limit
    duty = Word(DUTY)  # what the bridge has reached
    duty_limit = Word(DUTY_LIMIT)

    def __init__(
        self, number: int, hardware: Hardware, wiring: AxisWiring, node: Node, pair: Pair
    ) -> None:
        """`number` counts the board's axes; `attach_to` and `boot` make the axis usable."""
        self.number = number
        self.index = number % 2  # within the address
        self.hardware = hardware
        self.wiring = wiring
        self.node = node
        self.pair = pair
        self.peers: tuple[Axis, ...] = ()  # powered together with this one, this one left out
        self.port = AxisPort()
        self.position_pid = Pid(POSITION_PID)
        self.torque_loop = TorqueLoop()
        self.impedance = Impedance()
        self.reference = Reference()

    def attach_to(self, bank: AxisBank, board: int, first: int) -> None:
        """Live in a bank: the row of the board, and the row in which its axes begin."""
        self._bank = bank
        self.row_number = first + self.number
        row = bank.rows[self.row_number]
        self.attach(row)
        for part in (
            self.port,
            self.position_pid,
            self.torque_loop,
            self.impedance,
            self.reference,
        ):
            part.attach(row)
        self.words[BOARD] = board
        self.words[BOARD_FIRST] = first

    def write_constants(self) -> None:
        """Put into the row what board and firmware say."""
        words, hardware = self.words, self.hardware
        words[MAX_DUTY] = hardware.max_duty
        words[DUTY_STEP] = hardware.duty_step
        words[SAMPLES] = hardware.derivative_samples
        words[SPEED_WINDOW] = hardware.speed_window_ms
        words[SCALES_SPEED] = hardware.scales_speed
        words[DAMPS_SPEED] = hardware.damps_speed
        words[PULSES_STICTION] = hardware.pulses_stiction
        words[DROPS_INTEGRAL] = hardware.drops_integral
        words[I2T_SHIFT] = hardware.i2t_shift
        words[I2T_TRIP] = hardware.i2t_trip
        words[TRIP_MA] = _NEVER_TRIPS_MA if hardware.trip_ma is None else hardware.trip_ma
        words[ENCODER_MASK] = -1 if self.wiring.hall else _ENCODER_MASK[self.wiring.encoder]
        words[FROM_HALL] = bool(self.wiring.hall)

    def power_with(self, peers: tuple["Axis", ...]) -> None:
        """Be enabled and disabled together with some axes of the board, this one left out."""
        self.peers = peers
        self.words[PEERS] = sum(1 << peer.number for peer in peers)

    def boot(self) -> None:
        """State at power-up: idle, not calibrated, gains of an unconfigured board."""
        self.mode = IDLE
        self.compliant = self.force_controlled = self.undefined_mode = False
        self.calibrated = False
        self.pid_flags = self.faults_once = self.i2t = 0
        self.position_pid.boot(kp=10, kd=40, ki=0, shift=3)
        self.stiction_up = self.stiction_down = 0
        self.torque_loop.boot()
        self.impedance.boot()
        self.reference.boot()
        self.velocity_setting = self.acceleration_setting = 0
        self.max_velocity = 0x7FFF
        self.pwm_limit = 1333
        self.current_limit_ma = self.hardware.max_current_limit_ma
        self.speed_shift = 5
        self.debug: dict[int, int] = {}
        self.desired_torque = self.openloop_pwm = self.extra_damping = 0
        self.creep = self.creep_ms = self.creep_position = self.creep_pwm = 0
        self.set_torque_source(self.wiring.torque_source)
        counts = self.wiring.encoder is Encoder.INCREMENTAL and not self.wiring.hall
        self.encoder_offset = self.port.raw_encoder if counts else 0
        self.hall_ticks = 0
        self.motor_low, self.motor_high = -_FAR_TICKS, _FAR_TICKS
        self.pwm_wanted = 0
        self.switch_off()
        self.rebase()
        self._restart_references()

    @property
    def pwm_limit(self) -> int:
        """Last limit before the bridge, counts."""
        return self.words[PWM_LIMIT]

    @pwm_limit.setter
    def pwm_limit(self, counts: int) -> None:
        self.words[PWM_LIMIT] = counts
        self.duty_limit = max(0, min(counts, self.hardware.max_duty))

    def set_torque_source(self, source: tuple[int, int] | None) -> None:
        """Take the joint torque from a virtual sensor's channel, or from nowhere."""
        row = -1
        if source is not None:
            address, channel = source
            row = self.node.hear(address)
            self.words[TORQUE_CHANNEL] = channel
        self.words[TORQUE_SOURCE] = row

    def rebase(self) -> None:
        """Begin afresh after a jump of the encoder's zero: speed counts from here."""
        rebase(self._bank.rows, self._bank.boards, self._bank.mixing, self.row_number)

    def speed(self) -> int:
        """Speed estimate: ticks/ms * 2^speed_shift over 29 ms (BLL), ticks of the last ms (4DC)."""
        return self.words[SPEED]

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
        self._restart_references()
        self.position_pid.clear()
        self.torque_loop.pid.clear()
        if not self.force_controlled:
            self.torque_loop.start_filter(self.pwm)
        self.impedance.clear()
        self.desired_torque = 0
        self.openloop_pwm = 0
        self.force_controlled = self.mode in ALWAYS_TORQUE or (
            self.compliant and self.mode in TORQUE_WHEN_COMPLIANT
        )

    def idle(self) -> None:
        """Bridge off, IDLE; that of the peers too."""
        idle(self._bank.rows, self.row_number)

    def fault(self) -> None:
        """Bridge off, HW_FAULT; the peers drop to IDLE."""
        fault(self._bank.rows, self.row_number)

    def switch_off(self) -> None:
        """Take the bridge down at once."""
        switch_off(self.row)

    def _restart_references(self) -> None:
        position = self.position
        for place in range(REFERENCE_HISTORY, REFERENCE_HISTORY + STICTION_WINDOW_MS):
            self.words[place] = position
