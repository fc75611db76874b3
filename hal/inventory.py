"""What is known of every board: what it says it is, and whether it works."""

from collections.abc import Iterable
from functools import partial

from hal.boards.board import HostBoard, board_name
from hal.faults import FaultLog
from hal.line import Trace
from hal.readings import BoardReport
from hal.wire import analog, motor
from hal.wire.can import CLASS_ANALOG_POLLING, CLASS_MOTOR_POLLING, HOST, frame_id

COLLISION_NS = 5_000_000  # two answers to one question come within this
# Two equal answers prove nothing: questions that waited in a controller's queue while no board had
# power all leave, and are answered, at once.

Version = tuple[int, ...]  # values of FIRMWARE_FIELDS


class Record:
    """State of one board."""

    __slots__ = ("heard_ns", "reason", "since_ns", "state", "twin", "version")

    def __init__(self) -> None:
        self.state = "missing"
        self.reason = "not asked yet"
        self.since_ns = 0
        self.version: Version | None = None
        self.heard_ns: int | None = None  # the last answer to the handshake under way
        self.twin: Version | None = None  # a second, different answer


class Inventory:
    """Listens to the answers to handshakes and keeps a record of every board, by its name."""

    def __init__(self, boards: Iterable[HostBoard], faults: FaultLog) -> None:
        self._boards = tuple(boards)
        self._faults = faults
        self.records = {board.board.name: Record() for board in self._boards}
        trace = Trace(maxlen=1)
        for board in self._boards:
            for can_class in (CLASS_MOTOR_POLLING, CLASS_ANALOG_POLLING):
                can_id = frame_id(can_class, board.board.address, HOST)
                board.line.also(can_id, partial(self._on_reply, board, can_class), trace)

    def _on_reply(self, board: HostBoard, can_class: int, data: bytes, stamp_ns: int) -> None:
        code = motor.GET_FIRMWARE_VERSION.code
        command = motor.GET_FIRMWARE_VERSION
        version = command.parse_reply(data) if can_class == CLASS_MOTOR_POLLING else None
        if can_class == CLASS_ANALOG_POLLING:
            code = analog.GET_FW_VERSION.code
            version = analog.GET_FW_VERSION.parse_reply(data)
        if version is None or data[0] != code:
            return
        record = self.records[board.board.name]
        together = record.heard_ns is not None and stamp_ns - record.heard_ns <= COLLISION_NS
        if together and version[:4] != (record.version or ())[:4]:
            record.twin = version
            text = f"{board_name(board.board)}: {self.collision(board)}"
            self._faults.report(stamp_ns, text, text)
        record.version = version
        record.heard_ns = stamp_ns

    def collision(self, board: HostBoard) -> str:
        """What is said of two boards that share an address, empty when one answers."""
        record = self.records[board.board.name]
        if record.twin is None:
            return ""
        kinds = {f"type {v[0]} firmware {v[1]:x}.{v[2]:02x}" for v in self._versions(record)}
        what = " and ".join(sorted(kinds))
        return f"two boards answer at one address ({what}): give one of them another address"

    def _versions(self, record: Record) -> list[Version]:
        return [version for version in (record.version, record.twin) if version is not None]

    def ask(self, board: HostBoard) -> None:
        """A handshake begins."""
        record = self.records[board.board.name]
        record.twin = None
        record.heard_ns = None  # the answer to the question before is no second one to this

    def note(self, board: HostBoard, state: str, now_ns: int, reason: str = "") -> None:
        """A board is in a state: ok, missing, wrong, silent or restarted."""
        record = self.records[board.board.name]
        if (state, reason) != (record.state, record.reason):
            record.since_ns = now_ns if state != record.state else record.since_ns
            record.state, record.reason = state, reason

    def reports(self) -> tuple[BoardReport, ...]:
        """Every board as it is now."""
        return tuple(self._report(board) for board in self._boards)

    def _report(self, board: HostBoard) -> BoardReport:
        record, expected = self.records[board.board.name], board.board
        state, reason = record.state, record.reason
        uncalibrated = [axis.name for axis in board.axes if not axis.is_calibrated]
        if state == "restarted" and not uncalibrated:
            state = "ok"
        elif state == "ok" and uncalibrated:
            state, reason = "needs calibration", ", ".join(uncalibrated)
        version = record.version
        return BoardReport(
            name=expected.name,
            bus=expected.bus,
            address=expected.address,
            type=expected.type,
            found_type=None if version is None else version[0],
            firmware=expected.firmware,
            found_firmware=None if version is None else (version[1], version[2]),
            build=None if version is None else version[3],
            protocol=None if version is None else (version[4], version[5]),
            state=state,
            reason="" if state == "ok" else reason,
            since_ns=record.since_ns,
        )
