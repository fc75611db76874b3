"""Parts of a robot, and the robot as one site has it: `<robot>:<selection>@<site>`."""

import msgspec

from services.core.errors import ConfigError
from services.robotfile.config_checks import check_gain
from services.robotfile.config_tables import check_numbers, decode, read_toml
from services.robotfile.robot_tables import (
    RobotFile,
    SiteBoardTable,
    SiteBusTable,
    SiteSensorTable,
    SiteStartTable,
)

NOTHING_MISSING = {"allow_missing": False}
SITE_SECTIONS = ("buses", "boards", "sensors", "start")


def split_reference(reference: str) -> tuple[str, str, str]:
    """Name or path of the robot file, selection and site; the last two empty where not given."""
    rest, _, site = reference.partition("@")
    name, _, selection = rest.partition(":")
    return name, selection, site


def select(robot: RobotFile, selection: str) -> RobotFile:
    """The parts of one selection (or one part) with the boards, buses and sensors they need.

    Raises:
        ConfigError: there is no such selection; the known ones are listed.
    """
    parts = robot.selections.get(selection, (selection,))
    if not set(parts) <= set(robot.groups):
        known = ", ".join((*robot.selections, *robot.groups))
        raise ConfigError(f"{robot.path}: unknown selection {selection!r}; known: {known}")
    kept = {part: joints for part, joints in robot.parts.items() if part in parts}
    joints = {joint: robot.joints[joint] for names in kept.values() for joint in names}
    moved = {joint.board for joint in joints.values()}
    boards = {
        name: board for name, board in robot.boards.items() if name in moved or board.part in parts
    }
    buses = {board.bus for board in boards.values()}
    return msgspec.structs.replace(
        robot,
        parts=kept,
        joints=joints,
        boards=boards,
        buses={name: bus for name, bus in robot.buses.items() if name in buses},
        sensors={name: one for name, one in robot.sensors.items() if one.board in boards},
        virtual_sensors={
            name: one
            for name, one in robot.virtual_sensors.items()
            if one.bus in buses and set(one.channels) & set(joints)
        },
        rows=tuple(row for row in robot.rows if set(row.coefficients) <= set(joints)),
    )


def at_site(robot: RobotFile, site: str) -> RobotFile:
    """The robot with the buses, boards and sensors of sites/<site>.toml beside its file.

    Raises:
        ConfigError: no such site (the known ones are listed), or a key that does not fit.
    """
    folder = robot.path.parent / "sites"
    path = folder / f"{site}.toml"
    if not path.is_file():
        known = ", ".join(sorted(each.stem for each in folder.glob("*.toml"))) or "none"
        raise ConfigError(f"no site file {path}; known sites: {known}")
    raw = read_toml(path)
    check_numbers(raw, path, "")
    for section, tables in raw.items():
        if section not in SITE_SECTIONS or not isinstance(tables, dict):
            allowed = ", ".join(SITE_SECTIONS)
            raise ConfigError(f"{path}: {section}: unknown table; allowed: {allowed}")
    buses, boards = dict(robot.buses), dict(robot.boards)
    for name, table in _tables(raw, "buses"):
        if name not in buses:
            raise ConfigError(f"{path}: buses.{name}: unknown bus; known: {', '.join(buses)}")
        bus = decode(table, SiteBusTable, path, f"buses.{name}")
        buses[name] = msgspec.structs.replace(
            buses[name], channel=bus.channel or buses[name].channel, simulated=bus.simulated
        )
    for name, table in _tables(raw, "boards"):
        if name not in boards:
            raise ConfigError(f"{path}: boards.{name}: unknown board; known: {', '.join(boards)}")
        board = decode(table, SiteBoardTable, path, f"boards.{name}")
        boards[name] = msgspec.structs.replace(boards[name], simulated=board.simulated)
    sensors = dict(robot.sensors)
    for name, table in _tables(raw, "sensors"):
        if name not in sensors:
            known = ", ".join(sensors)
            raise ConfigError(f"{path}: sensors.{name}: unknown sensor; known: {known}")
        gain = decode(table, SiteSensorTable, path, f"sensors.{name}").gain
        check_gain(gain, path, f"sensors.{name}.gain")
        sensors[name] = msgspec.structs.replace(sensors[name], gain=gain)
    start = decode(raw.get("start", NOTHING_MISSING), SiteStartTable, path, "start")
    return msgspec.structs.replace(
        robot, buses=buses, boards=boards, sensors=sensors, allow_missing=start.allow_missing
    )


def _tables(raw: object, section: str) -> list[tuple[str, object]]:
    tables = raw.get(section, {}) if isinstance(raw, dict) else {}
    return list(tables.items()) if isinstance(tables, dict) else []
