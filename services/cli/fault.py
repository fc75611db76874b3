"""`ulna board fault` and `ulna board faults`: faults of a running emulated robot, on and off."""

import sys

import msgspec
from rich.console import Console
from rich.table import Table

from firmware_sim.switch_table import SWITCHES
from services.cli.can_dbc import bus_named
from services.cli.complaint import complain
from services.config import load_robot
from services.core.client import Client
from services.core.clock import RealClock
from services.core.errors import ServiceError
from services.core.rundir import read_record
from services.emulated.messages import FaultRequest
from services.streams import FAULT_CALL

FAILED = 2


def board_fault(
    kind: str,
    *,
    bus: str = "",
    address: int | None = None,
    axis: int | None = None,
    value: int | None = None,
    off: bool = False,
    identifier: str = "",
    count: int = 0,
    share: float = 1.0,
    seed: int = 0,
    milliseconds: int = 0,
    stack: str = "icub",
) -> int:
    """Switch a fault of the running emulated robot on, or off; `ulna board faults` lists them.

    Example: ulna board fault encoder --bus 2 --address 1 --axis 0

    Args:
        kind: name of the fault.
        bus: name, number or interface of a bus, as right_arm, 2 or vcan2.
        address: CAN address of the board; without it, the whole bus.
        axis: 0 or 1 at that address.
        value: what the kind says: Hall code, mA, channel, taxel or triangle.
        off: switch it off; without a value, whatever of that kind is on at that place.
        identifier: frames: only this one, hexadecimal [every one].
        count: frames: so many, then no more [0 = without end].
        share: frames: so many of all, 0 to 1.
        seed: of that share's draw.
        milliseconds: how long a frame is delayed, or a board away.
        stack: name of the running stack.

    Returns:
        Exit status: 0 switched, 1 refused, 2 nobody to ask.
    """
    try:
        request = FaultRequest(
            kind=kind,
            on=not off,
            address=address,
            axis=axis,
            value=value,
            can_id=int(identifier, 16) if identifier else None,
            count=count,
            share=share,
            seed=seed,
            milliseconds=milliseconds,
        )
    except ValueError:
        complain(f"{identifier!r} is no hexadecimal identifier")
        return FAILED
    try:
        record = read_record(stack)
        if bus:
            robot = load_robot(record.reference or record.robot)
            number = robot.buses[bus_named(robot, bus)].number
            request = msgspec.structs.replace(request, bus=number)
        with Client(record.robot, record.endpoint, RealClock()) as client:
            reply = client.call(FAULT_CALL, request)
    except ServiceError as error:
        complain(error)
        return FAILED
    print(reply.reason, file=sys.stdout if reply.ok else sys.stderr)
    return 0 if reply.ok else 1


def board_faults() -> int:
    """List the faults that an emulated robot can be given.

    Returns:
        Exit status: 0.
    """
    Console().print(fault_table())
    return 0


def fault_table() -> Table:
    """A row for each kind."""
    table = Table("fault", "where", "value", "what happens", title=f"{len(SWITCHES)} faults")
    for row in SWITCHES.values():
        table.add_row(row.name, row.needs.value, row.value, row.text)
    return table
