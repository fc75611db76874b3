"""Reads a robot file.

A wrong one is refused with the file, the key and what would be allowed there.
"""

from collections.abc import Mapping
from functools import cache
from importlib.resources import files
from pathlib import Path

import msgspec

from services.core.errors import ConfigError
from services.robotfile.config_checks import check_references
from services.robotfile.config_tables import (
    check_numbers,
    decode,
    decode_named,
    read_toml,
    with_types,
)
from services.robotfile.robot_selection import at_site, select, split_reference
from services.robotfile.robot_tables import (
    BoardTable,
    BusTable,
    HostTable,
    JointTable,
    LimbTable,
    MotorTable,
    RateTable,
    ReachTable,
    RobotFile,
    RobotTable,
    RowTable,
    SensorTable,
    Strict,
    VirtualSensorTable,
)

SINGLE: dict[str, type[Strict]] = {"robot": RobotTable, "host": HostTable, "reach": ReachTable}
NAMED: dict[str, type[Strict]] = {
    "buses": BusTable,
    "boards": BoardTable,
    "sensors": SensorTable,
    "virtual_sensors": VirtualSensorTable,
    "motors": MotorTable,
    "joints": JointTable,
    "rates": RateTable,
    "limbs": LimbTable,
}
OPTIONAL = ("joint_types", "selections")
SECTIONS = (*SINGLE, *NAMED, "parts", "rows")


def robots_folder() -> Path:
    """Where robot files are.

    Beside the packages in a checkout, inside the package when installed.
    """
    checkout = Path(__file__).resolve().parent.parent / "robots"
    return checkout if checkout.is_dir() else Path(str(files("services") / "_robots"))


@cache
def load_robot(reference: str) -> RobotFile:
    """Read and check a robot file.

    Args:
        reference: `<name>` of a folder in robots/, or the path of a file that ends in .toml; behind
            it `:<selection>` takes some parts only, and `@<site>` the buses and boards as
            sites/<site>.toml beside the file has them.

    Raises:
        ConfigError: no such robot, selection or site (the known ones are listed), or a wrong file,
            with key and allowed values.
    """
    name, selection, site = split_reference(reference)
    path = Path(name) if name.endswith(".toml") else robots_folder() / name / "robot.toml"
    if not path.is_file():
        known = ", ".join(sorted(p.parent.name for p in robots_folder().glob("*/robot.toml")))
        raise ConfigError(f"no robot file {path}; known robots: {known}")
    robot = parse_robot(read_toml(path), path)
    if site:
        robot = at_site(robot, site)
    return select(robot, selection) if selection else robot


def parse_robot(raw: Mapping[str, object], path: Path) -> RobotFile:
    """Decode the tables of one file and check what refers to what."""
    check_numbers(raw, path, "")
    _check_sections(raw, path)
    raw = {**raw, "joints": with_types(raw, path)}
    single: dict[str, object] = {
        key: decode(raw[key], kind, path, key) for key, kind in SINGLE.items()
    }
    named = {section: decode_named(raw, section, kind, path) for section, kind in NAMED.items()}
    limbs = named.pop("limbs")
    rows = raw["rows"]
    if not isinstance(rows, list):
        raise ConfigError(f"{path}: rows: expected [[rows]]")
    robot = msgspec.convert(
        {
            "path": path,
            **single,
            **named,
            "limb_tables": limbs,
            "main_job": single["reach"],
            "parts": _lists(raw, "parts", "joints", path),
            "selections": _lists(raw, "selections", "parts", path),
            "rows": tuple(decode(r, RowTable, path, f"rows[{i}]") for i, r in enumerate(rows)),
        },
        RobotFile,
        from_attributes=True,
    )
    check_references(robot)
    return robot


def _check_sections(raw: Mapping[str, object], path: Path) -> None:
    for section in raw:
        if section not in (*SECTIONS, *OPTIONAL):
            allowed = ", ".join((*SECTIONS, *OPTIONAL))
            raise ConfigError(f"{path}: {section}: unknown table; allowed: {allowed}")
    for section in SECTIONS:
        if section not in raw:
            raise ConfigError(f"{path}: {section}: this table is missing")


def _lists(raw: Mapping[str, object], section: str, of: str, path: Path) -> object:
    try:
        return msgspec.convert(raw.get(section, {}), dict[str, tuple[str, ...]])
    except msgspec.ValidationError as error:
        raise ConfigError(f"{path}: {section}: each needs a list of {of}: {error}") from error
