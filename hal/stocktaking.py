"""What a scan has found, held against the robot description: a text per board, with the remedy."""

from collections.abc import Iterator, Mapping, Sequence

import msgspec

from hal.boards.board import board_name
from hal.description import Board, RobotDescription
from hal.registry import board_type
from hal.scan import Found
from hal.wire.management import BoardType

Place = tuple[int, int]  # bus, address


class Difference(msgspec.Struct, frozen=True, kw_only=True):
    """One board that is not as the robot file says."""

    # missing, moved, swapped, wrong type, wrong firmware, refused, collision or unexpected
    kind: str
    bus: int
    address: int
    board: str  # name in the robot file, empty for an unexpected one
    text: str


def differences(
    found: Mapping[int, Sequence[Found]], description: RobotDescription
) -> tuple[Difference, ...]:
    """Every difference on the scanned buses, in the order of the description."""
    stock = _Stock(found, description)
    return (*stock.expected(), *stock.unexpected())


class _Stock:
    def __init__(self, found: Mapping[int, Sequence[Found]], description: RobotDescription) -> None:
        self._boards = [board for board in description.boards if board.bus in found]
        self._at: dict[Place, Found] = {
            (bus, one.address): one
            for bus, heard in found.items()
            for one in heard
            if one.versions or one.bootloader
        }
        self._covered: set[Place] = set()
        self._told: set[str] = set()
        for board in self._boards:
            for address in range(board.address, board.address + board_type(board.type).addresses):
                self._covered.add((board.bus, address))

    def expected(self) -> Iterator[Difference]:
        """Boards of the description that are not as it says."""
        for board in self._boards:
            if board.name not in self._told:
                difference = self._check(board)
                if difference is not None:
                    yield difference

    def unexpected(self) -> Iterator[Difference]:
        """Boards that the description does not know."""
        for (bus, address), one in self._at.items():
            if (bus, address) not in self._covered:
                what = f"board of type {_type_name(one.type)} at bus {bus}, address {address}"
                yield Difference(
                    kind="unexpected",
                    bus=bus,
                    address=address,
                    board="",
                    text=f"{what} is not in the robot file: unplug it, or add it to the file",
                )
                self._covered.add((bus, address))
                if one.type == BoardType.DC4:  # its second address answers too
                    self._covered.add((bus, address + 1))

    def _check(self, board: Board) -> Difference | None:
        one = self._at.get((board.bus, board.address))
        if one is None:
            return self._missing(board)
        if one.collides:
            kinds = " and ".join(sorted({_version_text(version) for version in one.versions}))
            text = f"shares its address with another ({kinds}): give one of them a new one"
            return _difference("collision", board, text)
        if one.bootloader and not one.versions:
            text = "is in its bootloader: it starts by itself 5 s after the last command"
            return _difference("missing", board, text)
        if _is(board, one):
            if one.accepted is False:
                text = f"refuses the host's protocol, it speaks {one.protocol}: update its firmware"
                return _difference("refused", board, text)
            return None
        other = self._exchanged_with(board)
        if other is not None:
            self._told.add(other.name)
            text = f"and {board_name(other)} are exchanged: swap their plugs, or their addresses"
            return _difference("swapped", board, text)
        return _mismatch(board, one)

    def _missing(self, board: Board) -> Difference:
        for (bus, address), one in self._at.items():
            if (bus, address) not in self._covered and _is(board, one):
                text = (
                    f"does not answer; one like it is at bus {bus}, address {address}: "
                    "plug it back, or set its address"
                )
                self._covered.add((bus, address))
                if one.type == BoardType.DC4:
                    self._covered.add((bus, address + 1))
                return _difference("moved", board, text)
        alone = not any(bus == board.bus for bus, _ in self._at)
        text = "does not answer: check its power and its cable"
        if alone:
            text = f"does not answer, nor does any other on bus {board.bus}: check the bus"
        return _difference("missing", board, text)

    def _exchanged_with(self, board: Board) -> Board | None:
        """Another board that is where this one should be, while this one is where that should."""
        here = self._at[board.bus, board.address]
        for other in self._boards:
            there = self._at.get((other.bus, other.address))
            if there is not None and other is not board and _is(board, there) and _is(other, here):
                return other
        return None


def _is(board: Board, one: Found) -> bool:
    return one.type == board_type(board.type).type_code and one.firmware == board.firmware


def _mismatch(board: Board, one: Found) -> Difference:
    if one.type != board_type(board.type).type_code:
        found = _type_name(one.type)
        text = f"is of type {found}, not a {board.type}: a wrong board is plugged in here"
        return _difference("wrong type", board, text)
    wanted, found = _firmware_text(board.firmware), _firmware_text(one.firmware or (0, 0))
    text = f"has firmware {found}, not {wanted}: load {wanted}, or correct the robot file"
    return _difference("wrong firmware", board, text)


def _difference(kind: str, board: Board, text: str) -> Difference:
    return Difference(
        kind=kind,
        bus=board.bus,
        address=board.address,
        board=board.name,
        text=f"{board_name(board)} {text}",
    )


def _type_name(kind: int | None) -> str:
    if kind is None:
        return "unknown"
    known = {int(member): member.name for member in BoardType}
    return known.get(kind, str(kind))


def _version_text(version: tuple[int, ...]) -> str:
    return f"{_type_name(version[0])} {_firmware_text((version[1], version[2]))}"


def _firmware_text(firmware: tuple[int, int]) -> str:
    return f"{firmware[0]:x}.{firmware[1]:02x}"
