"""`ulna can scan`: who answers on each bus, beside who should."""

import sys
from collections.abc import Iterator, Mapping, Sequence
from typing import NamedTuple

from rich import box
from rich.table import Table

from hal.registry import board_type
from hal.scan import Found, Scanner, boards_at
from hal.stocktaking import differences
from hal.wire.management import BoardType
from services.cli.can_buses import NO_NUMBER, Tap, opened, robot_in_use
from services.cli.can_stats import wide_console
from services.core.clock import NS_PER_MS, Clock, RealClock
from services.robotfile.robot_tables import RobotFile
from services.robotfile.wiring import firmware_of, robot_description


class Finding(NamedTuple):
    """One board that answers, or should; `note` is empty where all is as it should be."""

    bus: str
    address: int
    board: str
    found: Found | None
    note: str


def scan(
    taps: Sequence[Tap], clock: Clock, *, discover: bool = False, force: bool = False
) -> tuple[dict[str, dict[int, Found]], list[str]]:
    """What answers on each bus by address, all buses at the same time, and what was refused."""
    scanners = {tap.name: Scanner(tap.bus, clock.now_ns) for tap in taps}
    steps = {
        name: scanner.scan(discover=discover, force=force) for name, scanner in scanners.items()
    }
    found: dict[str, dict[int, Found]] = {}
    while len(found) < len(steps):
        for name in steps.keys() - found.keys():
            try:
                next(steps[name])
            except StopIteration as stop:
                found[name] = boards_at(stop.value)
        clock.sleep_until(clock.now_ns() + NS_PER_MS)
    refused = [f"{name}: {scanner.refused}" for name, scanner in scanners.items()]
    found = {tap.name: found[tap.name] for tap in taps}
    return found, [text for text in refused if not text.endswith(": ")]


def findings(robot: RobotFile, found: Mapping[str, Mapping[int, Found]]) -> Iterator[Finding]:
    """What answers beside what the robot file says, bus by bus in the order of addresses."""
    for bus, answers in found.items():
        expected = {table.address: name for name, table in robot.boards.items() if table.bus == bus}
        seconds = {
            table.address + 1
            for table in robot.boards.values()
            if table.bus == bus and board_type(table.type).addresses == 2
        }
        for address in sorted({*expected, *answers}):
            name = expected.get(address, "")
            one = answers.get(address)
            if address in seconds and not name and one is not None:
                continue  # axes 2 and 3 of a board already listed
            yield Finding(bus, address, name, one, _note(robot, name, one))


def _note(robot: RobotFile, name: str, found: Found | None) -> str:
    """What is not as it should be."""
    if found is None:
        return "does not answer"
    if found.collides:
        return "two boards share this address"
    if found.bootloader and not found.versions:
        return "in its boot loader"
    if not name:
        return "" if not robot.boards else "not in the robot file"
    table = robot.boards[name]
    wanted = board_type(table.type).type_code
    if found.type != wanted:
        return f"should be a {_type_name(wanted)}"
    if found.firmware != firmware_of(robot, name):
        return f"firmware should be {table.firmware}"
    if found.accepted is False:
        return "does not accept the host's protocol"
    return ""


def firmware_text(firmware: tuple[int, int]) -> str:
    """Number as people say it: 2.57 for (0x02, 0x57)."""
    return f"{firmware[0]:x}.{firmware[1]:x}"


def _type_name(code: int | None) -> str:
    try:
        return BoardType(-1 if code is None else code).name
    except ValueError:
        return "?" if code is None else f"type {code}"


def table_of(rows: Sequence[Finding]) -> Table:
    """One line a board."""
    columns = ("bus", "address", "board", "type", "firmware", "protocol", "label", "note")
    table = Table(*columns, box=box.SIMPLE_HEAD)
    for row in rows:
        found = row.found or Found(address=row.address, classes=())
        firmware = "" if found.firmware is None else firmware_text(found.firmware)
        if found.build is not None:
            firmware += f" build {found.build}"
        protocol = "" if found.protocol is None else "{}.{}".format(*found.protocol)
        kind = "" if row.found is None else _type_name(found.type)
        table.add_row(
            row.bus,
            str(row.address),
            row.board,
            kind,
            firmware,
            protocol,
            found.label or found.serial,
            row.note,
        )
    return table


def can_scan(
    *,
    robot: str = "",
    stack: str = "",
    bus: tuple[str, ...] = (),
    discover: bool = False,
    force: bool = False,
) -> int:
    """Ask every address of each bus who is there, and compare with the robot file.

    The questions are harmless while the robot moves. --discover finds boards in their boot loader
    too, but switches off every motor board on the bus; it is refused while an axis has power.

    Example: ulna can scan --bus right_arm

    Args:
        robot: whose buses and boards they are [the running stack's, else icub].
        stack: name of a running stack [the robot's].
        bus: bus of the robot, its number, an interface, or interface:channel of python-can [all].
        discover: send the discovery of class 7, too.
        force: send it even though an axis moves or has power.

    Returns:
        Exit status: 0 all as in the robot file, 1 something is not.
    """
    robot_file, clock = robot_in_use(robot, stack), RealClock()
    with opened(robot_file, bus, stack=stack, clock=clock) as taps:
        found, refused = scan(taps, clock, discover=discover, force=force)
    rows = list(findings(robot_file, found))
    wide_console().print(table_of(rows))
    for text in (*refused, *remedies(robot_file, taps, found)):
        print(text, file=sys.stderr)
    return 1 if refused or any(row.note for row in rows) else 0


def remedies(
    robot: RobotFile, taps: Sequence[Tap], found: Mapping[str, Mapping[int, Found]]
) -> list[str]:
    """What is not as the robot file says, over all buses together, and what to do about it."""
    heard = {tap.number: list(found[tap.name].values()) for tap in taps if tap.number != NO_NUMBER}
    told = differences(heard, robot_description(robot))
    silent = {number for number, found_there in heard.items() if not found_there}
    quiet = [
        f"nobody answers on bus {number} {name}: check the bus, or name the boards in use with "
        "--robot name:parts"
        for name, number in ((tap.name, tap.number) for tap in taps)
        if number in silent and any(one.bus == number for one in told)
    ]
    return [*quiet, *(one.text for one in told if one.bus not in silent)]
