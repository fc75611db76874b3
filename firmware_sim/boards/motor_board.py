"""A DSP motor board: what it hears and says around the millisecond of its bank (can-protocol 10.4).

`listen` comes before the bank's `control`, `speak` between that and `supervise`.
"""

from collections.abc import Callable

from firmware_sim.boards import parser
from firmware_sim.boards.axis import AxisPort
from firmware_sim.boards.axis_state import Axis
from firmware_sim.boards.bank import AxisBank
from firmware_sim.boards.board import RECEIVE_FIFO_FRAMES
from firmware_sim.boards.control import LAWS, undefined
from firmware_sim.boards.fields import MS, RUNNING
from firmware_sim.boards.hardware import Coupling, Firmware, Hardware
from firmware_sim.boards.modes import COMPILED
from firmware_sim.boards.node import BUILD, Node, Pair
from firmware_sim.boards.schedule import Schedule
from firmware_sim.boards.transmit import TransmitBuffer
from firmware_sim.boards.unit import Unit
from hal.wire.can import (
    CLASS_ANALOG_PERIODIC,
    CLASS_MANAGEMENT,
    CLASS_MOTOR_POLLING,
    EVERYBODY,
    HOST,
    Frame,
    class_of,
    low_of,
    source_of,
)
from hal.wire.message import CODE_MASK
from hal.wire.motor import GET_ADDITIONAL_INFO
from hal.wire.motor_periodic import BoardStatus, CanStatus

TEMPERATURE_PERIOD_MS = 5
_OVERTEMPERATURE = (int(BoardStatus.OVERTEMPERATURE_0), int(BoardStatus.OVERTEMPERATURE_1))
_LOOP_OVERRUN = int(BoardStatus.LOOP_OVERRUN)
_BUS_OFF = int(CanStatus.BUS_OFF)
_RX_OVERRUN = int(CanStatus.RX_OVERRUN)
_TX_OVERRUN = int(CanStatus.TX_OVERRUN)


def _nobody_listens() -> None:
    """Of a board that is on no network."""


