"""Tables of a TOML file as typed structs; what does not fit is refused with its key."""

import math
import tomllib
from collections.abc import Mapping
from pathlib import Path
from typing import TypeVar, get_args, get_type_hints

import msgspec

from services.core.errors import ConfigError
from services.robotfile.robot_tables import Strict

TABLE = TypeVar("TABLE", bound=Strict)


def read_toml(path: Path) -> Mapping[str, object]:
    """The tables of a file; ConfigError where it is no TOML."""
    try:
        return tomllib.loads(path.read_text(encoding="utf-8"))
    except tomllib.TOMLDecodeError as error:
        raise ConfigError(f"{path}: not valid TOML: {error}") from error


def decode_named(
    raw: Mapping[str, object], section: str, kind: type[TABLE], path: Path
) -> dict[str, TABLE]:
    """Every table [section.<name>]."""
    tables = raw[section]
    if not isinstance(tables, dict):
        raise ConfigError(f"{path}: {section}: expected tables [{section}.<name>]")
    return {key: decode(table, kind, path, f"{section}.{key}") for key, table in tables.items()}


def with_types(raw: Mapping[str, object], path: Path) -> object:
    """The joints, each with the values of the [joint_types.<name>] that its key `like` names."""
    joints, types = raw["joints"], raw.get("joint_types", {})
    if not isinstance(joints, dict) or not isinstance(types, dict):
        return joints
    merged: dict[str, object] = {}
    for name, joint in joints.items():
        own = joint if isinstance(joint, dict) else {}
        like = own.get("like")
        if like is None:
            merged[name] = joint
            continue
        shared = types.get(like)
        if not isinstance(shared, dict):
            known = ", ".join(types)
            raise ConfigError(f"{path}: joints.{name}.like: unknown type {like!r}; known: {known}")
        merged[name] = {**shared, **{key: value for key, value in own.items() if key != "like"}}
    return merged


def decode(table: object, kind: type[TABLE], path: Path, key: str) -> TABLE:
    """One table of the file as `kind`; ConfigError names what does not fit, and what would."""
    if isinstance(table, dict):
        _check_keys(table, kind, path, key)
    try:
        return msgspec.convert(table, kind)
    except msgspec.ValidationError as error:
        message, _, where = str(error).partition(" - at `$")
        detail = f"{key}{where.rstrip('`')}"
        raise ConfigError(f"{path}: {detail}: {message[:1].lower()}{message[1:]}") from error


def check_numbers(value: object, path: Path, key: str) -> None:
    """Refuse nan and inf, which TOML has and which no comparison would refuse."""
    if isinstance(value, dict):
        for name, inner in value.items():
            check_numbers(inner, path, f"{key}.{name}" if key else name)
    elif isinstance(value, list):
        for inner in value:
            check_numbers(inner, path, key)
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
