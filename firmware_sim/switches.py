"""Faults as switches of an emulated robot, between its boards, its drives and its buses.

A frame fault of a bus strikes what passes between the host and the boards (boards still hear each
other); one of a board strikes everything that the board sends and hears.
"""

from collections.abc import Callable, Mapping, Sequence

from firmware_sim.boards.axis import AxisPort
from firmware_sim.boards.board import Board
from firmware_sim.boards.mtb import Mtb
from firmware_sim.boards.sensor_board import SensorBoard
from firmware_sim.boards.strain import Strain
from firmware_sim.network import AXES_PER_ADDRESS, Network, RigError
from firmware_sim.spoiling import Path
from firmware_sim.switch_table import (
    SWITCHES,
    FaultSpec,
    Needs,
    SwitchError,
    SwitchRow,
    Target,
    Undo,
)
from hal.wire.can import Frame, Received

_SENSOR_TYPES: dict[Needs, type[SensorBoard]] = {
    Needs.SENSOR: SensorBoard,
    Needs.FT_SENSOR: Strain,
    Needs.SKIN: Mtb,
}


class Switches:
    """The switches of one robot. While `active` is false nobody has to call anything else.

    Otherwise, each millisecond: `before` with what arrived on the buses, `hold` once the rig has
    set the inputs of the boards, `after` with what they sent.
    """

    def __init__(self, network: Network, buses: Sequence[int]) -> None:
        self.active = False
        self._network = network
        self._on: dict[FaultSpec, Undo] = {}
        self._held: list[Undo] = []
        self._timers: list[tuple[int, Undo]] = []
        self._ms = 0
        self._buses = tuple(buses)
        self._arriving = {bus: Path() for bus in buses}
        self._leaving = {bus: Path() for bus in buses}

    @property
    def on(self) -> tuple[FaultSpec, ...]:
        """What is switched on, oldest first."""
        return tuple(self._on)

    def switch_on(self, spec: FaultSpec) -> str:
        """Switch a fault on, in the place of the same one at the same place; what was done.

        Raises:
            SwitchError: there is no such fault, or not there.
        """
        row = _row(spec)
        target = self._target(row, spec)
        if spec.value is not None and not row.value:
            raise SwitchError(f"{row.name} takes no value")
        if not 0.0 < spec.share <= 1.0 or spec.count < 0 or spec.milliseconds < 0:
            raise SwitchError("a share is above 0 and at most 1; counts and times are not negative")
        for known in self._matching(spec, exactly=True):
            self._on.pop(known)()
        undo = row.do(target, spec)
        if undo is not None:
            self._on[spec] = undo
        self.active = True
        return f"{row.name} at {_place(spec)}: {row.text}"

    def switch_off(self, spec: FaultSpec) -> str:
        """Switch off what is on of this kind at this place; what was done.

        Raises:
            SwitchError: there is no such fault, or it is not on there.
        """
        row = _row(spec)
        matching = self._matching(spec, exactly=False)
        if not matching:
            raise SwitchError(f"{row.name} is not on at {_place(spec)}")
        for known in matching:
            self._on.pop(known)()
        return f"{row.name} off at {_place(spec)}"

    def clear(self) -> None:
        """Everything off."""
        while self._on:
            self._on.popitem()[1]()

    def before(self, received: Mapping[int, Sequence[Received]]) -> Mapping[int, list[Received]]:
        """What gets through to the boards of each bus; boards read no stamps."""
        passed: dict[int, list[Received]] = {}
        for bus, path in self._arriving.items():
            frames = received.get(bus, ())
            if path.is_idle:
                passed[bus] = list(frames)
            else:
                kept = path.step([(can_id, data) for can_id, data, _ in frames])
                passed[bus] = [(can_id, data, 0) for can_id, data in kept]
        return passed

    def hold(self) -> None:
        """Set the inputs that the rig writes each millisecond, and do what is due."""
        self._ms += 1
        for do in self._held:
            do()
        due = [do for when_ms, do in self._timers if when_ms <= self._ms]
        self._timers = [timer for timer in self._timers if timer[0] > self._ms]
        for do in due:
            do()

    def after(self, sent: Mapping[int, list[Frame]]) -> dict[int, list[Frame]]:
        """What gets through to the host from each bus."""
        passed = {
            bus: frames if self._leaving[bus].is_idle else self._leaving[bus].step(frames)
            for bus, frames in sent.items()
        }
        paths = (*self._arriving.values(), *self._leaving.values())
        self.active = bool(self._on or self._timers) or not all(path.is_idle for path in paths)
        return passed

    def _matching(self, spec: FaultSpec, *, exactly: bool) -> list[FaultSpec]:
        """What is on of the same kind and place; unless exactly, None stands for any value."""
        place = (spec.kind, spec.bus, spec.address, spec.axis)
        return [
            known
            for known in self._on
            if (known.kind, known.bus, known.address, known.axis) == place
            and all(
                wanted == is_on or (wanted is None and not exactly)
                for wanted, is_on in (
                    (spec.value, known.value),
                    (spec.can_id, known.can_id),
                )
            )
        ]

    def _target(self, row: SwitchRow, spec: FaultSpec) -> Target:
        boards = self._boards(row, spec)
        return Target(
            boards=boards,
            ports=_ports(row, spec, boards),
            paths=lambda: self._paths(spec, boards),
            hold=self._hold,
            later=lambda ms, do: self._timers.append((self._ms + ms, do)),
        )

    def _boards(self, row: SwitchRow, spec: FaultSpec) -> tuple[Board, ...]:
        if spec.bus is None and row.needs is Needs.ANYTHING and spec.address is None:
            return tuple(board for bus in self._buses for board in self._network.boards(bus))
        if spec.bus is None:
            raise SwitchError(f"{row.name} needs {row.needs.value}")
        if spec.address is None:
            if row.needs not in (Needs.ANYTHING, Needs.BUS_OR_BOARD):
                raise SwitchError(f"{row.name} needs {row.needs.value}")
            boards = self._network.boards(spec.bus)
            if not boards:
                known = ", ".join(str(bus) for bus in self._buses)
                raise SwitchError(f"no emulated board on bus {spec.bus}; buses: {known}")
            return boards
        try:
            board = self._network.board(spec.bus, spec.address)
        except RigError as error:
            raise SwitchError(str(error)) from None
        wanted = _SENSOR_TYPES.get(row.needs)
        if wanted is not None and not isinstance(board, wanted):
            raise SwitchError(f"{row.name} needs {row.needs.value}; {_place(spec)} is none")
        if row.needs in (Needs.AXIS, Needs.MOTOR_BOARD) and not board.ports:
            raise SwitchError(f"{row.name} needs {row.needs.value}; {_place(spec)} has no axes")
        return (board,)

    def _paths(self, spec: FaultSpec, boards: tuple[Board, ...]) -> tuple[Path, ...]:
        if spec.address is None and spec.bus is not None:
            return self._arriving[spec.bus], self._leaving[spec.bus]
        gates = [self._network.gate(board) for board in boards]
        return tuple(path for gate in gates for path in (gate.inward, gate.outward))

    def _hold(self, do: Callable[[], None]) -> Undo:
        self._held.append(do)
        return lambda: self._held.remove(do)


def _row(spec: FaultSpec) -> SwitchRow:
    row = SWITCHES.get(spec.kind)
    if row is None:
        raise SwitchError(f"unknown fault {spec.kind!r}; known: {', '.join(SWITCHES)}")
    return row


def _ports(row: SwitchRow, spec: FaultSpec, boards: tuple[Board, ...]) -> tuple[AxisPort, ...]:
    if row.needs is not Needs.AXIS:
        return tuple(port for board in boards for port in board.ports)
    if spec.axis is None or spec.address is None:
        raise SwitchError(f"{row.name} needs {row.needs.value}")
    (board,) = boards
    index = board.addresses.index(spec.address) * AXES_PER_ADDRESS + spec.axis
    if spec.axis not in range(AXES_PER_ADDRESS) or index >= len(board.ports):
        raise SwitchError(f"{_place(spec)}: an address has the axes 0 and 1")
    return (board.ports[index],)


def _place(spec: FaultSpec) -> str:
    if spec.bus is None:
        return "every board"
    place = f"bus {spec.bus}"
    place += "" if spec.address is None else f" address {spec.address}"
    return place + ("" if spec.axis is None else f" axis {spec.axis}")
