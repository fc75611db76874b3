"""Who answers on a CAN bus, without a robot description and without harm.

The questions asked by default change nothing on a board: versions, address, label, serial number.
A handshake with another protocol version would keep a motor board's bridges off, so only the HAL's
own versions are stated. The discovery of class 7 finds boards in their bootloader too, but switches
every motor off: it is refused while an axis moves or has power.
"""

from collections.abc import Callable, Generator, Iterable

import msgspec

from hal.buses.bus import FrameBus
from hal.wire import analog, management, motor, motor_periodic
from hal.wire.can import (
    CLASS_ANALOG_POLLING,
    CLASS_MANAGEMENT,
    CLASS_MOTOR_PERIODIC,
    CLASS_MOTOR_POLLING,
    EVERYBODY,
    HOST,
    Received,
    class_of,
    frame_id,
    source_of,
)
from hal.wire.modes import ControlMode
from hal.wire.texts import label_text

ADDRESSES = range(1, 15)
LISTEN_NS = 120_000_000  # before the first question: three times the slowest period of a stream
ANSWER_NS = 15_000_000
TRIES = 2
MOVED_TICKS = 2
RESTING = (ControlMode.IDLE, ControlMode.HW_FAULT, ControlMode.NO_REQUEST)

Version = tuple[int, ...]
Scan = Generator[None, None, tuple["Found", ...]]


class Found(msgspec.Struct, frozen=True, kw_only=True):
    """What was heard from one address."""

    address: int
    classes: tuple[int, ...]  # message classes of its frames
    type: int | None = None  # a number of BoardType, None while it has told no version
    firmware: tuple[int, int] | None = None  # as on the wire: 2.57 is (0x02, 0x57)
    build: int | None = None
    protocol: tuple[int, int] | None = None
    accepted: bool | None = None  # whether it takes the host's protocol
    label: str = ""
    serial: str = ""
    bootloader: bool = False
    versions: tuple[Version, ...] = ()  # more than one: two boards share the address

    @property
    def collides(self) -> bool:
        """Whether two boards share the address."""
        return len(self.versions) > 1


class _Heard:
    """What one address has said so far."""

    def __init__(self) -> None:
        self.classes: set[int] = set()
        self.versions: list[Version] = []  # of every answer
        self.twins = 0  # answers to one question beyond the first
        self.label: list[tuple[int, ...]] = []
        self.serial = ""
        self.bootloader = False
        self.modes: dict[int, int] = {}
        self.positions: list[tuple[int, ...]] = []

    @property
    def moves(self) -> bool:
        """Whether an axis moves, or has power."""
        if any(mode not in RESTING for mode in self.modes.values()):
            return True
        columns = list(zip(*self.positions, strict=True))
        return any(max(column) - min(column) > MOVED_TICKS for column in columns)


