"""`ulna board`: plug one emulated board into a bus, and list the boards of a robot."""

from collections import defaultdict
from typing import Literal

from rich import box
from rich.table import Column, Table

from hal.errors import HalError
from services.cli.can_stats import wide_console
from services.cli.complaint import complain
from services.config import load_robot
from services.core.errors import ServiceError
from services.emulated.plug import Place, addresses_of, plugged
from services.robotfile.robot_tables import RobotFile

WHOLE_ROBOT = "icub"

Can = Literal["zenoh", "socketcan"]


def board_run(
    *,
    address: int,
    bus: str = "",
    type: str = "",
    robot: str = WHOLE_ROBOT,
    can: Can | None = None,
    interface: str = "",
    channel: str = "",
    firmware: str = "",
    stack: str = "",
    hub: str = "",
    seconds: float = 0.0,
    status: bool = False,
    seed: int = 0,
) -> int:
    """Run one emulated board with bench motors in this process, until Ctrl-C.

    What the board is and what it moves stands in the robot file under its bus and address. The
    board boots unconfigured and is then the host's: the HAL of a running stack finds it.

    Args:
        address: CAN address of the board, 1 to 14.
        bus: name, number or interface of one of the robot's buses, as right_arm, 2 or vcan2.
        type: must be the robot file's; bll stands for bll_ie and bll_dc too [the robot file's].
        robot: name[:parts][@site] of a robot in robots/, or a robot file.
        can: what carries the frames [socketcan where the interface is up, else the running stack].
        interface: of python-can, in the place of --can; with --channel.
        channel: of that interface, or a SocketCAN interface that is not the robot file's.
        firmware: as 2.50; needed for a board that the robot file has not, with --type.
        stack: name of the running stack [the robot's].
        hub: endpoint of its hub, as tcp/127.0.0.1:7447 [the running stack's].
        seconds: unplug by itself after so long [0 = never].
        status: print a line every second.
        seed: of the bench's random draws.

    Returns:
        Exit status: 0 unplugged, 1 the stack has ended, 2 could not be plugged in.
    """
    # Here and not above: the compiler behind the emulated boards takes a second to load, and every
    # other verb of the command would wait for it.
    from services.emulated.board_process import Wire, run_board

    try:
        place = Place(bus=bus or channel, address=address, type=type, firmware=firmware)
        chosen = plugged(load_robot(robot), place)
        wire = Wire(can=can or "", interface=interface, channel=channel, stack=stack, hub=hub)
        return run_board(chosen, wire, _say, seconds=seconds, status=status, seed=seed)
    except (ServiceError, HalError) as error:
        complain(error)
        return 2


def board_list(*, robot: str = WHOLE_ROBOT) -> int:
    """List the boards of a robot by bus.

    Args:
        robot: name[:parts][@site] of a robot in robots/, or a robot file.

    Returns:
        Exit status: 0, or 2 where there is no such robot.
    """
    try:
        wide_console().print(board_table(load_robot(robot)))
    except ServiceError as error:
        complain(error)
        return 2
    return 0


def board_table(robot: RobotFile) -> Table:
    """A row for each board, in the order of buses and addresses."""
    joints: dict[str, list[str]] = defaultdict(list)
    for name, joint in sorted(robot.joints.items(), key=lambda pair: pair[1].axis):
        joints[joint.board].append(name)
    moves = Column("moves", min_width=len("r_shoulder_pitch,"))
    head = ("bus", "address", "type", "firmware", "is", moves)
    table = Table(*head, box=box.SIMPLE_HEAD, padding=0)  # fits into 80 columns
    table.columns[0].no_wrap = True
    for bus_name, bus in robot.buses.items():
        on_bus = [(n, b) for n, b in robot.boards.items() if b.bus == bus_name]
        table.add_row(f"{bus.number} {bus_name} {bus.channel}", style="bold")
        for name, board in sorted(on_bus, key=lambda pair: pair[1].address):
            table.add_row(
                f"  {name}",
                ", ".join(str(address) for address in addresses_of(board)),
                board.type,
                board.firmware,
                "simulated" if robot.is_simulated(name) else "real",
                ", ".join(joints[name]),
            )
        table.add_section()
    return table


def _say(text: str) -> None:
    print(text, flush=True)
