"""What the axes of a motor board share: the handshake, torque sensors heard, prints, counters."""

from collections import Counter, deque

from hal.wire.analog import FORCE, TORQUE, ZERO_WORD
from hal.wire.can import CLASS_ANALOG_PERIODIC, Frame, frame_id
from hal.wire.motor_periodic import PRINT

PROTOCOL = (1, 6)  # of every DSP board here
BUILD = 87
TORQUE_WATCHDOG_MS = 200
LABEL_PIECES = 8
_PRINT_BUFFERS = 4
_PRINT_PIECES = 16
_PIECE_CHARACTERS = 6
_LAST_PIECE = 0x80


class TorqueSensor:
    """One virtual torque sensor heard on the bus: the words of its two frames, and its watchdog."""

    __slots__ = ("watchdog_ms", "words")

    def __init__(self) -> None:
        silent = (ZERO_WORD,) * 3
        self.words: list[tuple[int, ...]] = [silent, silent]  # channels 0..2 and 3..5
        self.watchdog_ms = 0  # 0 = silent


class Printer:
    """Text for the host in PRINT frames: at most four strings wait, of at most 96 characters."""

    def __init__(self, address: int) -> None:
        self._address = address
        self.waiting: deque[deque[Frame]] = deque()
        self._number = 0
        self.lost = 0

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

    def __init__(self, address: int, version: tuple[int, int]) -> None:
        self.address = address
        self.version = version
        self.printer = Printer(address)
        self.sensors: dict[int, TorqueSensor] = {}
        self.torque_frames: dict[int, tuple[TorqueSensor, int]] = {}  # by identifier; which words
        self.dropped: Counter[str] = Counter()
        self.label = bytearray(LABEL_PIECES * 4)  # flash: survives boot
        self.boot()

    def boot(self) -> None:
        """State at power-up."""
        self.ms = 0
        self.accepted = False  # the host's protocol version was accepted
        self.printer.clear()
        for sensor in self.sensors.values():
            sensor.watchdog_ms = 0

    def sensor(self, source: int) -> TorqueSensor:
        """The virtual torque sensor at an address, listened to from now on."""
        sensor = self.sensors.get(source)
        if sensor is None:
            sensor = self.sensors[source] = TorqueSensor()
            for half, row in enumerate((FORCE, TORQUE)):  # channels 0..2 and 3..5
                can_id = frame_id(CLASS_ANALOG_PERIODIC, source, row.type)
                self.torque_frames[can_id] = sensor, half
        return sensor

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
