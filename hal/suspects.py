"""Why an axis may be in hardware fault although no bit of its STATUS says so.

Boards fault without a bit when something falls silent that they need (can-protocol 10.3). The host
hears the same buses, so it can tell what it was.
"""

from collections.abc import Callable, Sequence
from functools import partial

from hal.axis import Axis
from hal.boards.board import HostBoard
from hal.couplings import needed_boards
from hal.torques import VirtualSensor, is_force_controlled

SILENT_NS = 60_000_000  # a board waits 100 ms for another one

Suspect = Callable[[int], str]


def suspect_boards(boards: Sequence[HostBoard]) -> None:
    """Tell every axis which other boards it needs."""
    known = {board.board: board for board in boards}
    for board in boards:
        for needed in needed_boards(board.board, list(known)):
            for axis in board.axes:
                axis.suspects.append(partial(_silent_board, known[needed]))


def suspect_torques(sensors: Sequence[VirtualSensor]) -> None:
    """Tell every axis where its torque comes from."""
    for sensor in sensors:
        for axis in sensor.axes:
            axis.suspects.append(partial(_silent_torques, sensor, axis))


def _silent_board(board: HostBoard, now_ns: int) -> str:
    if all(now_ns - pulse.heard_ns <= SILENT_NS for pulse in board.pulses):
        return ""
    if board.board.type == "mais":
        return f"MAIS {board.board.name} silent, check its cable and power"
    return f"coupled board {board.board.name} silent"


def _silent_torques(sensor: VirtualSensor, axis: Axis, now_ns: int) -> str:
    was_driven = axis.is_compliant or is_force_controlled(axis)
    if was_driven and not sensor.is_fresh(now_ns):
        return "no joint torques for too long"
    return ""
