"""Host sides of boards by type name, imported when first asked for.

An out-of-tree board declares itself in its own pyproject: [project.entry-points."ulna.hal_boards"]
x = "package.module:Class".
"""

from importlib import import_module
from importlib.metadata import entry_points
from typing import Protocol, cast

from hal.boards.board import HostBoard, Parts
from hal.errors import DescriptionError

ENTRY_POINTS = "ulna.hal_boards"

BOARDS = {
    "bll": "hal.boards.bll:Bll",
    "bll_dc": "hal.boards.bll_dc:BllDc",
    "bll_ie": "hal.boards.bll_ie:BllIe",
    "dc4": "hal.boards.dc4:Dc4",
    "imu": "hal.boards.imu:Imu",
    "mais": "hal.boards.mais:Mais",
    "mtb": "hal.boards.mtb:Mtb",
    "strain": "hal.boards.strain:Strain",
    "strain2": "hal.boards.strain2:Strain2",
}


class BoardType(Protocol):
    """A class of the registry."""

    type_code: int  # what such a board reports of itself
    addresses: int  # consecutive addresses that such a board owns

    def __call__(self, parts: Parts) -> HostBoard:
        """Make the host side of one board."""
        ...


class MotorBoardType(BoardType, Protocol):
    """A class of the registry whose boards have axes."""

    full_pwm: int  # PWM count of a bridge that is always on
    max_current_ma: int  # largest current limit that it accepts

    def velocity_count(self, speed_estimate_shift: int) -> float:
        """What one count of a VELOCITY frame is, in ticks/ms."""
        ...


def motor_board_type(name: str) -> MotorBoardType:
    """The class behind the type name of a motor board.

    Raises:
        DescriptionError: unknown type, or one without axes.
    """
    kind = board_type(name)
    if not hasattr(kind, "full_pwm"):
        raise DescriptionError(f"a {name} has no axes")
    return cast("MotorBoardType", kind)


def board_type(name: str) -> BoardType:
    """The class behind a type name.

    Raises:
        DescriptionError: unknown type; the known ones are listed.
    """
    target = BOARDS.get(name)
    if target is None:
        added = {entry.name: entry.value for entry in entry_points(group=ENTRY_POINTS)}
        target = added.get(name)
        if target is None:
            known = ", ".join(sorted({*BOARDS, *added}))
            raise DescriptionError(f"unknown board type {name!r}; known: {known}")
    module, _, attribute = target.partition(":")
    kind: BoardType = getattr(import_module(module), attribute)
    return kind
