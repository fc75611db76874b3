"""Reads a robot file.

A wrong one is refused with the file, the key and what would be allowed there.
"""

import math
import tomllib
from collections.abc import Mapping
from functools import cache
from importlib.resources import files
from pathlib import Path
from typing import TypeVar, get_args, get_type_hints

import msgspec

from services.config_checks import check_references
from services.core.errors import ConfigError
from services.robot_tables import (
    BoardTable,
    BusTable,
    CouplingTable,
    HostTable,
    JointTable,
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

TABLE = TypeVar("TABLE", bound=Strict)

SINGLE: dict[str, type[Strict]] = {"robot": RobotTable, "host": HostTable, "reach": ReachTable}
NAMED: dict[str, type[Strict]] = {
    "buses": BusTable,
    "boards": BoardTable,
    "sensors": SensorTable,
    "virtual_sensors": VirtualSensorTable,
    "couplings": CouplingTable,
    "motors": MotorTable,
    "joints": JointTable,
    "rates": RateTable,
}
SECTIONS = (*SINGLE, *NAMED, "parts", "rows")


def robots_folder() -> Path:
    """Where robot files are.

    Beside the packages in a checkout, inside the package when installed.
    """
    checkout = Path(__file__).resolve().parent.parent / "robots"
    return checkout if checkout.is_dir() else Path(str(files("services") / "_robots"))


@cache
def load_robot(name: str) -> RobotFile:
    """Read and check `robots/<name>/robot.toml`, or the file itself when `name` is a path to one.

    Raises:
        ConfigError: no such robot (the known ones are listed), or a wrong file, with key and
            allowed values.
    """
    path = Path(name) if name.endswith(".toml") else robots_folder() / name / "robot.toml"
    if not path.is_file():
        known = ", ".join(sorted(p.parent.name for p in robots_folder().glob("*/robot.toml")))
        raise ConfigError(f"no robot file {path}; known robots: {known}")
    try:
        raw = tomllib.loads(path.read_text(encoding="utf-8"))
    except tomllib.TOMLDecodeError as error:
        raise ConfigError(f"{path}: not valid TOML: {error}") from error
    return parse_robot(raw, path)


def parse_robot(raw: Mapping[str, object], path: Path) -> RobotFile:
    """Decode the tables of one file and check what refers to what."""
    _check_numbers(raw, path, "")
    for section in raw:
        if section not in SECTIONS:
            raise ConfigError(f"{path}: {section}: unknown table; allowed: {', '.join(SECTIONS)}")
    for section in SECTIONS:
        if section not in raw:
            raise ConfigError(f"{path}: {section}: this table is missing")
    single: dict[str, object] = {
        key: _decode(raw[key], kind, path, key) for key, kind in SINGLE.items()
    }
    named: dict[str, object] = {}
    for section, kind in NAMED.items():
        tables = raw[section]
        if not isinstance(tables, dict):
            raise ConfigError(f"{path}: {section}: expected tables [{section}.<name>]")
        named[section] = {
            key: _decode(table, kind, path, f"{section}.{key}") for key, table in tables.items()
        }
    rows = raw["rows"]
    if not isinstance(rows, list):
        raise ConfigError(f"{path}: rows: expected [[rows]]")
    try:
        parts = msgspec.convert(raw["parts"], dict[str, tuple[str, ...]])
    except msgspec.ValidationError as error:
        raise ConfigError(f"{path}: parts: each needs a list of joints: {error}") from error
    robot = msgspec.convert(
        {
            "path": path,
            **single,
            **named,
            "parts": parts,
            "rows": tuple(_decode(r, RowTable, path, f"rows[{i}]") for i, r in enumerate(rows)),
        },
        RobotFile,
        from_attributes=True,
    )
    check_references(robot)
    return robot


def _decode(table: object, kind: type[TABLE], path: Path, key: str) -> TABLE:
    if isinstance(table, dict):
        _check_keys(table, kind, path, key)
    try:
        return msgspec.convert(table, kind)
    except msgspec.ValidationError as error:
        message, _, where = str(error).partition(" - at `$")
        detail = f"{key}{where.rstrip('`')}"
        raise ConfigError(f"{path}: {detail}: {message[:1].lower()}{message[1:]}") from error


def _check_numbers(value: object, path: Path, key: str) -> None:
    """TOML has nan and inf: no comparison would refuse the first."""
    if isinstance(value, dict):
        for name, inner in value.items():
            _check_numbers(inner, path, f"{key}.{name}" if key else name)
    elif isinstance(value, list):
        for inner in value:
            _check_numbers(inner, path, key)
    elif isinstance(value, float) and not math.isfinite(value):
        raise ConfigError(f"{path}: {key}: {value} is no finite number")


def _check_keys(
    table: Mapping[str, object], kind: type[msgspec.Struct], path: Path, key: str
) -> None:
    """Unknown keys, at every depth, with the allowed ones."""
    allowed = get_type_hints(kind)
    for name, value in table.items():
        if name not in allowed:
            raise ConfigError(f"{path}: {key}.{name}: unknown key; allowed: {', '.join(allowed)}")
        for inner in (allowed[name], *get_args(allowed[name])):
            is_table = isinstance(inner, type) and issubclass(inner, msgspec.Struct)
            if is_table and isinstance(value, dict):
                _check_keys(value, inner, path, f"{key}.{name}")
