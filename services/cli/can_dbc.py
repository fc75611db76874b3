"""`ulna can dbc` and `ulna can docs`: the frame tables for other tools and for people."""

import sys
from collections.abc import Iterator
from pathlib import Path

from hal.wire.dbc import Node, dbc_text
from hal.wire.manual import manual_text
from services.config import load_robot
from services.core.errors import ConfigError
from services.robotfile.robot_tables import RobotFile


def bus_nodes(robot: RobotFile, bus: str) -> Iterator[Node]:
    """Every address of one bus, under the names of the robot file."""
    for name, board in robot.boards.items():
        if board.bus != bus:
            continue
        axes = [""] * 4
        for joint, table in robot.joints.items():
            if table.board == name:
                factor, zero = table.ticks_per_deg, table.zero_deg
                axes[table.axis] = f"axis {table.axis % 2} {joint}: deg = tick / {factor} - {zero}"
        first, second = ("; ".join(filter(None, axes[i : i + 2])) for i in (0, 2))
        yield Node(board.address, board.type, name, first)
        if board.type == "dc4":
            yield Node(board.address + 1, "dc4 second", f"{name}_2", second)
    for name, virtual in robot.virtual_sensors.items():
        if virtual.bus == bus:
            yield Node(virtual.address, "virtual", f"{name}_virtual", ", ".join(virtual.channels))


def every_node(robot: RobotFile) -> list[Node]:
    """Every address and type that the robot has on any bus, under names of no bus."""
    nodes = {
        (node.address, node.kind): Node(node.address, node.kind, f"board{node.address}")
        for bus in robot.buses
        for node in bus_nodes(robot, bus)
    }
    return [nodes[place] for place in sorted(nodes)]


def can_dbc(*, robot: str = "icub", bus: str = "", out: Path | None = None) -> int:
    """Write a DBC file for cantools, SavvyCAN and others.

    For all buses at once under the numbers of the boards, or for one bus under their names.
    A frame may be shorter than its message: read it with truncation allowed.

    Example: ulna can dbc --bus right_arm --out right_arm.dbc

    Args:
        robot: whose boards they are.
        bus: name, number or interface of a bus of the robot file [all].
        out: file to write [standard output].
    """
    robot_file = load_robot(robot)
    nodes = list(bus_nodes(robot_file, bus_named(robot_file, bus))) if bus else None
    return _written(dbc_text(every_node(robot_file) if nodes is None else nodes), out)


def bus_named(robot: RobotFile, text: str) -> str:
    """The bus of that name, number or interface.

    Raises:
        ConfigError: none is.
    """
    for name, table in robot.buses.items():
        if text in (name, str(table.number), table.channel):
            return name
    known = ", ".join(f"{name} ({table.number})" for name, table in robot.buses.items())
    raise ConfigError(f"{robot.robot.name} has no bus {text!r}; known: {known}")


def can_docs(*, out: Path | None = None) -> int:
    """Write the page about the frames (docs/protocol.md) from their tables.

    Example: ulna can docs --out docs/protocol.md

    Args:
        out: file to write [standard output].
    """
    return _written(manual_text(), out)


def _written(text: str, out: Path | None) -> int:
    if out is None:
        sys.stdout.write(text)
        return 0
    try:
        out.write_text(text, encoding="utf-8")
    except OSError as error:
        raise ConfigError(f"cannot write {out}: {error.strerror}") from error
    return 0
