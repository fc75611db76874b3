"""What the axes of a motor board share: the handshake, torque sensors heard, prints, counters."""

from collections import Counter, deque
from collections.abc import Sequence
from typing import TYPE_CHECKING

from firmware_sim.boards.bank import AxisBank
from firmware_sim.boards.fields import SOURCES
from hal.wire.analog import FORCE, TORQUE
from hal.wire.can import CLASS_ANALOG_PERIODIC, Frame, frame_id
from hal.wire.motor_periodic import PRINT

if TYPE_CHECKING:
    from firmware_sim.boards.unit import Unit

PROTOCOL = (1, 6)  # of every DSP board here
BUILD = 87
TORQUE_WATCHDOG_MS = 200
LABEL_PIECES = 8
_PRINT_BUFFERS = 4
_PRINT_PIECES = 16
_PIECE_CHARACTERS = 6
_LAST_PIECE = 0x80
_TORQUE_IDS = frozenset(
    frame_id(CLASS_ANALOG_PERIODIC, source, row.type)
    for source in range(SOURCES)
    for row in (FORCE, TORQUE)
)


class TorqueSensor:
    """One virtual torque sensor heard on the bus: its row in the bank."""

    __slots__ = ("_alive_ms", "_row", "_words")

    def attach(self, bank: AxisBank, row: int) -> None:
        """Keep words and watchdog in a row of a bank."""
        self._row = row
        self._alive_ms = bank.alive_ms.data
        self._words = bank.torque_words[row].data

    @property
    def watchdog_ms(self) -> int:
        """Milliseconds until it counts as silent; 0 = it is."""
        return self._alive_ms[self._row]

    def hear(self, half: int, words: tuple[int, ...]) -> None:
        """Take in the words of channels 0..2 or 3..5; what follows them is not looked at."""
        place = 3 * half
        self._words[place], self._words[place + 1], self._words[place + 2] = words[:3]
        self._alive_ms[self._row] = TORQUE_WATCHDOG_MS

    def forget(self) -> None:
        """Count as silent."""
        self._alive_ms[self._row] = 0


class Printer:
    """Text for the host in PRINT frames: at most four strings wait, of at most 96 characters."""

    def __init__(self, address: int) -> None:
        self._address = address
        self.waiting: deque[deque[Frame]] = deque()
        self._number = 0
        self.lost = 0

    def move_to(self, address: int) -> None:
        """Speak from another address from now on."""
        self._address = address

    def say(self, text: str) -> None:
        """Queue one string, or count it as lost when four are waiting."""
        if len(self.waiting) == _PRINT_BUFFERS:
            self.lost += 1
            return
        characters = text.encode("ascii", "replace")[: _PRINT_PIECES * _PIECE_CHARACTERS]
        starts = range(0, len(characters), _PIECE_CHARACTERS)
        pieces: deque[Frame] = deque()
        for sequence, start in enumerate(starts):
            last = start + _PIECE_CHARACTERS >= len(characters)
            head = PRINT.type | (_LAST_PIECE if last else 0)
            piece = characters[start : start + _PIECE_CHARACTERS]
            pieces.append(PRINT.frame(self._address, head, self._number << 4 | sequence, *piece))
        self.waiting.append(pieces)
        self._number = (self._number + 1) % _PRINT_BUFFERS

    def next_frame(self) -> Frame:
        """The next piece of what waits; a board sends one per millisecond."""
        pieces = self.waiting[0]
        frame = pieces.popleft()
        if not pieces:
            self.waiting.popleft()
        return frame

    def clear(self) -> None:
        """Forget what waits."""
        self.waiting.clear()


class Node:
    """State of the whole board, whatever axis or address asks for it."""

    unit: "Unit"  # set by the board when its axes are made

    def __init__(self, address: int, version: tuple[int, int]) -> None:
        self.address = address
        self.version = version
        self.printer = Printer(address)
        self.sensors: dict[int, TorqueSensor] = {}
        self.torque_frames: dict[int, tuple[TorqueSensor, int]] = {}  # by identifier; which words
        self.unheard = set(_TORQUE_IDS)  # identifiers that no axis listens to
        self.dropped: Counter[str] = Counter()
        self.label = bytearray(LABEL_PIECES * 4)  # flash: survives boot

    def attach_to(self, bank: AxisBank, board: int) -> None:
        """Keep what sensors say in the bank, in the rows of this board."""
        self._bank = bank
        self._first_source = board * SOURCES
        for source, sensor in self.sensors.items():
            sensor.attach(bank, self._first_source + source)

    def boot(self) -> None:
        """State at power-up."""
        self.ms = 0
        self.accepted = False  # the host's protocol version was accepted
        self.printer.clear()
        for sensor in self.sensors.values():
            sensor.forget()

    def hear(self, source: int) -> int:
        """Listen to the virtual torque sensor at an address; its row in the bank, -1 = no address.

        A sensor may have any of sixteen addresses; a byte in a command more.
        """
        if source >= SOURCES:
            return -1
        if source not in self.sensors:
            sensor = self.sensors[source] = TorqueSensor()
            sensor.attach(self._bank, self._first_source + source)
            for half, row in enumerate((FORCE, TORQUE)):  # channels 0..2 and 3..5
                can_id = frame_id(CLASS_ANALOG_PERIODIC, source, row.type)
                self.torque_frames[can_id] = sensor, half
                self.unheard.discard(can_id)
        return self._first_source + source

    def set_label_piece(self, index: int, characters: Sequence[int]) -> None:
        """Write four characters of the label into the flash; an index beyond it is ignored."""
        if index < LABEL_PIECES:
            self.label[4 * index : 4 * index + 4] = bytes(characters)
            self.unit.flash_writes += 1

    def label_piece(self, index: int) -> tuple[int, ...]:
        """Index and four characters of the label."""
        return index, *self.label[4 * index : 4 * index + 4]


class Pair:
    """One CAN address of a board: its broadcast mask and what STATUS last said."""

    def __init__(self, address: int) -> None:
        self.address = address
        self.boot()

    def boot(self) -> None:
        """State at power-up: silent."""
        self.mask = 0
        self.reported_modes = (0, 0)  # that the host was told
        self.reported_interactions = (False, False)
        self.heartbeat_ms = 0
        self.can_status = 0  # CanStatus bits; reporting clears them
        self.board_status = 0  # BoardStatus bits of this cycle