class MotorBoard:
    """BLL or 4DC, as its `Hardware` and `Firmware` say. Two axes for each address."""

    def __init__(self, address: int, hardware: Hardware, firmware: Firmware) -> None:
        self.addresses = tuple(range(address, address + hardware.axes // 2))
        self.bus_off = False
        self.powered = True
        self.loop_overrun = False  # input: this millisecond took longer than it may, reported once
        self.raw_adc: list[int] = []
        self.on_new_address: Callable[[], None] = _nobody_listens
        self._hardware = hardware
        self._firmware = firmware
        self._node = Node(address, firmware.version)
        self.dropped = self._node.dropped
        self._pairs = tuple(Pair(own) for own in self.addresses)
        self.axes = tuple(
            Axis(number, hardware, wiring, self._node, self._pairs[number // 2])
            for number, wiring in enumerate(firmware.axes)
        )
        self._addressed = tuple(
            (pair, (self.axes[2 * number], self.axes[2 * number + 1]))
            for number, pair in enumerate(self._pairs)
        )
        self.ports: tuple[AxisPort, ...] = tuple(axis.port for axis in self.axes)
        self._transmit = TransmitBuffer(is_faithful=firmware.faithful)
        self._received: list[Frame] = []
        self._replies: list[Frame] = []
        self._schedule = Schedule(self._addressed, hardware.slots, firmware, self._node)
        self.join(AxisBank(len(self.axes)))

    def join(self, bank: AxisBank) -> None:
        """Move to a bank and boot there."""
        self._bank = bank
        self.number, self.first_row = bank.take_in(self, len(self.axes))
        self._words = bank.boards[self.number].data
        self._node.attach_to(bank, self.number)
        for axis in self.axes:
            axis.attach_to(bank, self.number, self.first_row)
            axis.write_constants()
        for group in self._firmware.coupling.groups:
            for own in group:
                axis = self.axes[own]
                axis.power_with(tuple(self.axes[other] for other in group if other != own))
        self._unit = self._node.unit = Unit(self._firmware, self.axes, self._pairs)
        self._links = self._unit.links
        self._coupling: Coupling | None = None
        self.power_cycle()

    @property
    def firmware(self) -> Firmware:
        """What the board's firmware number says."""
        return self._firmware

    def accepts(self, can_id: int) -> bool:
        """Hardware filter: commands to the board, every class 3 frame, class 7, a partner."""
        kind = class_of(can_id)
        if kind == CLASS_MOTOR_POLLING:
            return low_of(can_id) in self.addresses
        if kind == CLASS_MANAGEMENT:
            addressed = low_of(can_id) in (self.addresses[0], EVERYBODY)
            return addressed and source_of(can_id) == HOST
        return kind == CLASS_ANALOG_PERIODIC or self._links.accepts(can_id)

    def on_frame(self, can_id: int, data: bytes) -> None:
        """Queue a frame for the next tick; the 31st overruns the FIFO and is lost."""
        received = self._received
        if len(received) < RECEIVE_FIFO_FRAMES:
            received.append((can_id, data))
            return
        self.dropped["overrun"] += 1
        self._report(can_status=_RX_OVERRUN)

    def power_cycle(self) -> None:
        """Boot again; label and fault counters are kept."""
        self.powered = True
        self._received.clear()
        self._replies = []
        self._transmit.clear()
        self._schedule.boot()
        self._node.boot()
        for pair in self._pairs:
            pair.boot()
        for axis in self.axes:
            axis.boot()
        self._unit.boot()
        self._couple()

    def tick(self) -> list[Frame]:
        """One millisecond of this board alone."""
        bank, number = self._bank, self.number
        self.listen()
        bank.control(number, number + 1)
        sent = self.speak()
        bank.supervise(number, number + 1)
        return sent

    def listen(self) -> None:
        """Begin a millisecond: act on what was received."""
        if not self.powered:
            self._sleep()
        elif self._unit.loader.is_running:
            self._load()
        else:
            self._run()

    def speak(self) -> list[Frame]:
        """End a millisecond: frames that leave the board in it."""
        if not self.powered:
            return []
        made = self._replies
        if self.bus_off:
            made.clear()
            self._transmit.clear()
        else:
            self._schedule.broadcast(self._node.ms, made)
            if made:
                self._replies = []
            made = self._transmit.step(made)
            if self._transmit.lost:
                self.dropped["transmit"] += self._transmit.lost
                self._transmit.lost = 0
                self._report(can_status=_TX_OVERRUN)
        if self.loop_overrun:
            self.loop_overrun = False
            self._report(board_status=_LOOP_OVERRUN)
        return made

    def run_laws(self) -> None:
        """Laws that are not compiled."""
        for axis in self.axes:
            if axis.enabled and axis.mode not in COMPILED:
                axis.pwm_wanted = LAWS.get(axis.mode, undefined)(axis)

    def watch_temperature(self) -> None:
        """Fault axes whose drive is too hot, each fifth millisecond."""
        if self._words[RUNNING] and self._node.ms % TEMPERATURE_PERIOD_MS == 0:
            for axis in self.axes:
                if axis.port.overheated:
                    axis.pair.board_status |= _OVERTEMPERATURE[axis.index]
                    axis.fault()

    def _sleep(self) -> None:
        self._received.clear()
        if self._words[RUNNING]:
            self._words[RUNNING] = 0
            for axis in self.axes:
                axis.idle()

    def _run(self) -> None:
        now_ms = self._node.ms = self._node.ms + 1
        self._words[MS] = now_ms
        if now_ms == 1:
            self._words[RUNNING] = 1
            for axis in self.axes:
                axis.rebase()
        if self.bus_off:
            self._fall_off()
        elif self._received:
            self._parse(self._replies)
            if self._unit.coupling is not self._coupling:
                self._couple()
        if self._links.any:
            self._links.advance(self._words)
        if self._pairs[0].address != self.addresses[0]:  # SET_BOARD_ID
            self.addresses = tuple(pair.address for pair in self._pairs)
            self._transmit.clear()
            self.on_new_address()

    def _couple(self) -> None:
        self._coupling = self._unit.coupling
        self._bank.couple(self.number, self._coupling)

    def _load(self) -> None:
        """A millisecond of the boot loader; the application boots when it leaves."""
        received, self._received = self._received, []
        answers = self._unit.loader.listen(received, self.dropped)
        if not self._unit.loader.is_running:
            self.power_cycle()
        self._replies += answers

    def _fall_off(self) -> None:
        self._received.clear()
        for axis in self.axes:
            axis.fault()
        self._report(can_status=_BUS_OFF)

    def _report(self, *, can_status: int = 0, board_status: int = 0) -> None:
        for pair in self._pairs:
            pair.can_status |= can_status
            pair.board_status |= board_status

    def _parse(self, sent: list[Frame]) -> None:
        received = self._received
        self._received = []
        unheard = self._node.unheard
        for number, (can_id, data) in enumerate(received, 1):
            if can_id in unheard:
                continue
            kind = can_id >> 8
            if kind == CLASS_MOTOR_POLLING:
                if not self._command(can_id, data, sent):
                    self._received = received[number:]  # the rest waits for the next millisecond
                    return
            elif self._links.any and self._hear_board(can_id, data):
                pass
            elif kind == CLASS_ANALOG_PERIODIC:
                parser.virtual_torque(self._node, self._firmware, can_id, data)
            else:
                self._manage(can_id, data, sent)

    def _hear_board(self, can_id: int, data: bytes) -> bool:
        taken = self._links.on_frame(can_id, data)
        if taken is False:
            self.dropped["length"] += 1
        return taken is not None

    def _command(self, can_id: int, data: bytes, sent: list[Frame]) -> bool:
        number = low_of(can_id) - self.addresses[0]
        if not data or not 0 <= number < len(self.addresses):
            self.dropped["address"] += 1
            return True
        axis = self._addressed[number][1][data[0] >> 7]
        if data[0] & CODE_MASK == GET_ADDITIONAL_INFO.code:
            parser.send_label(axis, source_of(can_id), sent)
            return True
        return parser.command(axis, data, source_of(can_id), sent)

    def _manage(self, can_id: int, data: bytes, sent: list[Frame]) -> None:
        if parser.switches_off(self.addresses[0], can_id, data):
            for pair in self._pairs:
                pair.mask = 0
            for axis in self.axes:
                if axis.enabled:
                    axis.idle()
        sent += parser.manage(self._node, can_id, data, self._hardware.board_type, BUILD)
