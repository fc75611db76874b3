"""What a live stack is made of: its processes, and what carries its CAN frames."""

from collections.abc import Sequence
from typing import Literal

from hal.buses.socketcan import interfaces_up
from services.core.errors import ConfigError
from services.processes import PROCESSES, Process
from services.robotfile.robot_tables import RobotFile

Can = Literal["zenoh", "socketcan", "mixed"]


def choose_can(
    asked: Can | None, interfaces: Sequence[str], real: Sequence[str] = ()
) -> tuple[Can, str]:
    """The transport of a live stack, and why; `real` are the interfaces that have real boards.

    Raises:
        ConfigError: SocketCAN is asked for, and an interface is not up.
    """
    names = ", ".join(interfaces)
    if asked == "socketcan" and not interfaces_up(interfaces):
        raise ConfigError(
            f"--can socketcan: not all of {names} are up; ulna can up makes virtual ones, "
            "--can zenoh needs none"
        )
    if asked is not None:
        return asked, "as asked for"
    if interfaces_up(interfaces):
        return "socketcan", f"the interfaces are up: {names}"
    there = [name for name in real if interfaces_up((name,))]
    if there:
        return (
            "mixed",
            f"real boards are on {', '.join(there)}; the others over zenoh",
        )
    return "zenoh", f"the interfaces are not all up here: {names} (ulna can up makes virtual ones)"


def real_interfaces(robot: RobotFile) -> tuple[str, ...]:
    """Interfaces of the buses that have boards which are not emulated."""
    real = {board.bus for name, board in robot.boards.items() if not robot.is_simulated(name)}
    return tuple(bus.channel for name, bus in robot.buses.items() if name in real)


def rows_for(robot: RobotFile) -> tuple[Process, ...]:
    """The processes to start: boards where some are emulated, controllers where a limb is."""
    emulated = any(robot.is_simulated(board) for board in robot.boards)
    return tuple(
        row
        for row in PROCESSES
        if (emulated or not row.emulated_only)
        and (robot.limbs or not row.reaches)
        and (robot.sensors or not row.feels)
    )
