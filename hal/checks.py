"""What a robot description must be before a Robot is made of it: complete and encodable."""

from collections.abc import Collection

from hal.axis import Axis
from hal.boards.settings import axis_settings
from hal.couplings import PARTNERS
from hal.description import Board, Joint, RobotDescription
from hal.errors import DescriptionError
from hal.registry import board_type, motor_board_type
from hal.wire.analog import CHANNELS
from hal.wire.layout import WireError
from hal.wire.motor_periodic import PID_VAL, POSITION, STATUS


def check_boards(description: RobotDescription, buses: Collection[int]) -> None:
    """Refuse boards on buses that are not open, and masks that do not fit their addresses.

    Raises:
        DescriptionError: with the board and what is allowed.
    """
    for board in description.boards:
        if board.bus not in buses:
            known = ", ".join(map(str, sorted(buses))) or "none"
            raise DescriptionError(
                f"board {board.name}: bus {board.bus} is not open; open: {known}"
            )
        addresses = board_type(board.type).addresses
        used = any(owner_of(description, joint) is board for joint in description.joints)
        if used and len(board.broadcast) != addresses:
            raise DescriptionError(
                f"board {board.name}: {len(board.broadcast)} broadcast masks; "
                f"a {board.type} needs {addresses}"
            )
        for mask in board.broadcast if used else ():
            _check_mask(board, mask)


def _check_mask(board: Board, mask: int) -> None:
    """The HAL lives on POSITION and STATUS; the boards of a shoulder on each other's PID_VAL."""
    needed = [POSITION, STATUS]
    if board.firmware[1] in PARTNERS:
        needed.append(PID_VAL)
    missing = [message.name for message in needed if not mask & message.mask_bit]
    if missing:
        raise DescriptionError(
            f"board {board.name}: broadcast mask 0x{mask:02X} lacks {', '.join(missing)}"
        )


def check_joints(description: RobotDescription) -> None:
    """Refuse two joints on one axis, and two on one channel of a virtual torque sensor.

    Raises:
        DescriptionError: with both joints.
    """
    taken: dict[tuple[str, int, int, int], str] = {}
    for joint in description.joints:
        places = [("axis", joint.bus, joint.address, joint.axis)]
        source = joint.torque_source
        if source is not None:
            places.append(("torque channel", joint.bus, source.address, source.channel))
            if not 0 <= source.channel < CHANNELS:
                raise DescriptionError(
                    f"joint {joint.name}: torque channel {source.channel} is not within 0..5"
                )
        for place in places:
            other = taken.setdefault(place, joint.name)
            if other != joint.name:
                what, bus, address, number = place
                raise DescriptionError(
                    f"joints {other} and {joint.name} share {what} {number} "
                    f"of address {address} on bus {bus}"
                )


def check_settings(description: RobotDescription, axes: Collection[Axis]) -> None:
    """Refuse settings that no frame can carry.

    Raises:
        DescriptionError: with the joint, the command and the value.
    """
    for axis in axes:
        highest_ma = motor_board_type(owner_of(description, axis.joint).type).max_current_ma
        if not 0 < axis.joint.current_limit_ma <= highest_ma:
            raise DescriptionError(
                f"joint {axis.name}: current_limit_ma {axis.joint.current_limit_ma} "
                f"is not within 1 and {highest_ma}, which is what its board takes"
            )
        for row, values in axis_settings(axis, description):
            try:
                row.request(axis.address, axis.number, *values)
            except WireError as error:
                raise DescriptionError(f"joint {axis.name}: {error}") from error


def owner_of(description: RobotDescription, joint: Joint) -> Board:
    """The board that a joint's axis sits on.

    Raises:
        DescriptionError: there is none.
    """
    for board in description.boards:
        covered = range(board.address, board.address + board_type(board.type).addresses)
        if board.bus == joint.bus and joint.address in covered:
            return board
    raise DescriptionError(
        f"joint {joint.name}: no board at bus {joint.bus}, address {joint.address}"
    )
