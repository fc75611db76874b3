"""One motor board on a table: the host's commands, the wires, and no motor."""

from firmware_sim.boards.axis_state import Axis
from firmware_sim.boards.board import Board
from firmware_sim.boards.brushless import BODY_VERSIONS, NECK_VERSIONS
from firmware_sim.boards.dc4 import VERSIONS as DC4_VERSIONS
from firmware_sim.boards.unit import Unit
from firmware_sim.description import BoardSpec
from firmware_sim.registry import make_board
from hal.wire import motor, motor_periodic
from hal.wire.analog import FORCE, TORQUE, ZERO_WORD
from hal.wire.can import Frame, class_of, low_of, source_of
from hal.wire.message import AxisCommand, PeriodicMessage
from hal.wire.modes import CalibrationType, ControlMode

ADDRESSES = {"bll": 1, "bll_ie": 1, "bll_dc": 1, "dc4": 3}
LEG_ADDRESS = 6
VERSIONS = {
    "bll": BODY_VERSIONS,
    "bll_ie": BODY_VERSIONS,
    "bll_dc": NECK_VERSIONS,
    "dc4": DC4_VERSIONS,
}
"""Firmware numbers of each registered type."""


def spec_of(kind: str, major: int, minor: int, *, coupled: bool = False) -> BoardSpec:
    """A board on the bench, where its robot has one of its kind."""
    address = LEG_ADDRESS if minor == 0x51 else ADDRESSES[kind]
    return BoardSpec(bus=2, address=address, type=kind, firmware=(major, minor), coupled=coupled)


SPECS = {
    f"{kind} {major}.{minor:02X}": spec_of(kind, major, minor)
    for kind, versions in VERSIONS.items()
    for major, minor in versions
}
"""Every firmware of every motor board, each axis for itself."""

SPECS["bll_ie"] = SPECS["bll_ie 2.50"]
SPECS["dc4"] = SPECS["dc4 2.19"]

PLAIN = 1
"""The axis that is looked at."""

TORQUE_SOURCE = (12, 1)
"""Where an axis hears its torque on the bench when its firmware names no source."""

STATUS_MASK = motor_periodic.STATUS.mask_bit
PRINT_MASK = motor_periodic.PRINT.mask_bit

POSITION_GAINS = (1000, 0, 0, 6)  # kp, ki, kd, shift
POSITION_LIMITS = (0, 700, 700)  # offset, output limit, integral limit


Pair = tuple[int, int]


def coupled(kind: str, major: int, minor: int) -> "Bench":
    """A bench with a board that couples its axes, configured."""
    return Bench("", spec_of(kind, major, minor, coupled=True)).configure()


