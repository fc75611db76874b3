"""Board types by name. A type is imported when the first board of it is made.

An out-of-tree board declares itself in its own pyproject.toml, in the table
[project.entry-points."ulna.boards"]: x = "module:Class".
"""

from collections.abc import Callable, Sequence
from importlib import import_module
from importlib.metadata import entry_points
from typing import cast

from firmware_sim.boards.board import Board, BoardError
from firmware_sim.description import BoardSpec

MOTOR_BOARDS = {
    "bll": "firmware_sim.boards.bll:Bll",
    "bll_dc": "firmware_sim.boards.bll_dc:BllDc",
    "bll_ie": "firmware_sim.boards.bll_ie:BllIe",
    "dc4": "firmware_sim.boards.dc4:Dc4",
}
"""Built from their BoardSpec alone."""

SENSOR_BOARDS = {
    "strain": "firmware_sim.boards.strain:Strain",
    "strain2": "firmware_sim.boards.strain2:Strain2",
}
"""Built from their BoardSpec and the full scales that stand in their EEPROM."""

PLAIN_SENSOR_BOARDS = {
    "imu": "firmware_sim.boards.imu:Imu",
    "mais": "firmware_sim.boards.mais:Mais",
    "mtb": "firmware_sim.boards.mtb:Mtb",
}
"""Built from their BoardSpec alone."""

ENTRY_POINTS = "ulna.boards"

PlainFactory = Callable[[BoardSpec], Board]
SensorFactory = Callable[[BoardSpec, Sequence[float]], Board]


def make_board(spec: BoardSpec, full_scale: Sequence[float] | None = None) -> Board:
    """Build the board that `spec` names.

    Args:
        spec: where it sits, its type and firmware.
        full_scale: N, N, N, Nm, Nm, Nm; given for force/torque boards only.

    Raises:
        BoardError: no such type or firmware, or a sensor without full scales.
    """
    factory = _load(spec.type)
    if full_scale is not None:
        return cast("SensorFactory", factory)(spec, full_scale)
    if spec.type in SENSOR_BOARDS:
        raise BoardError(
            f"{spec.type} at bus {spec.bus} address {spec.address} has no sensor with full scales"
        )
    return cast("PlainFactory", factory)(spec)


def _load(name: str) -> object:
    known = MOTOR_BOARDS | SENSOR_BOARDS | PLAIN_SENSOR_BOARDS
    place = known.get(name)
    if place is not None:
        module, _, attribute = place.partition(":")
        factory: object = getattr(import_module(module), attribute)
        return factory
    others = {point.name: point for point in entry_points(group=ENTRY_POINTS)}
    if name in others:
        return cast("object", others[name].load())
    raise BoardError(f"unknown board type {name!r}; known: {', '.join(sorted({*known, *others}))}")
