"""Boards on their buses: who takes which frame, and every board's millisecond.

All motor boards live in one bank: first each acts on what it received, then the axes of all run in
one call, then each says what it has to say.

A frame reaches every other board of its bus whose hardware filter lets it in, in the millisecond
after it was sent.
"""

from collections.abc import Callable, Iterable, Mapping, Sequence

from firmware_sim.boards.axis_state import Axis
from firmware_sim.boards.bank import AxisBank
from firmware_sim.boards.board import Board
from firmware_sim.boards.motor_board import MotorBoard
from firmware_sim.description import AxisSpec, BoardSpec, SensorSpec
from firmware_sim.registry import make_board
from firmware_sim.spoiling import Gate
from hal.wire.can import Frame, Received

Receiver = Callable[[int, bytes], None]
Routes = dict[int, tuple[Receiver, ...]]

MAX_ID = 0x7FF
NO_ROUTES: Routes = {}  # of a bus without boards
AXES_PER_ADDRESS = 2


class RigError(ValueError):
    """The description does not fit together, or the rig was asked for what it has not got."""


class Network:
    """All boards of a robot on their buses."""

    def __init__(self, specs: Sequence[BoardSpec], sensors: Sequence[SensorSpec]) -> None:
        self._boards: dict[tuple[int, int], Board] = {}
        self._types: dict[tuple[int, int], str] = {}
        self._buses: dict[int, list[Board]] = {}
        scales = {(sensor.bus, sensor.address): sensor.full_scale for sensor in sensors}
        for spec in specs:
            self._place(spec, make_board(spec, scales.get((spec.bus, spec.address))))
        motor_boards = [board for board in self._every_board() if isinstance(board, MotorBoard)]
        self.bank = AxisBank(sum(len(b.axes) for b in motor_boards), len(motor_boards))
        for board in motor_boards:
            board.join(self.bank)
            board.on_new_address = self._wire
        self._listening = [board.listen for board in motor_boards]
        self._between: list[tuple[tuple[Receiver, ...], int, bytes]] = []
        self._gates: dict[Board, Gate] = {}  # of boards whose frames a switch spoils
        self._wire()

    def gate(self, board: Board) -> Gate:
        """What lies between a board and its bus, put there now; gone once it changes nothing."""
        gate = self._gates.get(board)
        if gate is None:
            gate = self._gates[board] = Gate(board)
            self._reroute(board.on_frame, gate.on_frame)
        return gate

    def deliver(self, received: Mapping[int, Sequence[Received]]) -> None:
        """Hand to the boards what arrived on each bus and what boards sent each other."""
        for receivers, can_id, data in self._between:
            for receiver in receivers:
                receiver(can_id, data)
        self._between.clear()
        for bus, frames in received.items():
            routes = self._routes.get(bus, NO_ROUTES)
            for can_id, data, _ in frames:
                for receiver in routes.get(can_id, ()):
                    receiver(can_id, data)
        if self._gates:
            for board, gate in tuple(self._gates.items()):
                gate.release()
                if gate.is_idle:
                    self._ungate(board)

    def tick(self) -> dict[int, list[Frame]]:
        """Run one millisecond of every board; frames sent, by bus."""
        sent: dict[int, list[Frame]] = {bus: [] for bus in self._buses}
        for listen in self._listening:
            listen()
        self.bank.control()
        between, gates = self._between, self._gates
        for bus, board, speak, others in self._speaking:
            frames = speak()
            if gates and board in gates:
                frames = gates[board].outward.step(frames)
            if frames:
                sent[bus] += frames
                for can_id, data in frames:
                    receivers = others.get(can_id)
                    if receivers is not None:
                        between.append((receivers, can_id, data))
        self.bank.supervise()
        return sent

    def board(self, bus: int, address: int) -> Board:
        """The board that the description puts at an address.

        Raises:
            RigError: there is none.
        """
        board = self._boards.get((bus, address))
        if board is None:
            known = ", ".join(f"bus {b} address {a}" for b, a in sorted(self._boards))
            raise RigError(f"no board at bus {bus} address {address}; boards: {known}")
        return board

    def axis(self, spec: AxisSpec) -> Axis:
        """The axis that a description wires.

        Raises:
            RigError: the board has no such axis.
        """
        board = self.board(spec.bus, spec.address)
        second = self._boards.get((spec.bus, spec.address - 1)) is board
        index = second * AXES_PER_ADDRESS + spec.axis
        if index >= len(board.axes):
            raise RigError(f"bus {spec.bus} address {spec.address} has no axis {spec.axis}")
        return board.axes[index]

    def row(self, spec: AxisSpec) -> int:
        """Where the axis that a description wires stands in the arrays of `bank`.

        Raises:
            RigError: the board has no such axis.
        """
        return self.axis(spec).row_number

    def board_type(self, spec: AxisSpec) -> str:
        """Type name of the board behind an axis."""
        return self._types[spec.bus, spec.address]

    def axes(self) -> list[Axis]:
        """Every axis of every board."""
        return [axis for board in self._every_board() for axis in board.axes]

    def boards(self, bus: int) -> tuple[Board, ...]:
        """Every board of a bus."""
        return tuple(self._buses.get(bus, ()))

    def _wire(self) -> None:
        """Find out who takes what: at the start, and when a board was given another address."""
        self._routes = {bus: self._routes_to(boards) for bus, boards in self._buses.items()}
        self._speaking = [
            (
                bus,
                board,
                _speech(board),
                self._routes_to(other for other in boards if other is not board),
            )
            for bus, boards in self._buses.items()
            for board in boards
        ]

    def _routes_to(self, boards: Iterable[Board]) -> Routes:
        """Who takes a frame, by identifier; identifiers that nobody takes are left out."""
        kept = list(boards)
        routes: Routes = {}
        for can_id in range(MAX_ID + 1):
            receivers = tuple(self._receiver(b) for b in kept if b.accepts(can_id))
            if receivers:
                routes[can_id] = receivers
        return routes

    def _receiver(self, board: Board) -> Receiver:
        gate = self._gates.get(board)
        return board.on_frame if gate is None else gate.on_frame

    def _every_board(self) -> list[Board]:
        return [board for boards in self._buses.values() for board in boards]

    def _ungate(self, board: Board) -> None:
        gate = self._gates.pop(board)
        self._reroute(gate.on_frame, board.on_frame)

    def _reroute(self, old: Receiver, new: Receiver) -> None:
        for routes in (*self._routes.values(), *(others for *_, others in self._speaking)):
            for can_id, receivers in routes.items():
                if old in receivers:
                    routes[can_id] = _exchanged(receivers, old, new)
        self._between = [
            (_exchanged(receivers, old, new), can_id, data)
            for receivers, can_id, data in self._between
        ]

    def _place(self, spec: BoardSpec, board: Board) -> None:
        for address in board.addresses:
            if (spec.bus, address) in self._boards:
                raise RigError(f"two boards claim bus {spec.bus} address {address}")
            self._boards[spec.bus, address] = board
            self._types[spec.bus, address] = spec.type
        self._buses.setdefault(spec.bus, []).append(board)


def _exchanged(
    receivers: tuple[Receiver, ...], old: Receiver, new: Receiver
) -> tuple[Receiver, ...]:
    return tuple(new if receiver == old else receiver for receiver in receivers)


def _speech(board: Board) -> Callable[[], list[Frame]]:
    """A motor board runs with all others, and speaks afterwards."""
    return board.speak if isinstance(board, MotorBoard) else board.tick
