"""Which axes a board's firmware switches together, and which boards need each other's frames.

Source: can-protocol 9.4 and 10.2. What a firmware does is known by the minor part of its number.
"""

from collections.abc import Iterator, Sequence

from hal.axis import Axis
from hal.description import Board

GROUPS = {
    0x15: (2, 3),  # eyes
    0x19: (1, 2),  # wrist
    0x52: (0, 1),  # waist
    0x62: (0, 1),  # neck
    0x63: (0, 1),
}
"""Axes of a board that are enabled, disabled and calibrated together."""

PARTNERS = {0x50: 0x57, 0x57: 0x50}
"""The two boards of a shoulder: each goes to fault when the other is silent for 100 ms."""

HANDS = (0x28, 0x30)
"""These go to fault when the MAIS on their bus is silent for 100 ms."""

AXES_PER_ADDRESS = 2


def board_axis(board: Board, axis: Axis) -> int:
    """Number of an axis on its board, 0..3."""
    return AXES_PER_ADDRESS * (axis.address - board.address) + axis.number


def coupled_axes(board: Board, axes: Sequence[Axis]) -> tuple[Axis, ...]:
    """Those of a board's axes that do everything together; empty when there are none."""
    group = GROUPS.get(board.firmware[1], ())
    coupled = tuple(axis for axis in axes if board_axis(board, axis) in group)
    return coupled if len(coupled) > 1 else ()


def needed_boards(board: Board, boards: Sequence[Board]) -> Iterator[Board]:
    """Boards on the same bus without whose frames a board's axes go to fault."""
    minor = board.firmware[1]
    for other in boards:
        if other is board or other.bus != board.bus:
            continue
        is_partner = minor in PARTNERS and other.firmware[1] == PARTNERS[minor]
        if is_partner or (minor in HANDS and other.type == "mais"):
            yield other
