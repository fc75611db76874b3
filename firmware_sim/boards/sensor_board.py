"""What every sensor board does: power, receive queue, handshake, discovery, label, boot loader.

Sources: can-protocol 5 and 8. A subclass answers the commands of class 2 and sends its samples.
"""

from collections import Counter, deque

from firmware_sim.boards.axis import AxisPort
from firmware_sim.boards.axis_state import Axis
from firmware_sim.boards.board import RECEIVE_FIFO_FRAMES
from firmware_sim.boards.loader import Loader
from firmware_sim.description import BoardSpec
from hal.wire import analog, management
from hal.wire.can import (
    CLASS_ANALOG_POLLING,
    CLASS_MANAGEMENT,
    HOST,
    Frame,
    class_of,
    low_of,
    source_of,
)
from hal.wire.management import BoardType, is_addressed_to
from hal.wire.message import Command, PeriodicMessage
from hal.wire.texts import LABEL_PIECE_CHARACTERS, LABEL_PIECES

PROTOCOL = (1, 0)  # of every sensor board; equality only

Values = tuple[int, ...]


class SensorBoard:
    """A board without axes.

    Inputs beside those of every board: `silent` (it answers, but sends no samples) and `reboot_ms`
    (it is away for so many milliseconds, then boots).
    """

    board_type: BoardType
    build: int
    any_management_stops = False  # not only a discovery
    overflow: PeriodicMessage | None = None  # what it sends when its receive queue was full

    def __init__(self, spec: BoardSpec) -> None:
        self.addresses: tuple[int, ...] = (spec.address,)
        self.ports: tuple[AxisPort, ...] = ()
        self.axes: tuple[Axis, ...] = ()
        self.raw_adc: list[int] = []
        self.bus_off = False
        self.powered = True
        self.silent = False
        self.reboot_ms = 0
        self.dropped: Counter[str] = Counter()
        self.version = spec.firmware
        self.is_from_loader = False  # the boot loader has started the application
        self.label = bytearray(LABEL_PIECES * LABEL_PIECE_CHARACTERS)  # survives a boot
        self._address = spec.address
        self._received: deque[tuple[int, bytes]] = deque()
        self._loader = Loader(spec.address, self.board_type, spec.firmware)
        self._awake = False
        self._has_overrun = False

    def power_cycle(self) -> None:
        """Boot again: everything but the EEPROM is forgotten."""
        self.powered = True
        self.reboot_ms = 0
        self._loader.leave()
        self._awake = self._has_overrun = self.is_from_loader = False
        self._received.clear()
        self.boot()

    def boot(self) -> None:
        """Take the settings of the EEPROM, send nothing."""
        raise NotImplementedError

    def stop(self) -> None:
        """Send no more samples until the host starts them again."""
        raise NotImplementedError

    def answer(self, code: int, data: bytes) -> list[Frame]:
        """Act on a command of class 2; the frames that answer it."""
        raise NotImplementedError

    def sample(self, sent: list[Frame]) -> None:
        """One millisecond: append the samples whose time has come."""
        raise NotImplementedError

    def wake(self) -> list[Frame]:
        """Frames sent once after a boot."""
        return []

    def accepts(self, can_id: int) -> bool:
        """Commands of class 2 to this board, and class 7 from the host."""
        kind = class_of(can_id)
        if kind == CLASS_ANALOG_POLLING:
            return low_of(can_id) == self._address
        return (
            kind == CLASS_MANAGEMENT
            and source_of(can_id) == HOST
            and is_addressed_to(can_id, self._address)
        )

    def on_frame(self, can_id: int, data: bytes) -> None:
        """Queue a frame for the next tick."""
        if self.bus_off or not self.powered or self.reboot_ms:
            return
        if len(self._received) >= RECEIVE_FIFO_FRAMES:
            self.dropped["overrun"] += 1
            self._has_overrun = True
        elif not self.accepts(can_id):
            self.dropped["address"] += 1
        else:
            self._received.append((can_id, data))

    def tick(self) -> list[Frame]:
        """One millisecond: answer what came in, then send the samples whose time has come."""
        if self.reboot_ms or not self.powered:
            self._wait_for_power()
            return []
        if self._loader.is_running:
            return self._load()
        sent: list[Frame] = []
        if not self._awake:
            self._awake = True
            sent += self.wake()
        if self._has_overrun:
            self._has_overrun = False
            if self.overflow is not None:
                sent.append(self.overflow.frame(self._address))
        while self._received and not self._loader.is_running:
            sent += self._respond(*self._received.popleft())
        if not self.silent and not self._loader.is_running:
            self.sample(sent)
        return [] if self.bus_off else sent

    def handshake(self, request: Values) -> list[Frame]:
        """Answer to GET_FW_VERSION."""
        accepted = int(request == PROTOCOL)
        values = (self.board_type, *self.version, self.build, *PROTOCOL, accepted)
        return [analog.GET_FW_VERSION.reply(self._address, *values)]

    def _wait_for_power(self) -> None:
        if self.reboot_ms and self.powered:
            self.reboot_ms -= 1
            if self.reboot_ms == 0:
                self.power_cycle()

    def _respond(self, can_id: int, data: bytes) -> list[Frame]:
        if not data:
            self.dropped["length"] += 1
            return []
        if can_id >> 8 == CLASS_MANAGEMENT:
            return self._manage(data)
        source = source_of(can_id)
        frames = self.answer(data[0], data)
        return [(can_id | source, data) for can_id, data in frames] if source else frames

    def _manage(self, data: bytes) -> list[Frame]:
        code = data[0]
        if self.any_management_stops:
            self.stop()
        address = self._address
        if code == management.DISCOVER.code:
            self.stop()
            return [management.DISCOVER.reply(address, self.board_type, *self.version, self.build)]
        if code == management.BOARD.code:
            return self._loader.enter()
        if code == management.END.code:  # a running application takes it as a ping
            return [management.END.reply(address, 1)]
        if code == management.GET_ADDITIONAL_INFO.code:
            return [self._label_piece(index) for index in range(LABEL_PIECES)]
        if code == management.SET_ADDITIONAL_INFO.code:
            self._set_label_piece(management.SET_ADDITIONAL_INFO.parse_request(data) or ())
        else:
            self.dropped["management"] += 1
        return []

    def _load(self) -> list[Frame]:
        """A millisecond of the boot loader; the application boots when it leaves."""
        received = list(self._received)
        self._received.clear()
        answers = self._loader.listen(received, self.dropped)
        if not self._loader.is_running:
            self.power_cycle()
            self.is_from_loader = True
        return [] if self.bus_off else answers

    def _label_piece(self, index: int) -> Frame:
        size = LABEL_PIECE_CHARACTERS
        characters = self.label[size * index : size * (index + 1)]
        return management.GET_ADDITIONAL_INFO.reply(self._address, index, *characters)

    def _set_label_piece(self, request: Values) -> None:
        index, *characters = request
        if index < LABEL_PIECES:
            size = LABEL_PIECE_CHARACTERS
            self.label[size * index : size * (index + 1)] = bytes(characters)


def parsed(row: Command, data: bytes) -> Values:
    """Values of a request; a sensor board checks no length, missing bytes read as zero."""
    return row.parse_request(data) or ()
