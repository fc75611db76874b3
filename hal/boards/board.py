"""What the host side of every board type can do."""

from collections.abc import Generator, Iterable, Mapping
from collections.abc import Sequence as Samples
from typing import NamedTuple, Protocol, runtime_checkable

from hal.axis import Axis
from hal.description import Board, ForceTorqueSensor, RobotDescription
from hal.faults import FaultLog
from hal.line import Line, Trace
from hal.tasks import Sequence
from hal.wire.can import Frame

SILENCE_NS = 90_000_000  # looked for each 5 ms, so reported within 100 ms
ANSWER_NS = 100_000_000  # the boards answer in the next millisecond
TRIES = 5
NO_ANSWER = "does not answer the handshake"

Answer = Generator[None, None, tuple[int, ...] | None]


class Pulse:
    """A stream of frames that says that a board lives; `heard_ns` is 0 until its first one.

    A board whose frames come more seldom than each 20 ms or so gives a longer `limit_ns`.
    """

    __slots__ = ("address", "heard_ns", "limit_ns", "silent", "what")

    def __init__(self, address: int, what: str, limit_ns: int = SILENCE_NS) -> None:
        self.address = address
        self.what = what
        self.limit_ns = limit_ns
        self.heard_ns = 0
        self.silent = False


class Parts(NamedTuple):
    """What a board's host side is made of."""

    board: Board
    line: Line
    axes: tuple[Axis, ...]  # every axis of the board that the robot uses
    faults: FaultLog
    description: RobotDescription
    sensor: ForceTorqueSensor | None  # the FT sensor that the board reads


class HostBoard(Protocol):
    """The host side of one board: decodes its frames, configures it, knows whether it lives."""

    board: Board
    addresses: int  # consecutive ones that it owns, from board.address on
    line: Line
    axes: tuple[Axis, ...]
    pulses: tuple[Pulse, ...]
    trace: Trace

    def listen(self) -> None:
        """Attach the handlers of every frame that the board sends."""

    def quiesce(self) -> Iterable[Frame]:
        """Frames that stop the board from talking."""

    def handshake(self) -> Sequence:
        """Ask who is there; fails with a reason that names the board."""

    def configure(self) -> Sequence:
        """Send every setting, start its broadcasts, and read back what the host must know."""

    def read_back(self) -> Sequence:
        """Read what the host must know of a board that runs."""

    def write_settings(self, axis: int | None) -> None:
        """Queue the settings of one axis (index in the robot), or of everything."""


@runtime_checkable
class Sensor(Protocol):
    """A board that measures. `name` is that of the sensor, else of the board."""

    name: str
    board: Board

    def take(self) -> Samples[object]:
        """Samples since the previous call, oldest first."""


def board_name(board: Board) -> str:
    """How a board is called in reports."""
    return f"board {board.name} (bus {board.bus}, address {board.address})"


def ask(
    line: Line,
    address: int,
    frame: Frame,
    replies: Mapping[int, tuple[int, ...]],
    key: int,
    *,
    tries: int = TRIES,
) -> Answer:
    """Send a question until its answer appears in `replies`; None when it never does."""
    for _ in range(tries):
        line.probe(address, frame)
        deadline_ns = line.now_ns + ANSWER_NS
        while line.now_ns < deadline_ns:
            yield
            answer = replies.get(key)
            if answer is not None:
                return answer
    return None


def sent(line: Line, address: int) -> Generator[None, None, None]:
    """Wait until every queued command of an address has left."""
    while line.pending(address):
        yield


def refusal(
    board: Board, type_code: int, version: tuple[int, ...] | None, protocol: tuple[int, int]
) -> str:
    """Why the answer to a handshake is not acceptable, empty when it is.

    `version` is board type, firmware major, minor, build, protocol major, minor, accepted.
    """
    if version is None:
        return f"{board_name(board)} {NO_ANSWER}"
    found_type, major, minor, build, protocol_major, protocol_minor, accepted = version
    if found_type != type_code:
        return (
            f"{board_name(board)} is of type {found_type}; "
            f"the robot file says {board.type} (type {type_code})"
        )
    if (major, minor) != board.firmware:
        wanted = f"{board.firmware[0]:x}.{board.firmware[1]:02x}"
        return (
            f"{board_name(board)} has firmware {major:x}.{minor:02x} build {build}; "
            f"the robot file says {wanted}"
        )
    if not accepted:
        return (
            f"{board_name(board)} speaks protocol {protocol_major}.{protocol_minor} "
            f"and refused the host's {protocol[0]}.{protocol[1]}"
        )
    return ""