class Scanner:
    """One bus, listened to and asked. Other hosts may use it at the same time."""

    def __init__(self, bus: FrameBus, now_ns: Callable[[], int]) -> None:
        self._bus = bus
        self._now_ns = now_ns
        self._heard: dict[int, _Heard] = {}
        self._answered: set[int] = set()  # addresses, since the last question
        self._asks_alone = True  # each version is asked for once
        self.refused = ""  # why the discovery was not sent

    def scan(self, *, discover: bool = False, force: bool = False) -> Scan:
        """Resume each millisecond or so; returns what was found, by address.

        `discover` sends the discovery afterwards, which switches motors off; `force` even while an
        axis moves or has power.
        """
        yield from self._listen(LISTEN_NS)
        for address in ADDRESSES:
            yield from self._ask(address)
        if discover:
            yield from self._discover(force)
        return tuple(self._found(address) for address in sorted(self._heard))

    def _ask(self, address: int) -> Generator[None, None, None]:
        for attempt in range(TRIES):
            self._answered.clear()
            # A question of before may have waited in the controller's queue.
            self._asks_alone = attempt == 0
            self._bus.send_frames(
                [
                    motor.GET_FIRMWARE_VERSION.request(address, 0, *motor.HOST_PROTOCOL),
                    analog.GET_FW_VERSION.request(address, *analog.HOST_PROTOCOL),
                ]
            )
            yield from self._listen(ANSWER_NS)
            if address in self._answered:
                break
        else:
            return
        heard = self._of(address)
        if CLASS_MOTOR_POLLING in heard.classes:
            questions = [motor.GET_CONTROL_MODE.request(address, axis) for axis in (0, 1)]
            self._bus.send_frames([motor.GET_BOARD_ID.request(address, 0), *questions])
            yield from self._listen(ANSWER_NS)
            self._bus.send_frames([motor.GET_ADDITIONAL_INFO.request(address, 0)])
        else:
            self._bus.send_frames([analog.GET_SERIAL_NO.request(address)])
        yield from self._listen(ANSWER_NS)

    def _discover(self, force: bool) -> Generator[None, None, None]:
        moving = [address for address, heard in sorted(self._heard.items()) if heard.moves]
        if moving and not force:
            boards = ", ".join(map(str, moving))
            self.refused = f"no discovery: axes of board {boards} move or have power"
            return
        self._bus.send_frames([management.DISCOVER.request(EVERYBODY)])
        yield from self._listen(LISTEN_NS)

    def _listen(self, duration_ns: int) -> Generator[None, None, None]:
        end_ns = self._now_ns() + duration_ns
        while True:
            for frame in self._bus.receive_frames():
                self._on_frame(frame)
            if self._now_ns() >= end_ns:
                return
            yield

    def _of(self, address: int) -> _Heard:
        return self._heard.setdefault(address, _Heard())

    def _on_frame(self, frame: Received) -> None:
        can_id, data, _ = frame
        can_class, source = class_of(can_id), source_of(can_id)
        if source == HOST:
            command = motor.command_of(data) if can_class == CLASS_MOTOR_POLLING else None
            self._asks_alone &= command is not motor.GET_FIRMWARE_VERSION
            return
        heard = self._of(source)
        heard.classes.add(can_class)
        if can_class == CLASS_MOTOR_POLLING:
            self._on_motor_reply(heard, source, data)
        elif can_class == CLASS_ANALOG_POLLING:
            version = analog.GET_FW_VERSION.parse_reply(data)
            serial = analog.GET_SERIAL_NO.parse_reply(data)
            if version is not None and data[0] == analog.GET_FW_VERSION.code:
                self._on_version(heard, source, version)
            elif serial is not None and data[0] == analog.GET_SERIAL_NO.code:
                heard.serial = bytes(serial).split(b"\0")[0].decode("ascii", "replace")
        elif can_class == CLASS_MANAGEMENT:
            self._on_discovered(heard, data)
        elif can_id == frame_id(CLASS_MOTOR_PERIODIC, source, motor_periodic.POSITION.type):
            position = motor_periodic.POSITION.parse(data)
            if position is not None:
                heard.positions.append(position)

    def _on_version(self, heard: _Heard, source: int, version: Version) -> None:
        """A second answer to one question comes from a second board, be it the same or not."""
        again = source in self._answered
        if again and (self._asks_alone or version[:4] != heard.versions[-1][:4]):
            heard.twins += 1
        self._answered.add(source)
        heard.versions.append(version)

    def _on_motor_reply(self, heard: _Heard, source: int, data: bytes) -> None:
        command = motor.command_of(data)
        values = None if command is None else command.parse_reply(data)
        if values is None:
            return
        if command is motor.GET_FIRMWARE_VERSION:
            self._on_version(heard, source, values)
        elif command is motor.GET_ADDITIONAL_INFO:
            heard.label.append(values)
        elif command is motor.GET_CONTROL_MODE:
            heard.modes[motor.axis_of(data)] = values[0]

    def _on_discovered(self, heard: _Heard, data: bytes) -> None:
        if data[:1] != b"\xff":
            return
        version = management.DISCOVER.parse_reply(data)
        if version is None and management.DISCOVER_BOOTLOADER.parse_reply(data) is not None:
            heard.bootloader = True
        elif version is not None and not heard.versions:
            heard.versions.append(version)

    def _found(self, address: int) -> Found:
        heard = self._heard[address]
        versions = tuple(heard.versions[-1 - heard.twins :])
        base = Found(
            address=address,
            classes=tuple(sorted(heard.classes)),
            label=label_text(heard.label) or "",
            serial=heard.serial,
            bootloader=heard.bootloader,
            versions=versions,
        )
        if not versions:
            return base
        kind, major, minor, build = versions[0][:4]
        told = msgspec.structs.replace(base, type=kind, firmware=(major, minor), build=build)
        if len(versions[0]) < len(management.FIRMWARE_FIELDS):
            return told
        protocol_major, protocol_minor, accepted = versions[0][4:7]
        return msgspec.structs.replace(
            told, protocol=(protocol_major, protocol_minor), accepted=bool(accepted)
        )


def run(steps: Scan, wait: Callable[[], None]) -> tuple[Found, ...]:
    """Run a scan to its end; `wait` lets about a millisecond pass."""
    while True:
        try:
            next(steps)
        except StopIteration as stop:
            found: tuple[Found, ...] = stop.value
            return found
        wait()


def boards_at(found: Iterable[Found]) -> dict[int, Found]:
    """What was found by address, without addresses that only the host's virtual sensors use."""
    return {one.address: one for one in found if one.versions or one.bootloader}