class Bench:
    """A board, and a host that speaks to it. Axes are numbered over the whole board."""

    def __init__(self, kind: str, spec: BoardSpec | None = None) -> None:
        self.board: Board = make_board(spec or SPECS[kind])
        self.address = self.board.addresses[0]
        for number in range(len(self.board.axes)):
            self.place(2000, axis=number)

    @property
    def unit(self) -> Unit:
        return self.axis().node.unit

    def place(self, ticks: int, axis: int = PLAIN) -> None:
        """Turn the joint of an uncoupled axis to where its sensor shows so many ticks."""
        self.board.ports[axis].raw_encoder = ticks
        if self.axis(axis).wiring.hall:
            self.axis(axis).hall_ticks = ticks

    def axis(self, number: int = PLAIN) -> Axis:
        return self.board.axes[number]

    def send(self, command: AxisCommand, *values: int, axis: int = PLAIN) -> None:
        self.give(command.request(self.address + axis // 2, axis % 2, *values))

    def give(self, frame: Frame) -> None:
        assert self.board.accepts(frame[0])
        self.board.on_frame(*frame)

    def tick(self, milliseconds: int = 1) -> list[Frame]:
        """Frames of some milliseconds, in which the hand's MAIS is not missed."""
        frames = []
        hall = self.unit.links.hall
        for _ in range(milliseconds):
            if hall is not None:
                hall.silent_ms = 0
            frames += self.board.tick()
        return frames

    def do(self, command: AxisCommand, *values: int, axis: int = PLAIN) -> list[Frame]:
        self.send(command, *values, axis=axis)
        return self.tick()

    def ask(self, command: AxisCommand, *values: int, axis: int = PLAIN) -> tuple[int, ...]:
        frames = self.do(command, *values, axis=axis)
        (reply,) = [frame for frame in frames if class_of(frame[0]) == 0]
        assert reply[0] == (self.address + axis // 2) << 4
        assert reply[1][0] == command.code | axis % 2 << 7
        parsed = command.parse_reply(reply[1])
        assert parsed is not None
        return parsed

    def configure(self, mask: int = 0) -> "Bench":
        """Handshake, gains, limits and mask on every axis."""
        self.do(motor.GET_FIRMWARE_VERSION, 1, 6, axis=0)
        for axis in range(len(self.board.axes)):
            self.send(motor.SET_POS_PID, *POSITION_GAINS, axis=axis)
            self.send(motor.SET_POS_PIDLIMITS, *POSITION_LIMITS, axis=axis)
            self.send(motor.SET_TORQUE_PID, 64, 0, 0, 6, axis=axis)
            self.send(motor.SET_TORQUE_PIDLIMITS, 0, 700, 0, axis=axis)
            self.send(motor.SET_MIN_POSITION, 500, axis=axis)
            self.send(motor.SET_MAX_POSITION, 3500, axis=axis)
            if self.axis(axis).wiring.torque_source is None:
                self.send(motor.SET_TORQUE_SOURCE, *TORQUE_SOURCE, axis=axis)
            self.do(motor.SET_BCAST_POLICY, mask, axis=axis)
        return self

    def start(self, axis: int = PLAIN) -> int:
        """Ask for a running axis where it stands; the mode that it comes to."""
        if CalibrationType.DIGITAL_ABSOLUTE in self.axis(axis).wiring.calibrations:
            ticks = self.board.ports[axis].raw_encoder
            self.do(motor.CALIBRATE_ENCODER, 3, ticks, 10, 0, axis=axis)
        else:  # of a 4DC, which runs without
            self.do(motor.SET_CONTROL_MODE, ControlMode.POSITION, axis=axis)
        return self.axis(axis).mode

    def calibrate(self, axis: int = PLAIN) -> "Bench":
        """Calibrated if its firmware asks for it, and running in POSITION."""
        assert self.start(axis) == ControlMode.POSITION
        return self

    def ready(self, mask: int = 0) -> "Bench":
        """Configured, and the plain axis calibrated."""
        return self.configure(mask).calibrate()

    def enter(self, mode: ControlMode, axis: int = PLAIN) -> "Bench":
        self.do(motor.SET_CONTROL_MODE, mode, axis=axis)
        return self

    def hear_partner(self, duties: Pair = (0, 0), positions: Pair = (0, 0)) -> None:
        """Broadcasts of the shoulder's other board."""
        partner = self.unit.firmware.partner
        assert partner is not None
        self.give(motor_periodic.PID_VAL.frame(partner.address, 0, 0, *duties))
        if partner.needs_position:
            self.give(motor_periodic.POSITION.frame(partner.address, *positions))

    def open_loop(self, pwm: int, axis: int = PLAIN) -> None:
        """Drive an axis, calibrated where its board asks for it, with a fixed PWM."""
        self.do(motor.SET_CONTROL_MODE, ControlMode.OPENLOOP, axis=axis)
        self.send(motor.SET_OPENLOOP_PARAMS, pwm, axis=axis)

    def hear_torque(self, torque: int = 0, axis: int = PLAIN) -> None:
        """Virtual torque frame with this torque (units) for the axis."""
        address, channel = self.axis(axis).wiring.torque_source or TORQUE_SOURCE
        words = [ZERO_WORD] * 3
        words[channel % 3] = torque + ZERO_WORD
        row = FORCE if channel < 3 else TORQUE
        self.give(row.frame(address, *words))

    def compliant(self, axis: int = PLAIN) -> "Bench":
        """Torques arrive and the axis is compliant."""
        self.hear_torque(axis=axis)
        self.do(motor.SET_INTERACTION_MODE, 1, axis=axis)
        return self

    def heard(self, frames: list[Frame], row: PeriodicMessage) -> list[Frame]:
        return [
            frame for frame in frames if class_of(frame[0]) == 1 and low_of(frame[0]) == row.type
        ]

    def statuses(self, milliseconds: int) -> list[tuple[int, ...]]:
        """Values of the STATUS frames of the plain axis's address."""
        address = self.axis().pair.address
        return [
            motor_periodic.STATUS.parse(data) or ()
            for can_id, data in self.heard(self.tick(milliseconds), motor_periodic.STATUS)
            if source_of(can_id) == address
        ]

    def texts(self, milliseconds: int) -> str:
        """Text printed meanwhile."""
        pieces = self.heard(self.tick(milliseconds), motor_periodic.PRINT)
        return b"".join(data[2:] for _, data in pieces).decode()
