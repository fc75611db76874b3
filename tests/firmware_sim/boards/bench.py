"""One motor board on a table: the host's commands, the wires, and no motor."""

from firmware_sim.boards.axis_state import Axis
from firmware_sim.boards.board import Board
from firmware_sim.description import BoardSpec
from firmware_sim.registry import make_board
from hal.wire import motor, motor_periodic
from hal.wire.analog import FORCE, TORQUE, ZERO_WORD
from hal.wire.can import Frame, class_of, low_of, source_of
from hal.wire.message import AxisCommand, PeriodicMessage
from hal.wire.modes import ControlMode

SPECS = {
    "bll_ie": BoardSpec(bus=2, address=1, type="bll_ie", firmware=(0x02, 0x50), coupled=False),
    "dc4": BoardSpec(bus=2, address=3, type="dc4", firmware=(0x02, 0x19), coupled=False),
}
"""One board of each registered type."""

PLAIN = 1
"""An axis with absolute encoder, calibration type 3 and a torque source, on every board."""

STATUS_MASK = motor_periodic.STATUS.mask_bit
PRINT_MASK = motor_periodic.PRINT.mask_bit

POSITION_GAINS = (1000, 0, 0, 6)  # kp, ki, kd, shift
POSITION_LIMITS = (0, 700, 700)  # offset, output limit, integral limit


class Bench:
    """A board, and a host that speaks to it. Axes are numbered over the whole board."""

    def __init__(self, kind: str, spec: BoardSpec | None = None) -> None:
        self.board: Board = make_board(spec or SPECS[kind])
        self.address = self.board.addresses[0]
        for port in self.board.ports:
            port.raw_encoder = 2000

    def axis(self, number: int = PLAIN) -> Axis:
        return self.board.axes[number]

    def send(self, command: AxisCommand, *values: int, axis: int = PLAIN) -> None:
        self.give(command.request(self.address + axis // 2, axis % 2, *values))

    def give(self, frame: Frame) -> None:
        assert self.board.accepts(frame[0])
        self.board.on_frame(*frame)

    def tick(self, milliseconds: int = 1) -> list[Frame]:
        return [frame for _ in range(milliseconds) for frame in self.board.tick()]

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
            self.do(motor.SET_BCAST_POLICY, mask, axis=axis)
        return self

    def calibrate(self, axis: int = PLAIN) -> "Bench":
        """Type 3 to where the axis stands; leaves it running in POSITION."""
        self.do(motor.CALIBRATE_ENCODER, 3, self.board.ports[axis].raw_encoder, 10, 0, axis=axis)
        assert self.axis(axis).mode == ControlMode.POSITION
        return self

    def ready(self, mask: int = 0) -> "Bench":
        """Configured, and the plain axis calibrated."""
        return self.configure(mask).calibrate()

    def enter(self, mode: ControlMode, axis: int = PLAIN) -> "Bench":
        self.do(motor.SET_CONTROL_MODE, mode, axis=axis)
        return self

    def hear_torque(self, torque: int = 0, axis: int = PLAIN) -> None:
        """Virtual torque frame with this torque (units) for the axis."""
        source = self.axis(axis).wiring.torque_source
        assert source is not None
        address, channel = source
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
