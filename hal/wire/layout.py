"""Fields of a payload and their compiled layout.

A field is stated once: name, type, unit, meaning of its codes. Codec, `frames.describe`, DBC file
and documentation derive from it. A value is always the raw number on the wire. Encoding a value
that does not fit raises WireError; decoding never raises.
"""

import struct
from collections.abc import Callable, Iterable
from enum import IntEnum, IntFlag
from typing import NamedTuple

Choices = type[IntEnum] | type[IntFlag]

_STRUCT_CODE = {"u8": "B", "u16": "H", "i16": "h", "u32": "I", "i32": "i"}
VALUE_RANGES = {
    "u4": (0, 0xF),
    "u8": (0, 0xFF),
    "u16": (0, 0xFFFF),
    "i16": (-0x8000, 0x7FFF),
    "u32": (0, 0xFFFF_FFFF),
    "i32": (-0x8000_0000, 0x7FFF_FFFF),
}


class WireError(ValueError):
    """A value does not fit the field that should carry it."""


class Field(NamedTuple):
    """One field of a payload; `kind` is u4, u8, u16, i16, u32, i32 or pad."""

    name: str
    kind: str
    unit: str = ""
    choices: Choices | None = None  # names of the codes (IntEnum) or bits (IntFlag)
    size_bytes: int = 1

    def text(self, value: int) -> str:
        """Name and value, with unit or the name of the code."""
        return f"{self.name}={self._value_text(value)}"

    def _value_text(self, value: int) -> str:
        if self.choices is not None:
            try:
                name = self.choices(value).name
            except ValueError:
                name = None
            return name or f"0x{value:02X}"
        if not self.unit:
            return str(value)
        by = "x " if self.unit[0].isdigit() else ""  # 11 x 10 tick/s
        return f"{value} {by}{self.unit}"


def u4(name: str, unit: str = "", choices: Choices | None = None) -> Field:
    """Unsigned half of a byte, in a NibblePair."""
    return Field(name, "u4", unit, choices, 0)


def u8(name: str, unit: str = "", choices: Choices | None = None) -> Field:
    """Unsigned byte."""
    return Field(name, "u8", unit, choices)


def u16(name: str, unit: str = "", choices: Choices | None = None) -> Field:
    """Unsigned 16-bit word."""
    return Field(name, "u16", unit, choices, 2)


def i16(name: str, unit: str = "") -> Field:
    """Signed 16-bit word."""
    return Field(name, "i16", unit, None, 2)


def u32(name: str, unit: str = "") -> Field:
    """Unsigned 32-bit word."""
    return Field(name, "u32", unit, None, 4)


def i32(name: str, unit: str = "") -> Field:
    """Signed 32-bit word."""
    return Field(name, "i32", unit, None, 4)


def pad(size_bytes: int) -> Field:
    """Bytes sent as zero and ignored by the receiver; carries no value."""
    return Field("", "pad", "", None, size_bytes)


def characters(count: int) -> tuple[Field, ...]:
    """Text, one unsigned byte per character; unused characters are zero."""
    return numbered("character", count)


def numbered(name: str, count: int, first: int = 0) -> tuple[Field, ...]:
    """Bytes that differ by a number behind their name."""
    return tuple(u8(f"{name}{index}") for index in range(first, first + count))


class Layout:
    """A compiled payload: `fields` behind an optional code byte, in one byte order."""

    __slots__ = ("dlc", "fields", "offsets", "order", "pack", "unpack")

    def __init__(self, fields: Iterable[Field], *, order: str = "<", prefix: bool = False) -> None:
        """`order` is "<" (little-endian) or ">"; `prefix` makes room for byte 0, the code."""
        every = tuple(fields)
        self.order = order
        self.fields = tuple(field for field in every if field.kind != "pad")
        body = "".join(
            f"{field.size_bytes}x" if field.kind == "pad" else _STRUCT_CODE[field.kind]
            for field in every
        )
        self.pack: Callable[..., bytes] = struct.Struct(
            f"{order}{'B' if prefix else ''}{body}"
        ).pack
        decoder = struct.Struct(f"{order}{'x' if prefix else ''}{body}")
        self.unpack: Callable[[bytes], tuple[int, ...]] = decoder.unpack
        self.dlc = decoder.size
        offsets = []
        position = int(prefix)
        for field in every:
            if field.kind != "pad":
                offsets.append(position)
            position += field.size_bytes
        self.offsets = tuple(offsets)

    def parse(self, data: bytes) -> tuple[int, ...] | None:
        """Values of the fields, None when the length is not exactly the layout's."""
        if len(data) == self.dlc:
            return self.unpack(data)
        return None

    def parse_lenient(self, data: bytes) -> tuple[int, ...]:
        """Values of the fields from a payload of any length: extra bytes ignored.

        DELIBERATE: missing bytes read as zero; a DSP board would find whatever its buffer held.
        """
        return self.unpack(data[: self.dlc].ljust(self.dlc, b"\0"))

    def refusal(self, name: str, values: tuple[int, ...]) -> WireError:
        """The error that names the first value that does not fit."""
        if len(values) != len(self.fields):
            names = ", ".join(field.name for field in self.fields) or "nothing"
            return WireError(f"{name} carries {names}; got {len(values)} values")
        for field, value in zip(self.fields, values, strict=True):
            low, high = VALUE_RANGES[field.kind]
            if not (hasattr(value, "__index__") and low <= value <= high):
                return WireError(f"{name}: {field.name} = {value!r} does not fit {field.kind}")
        return WireError(f"{name}: code or axis does not fit byte 0")

    def bits(self) -> list[tuple[Field, int, int]]:
        """Each field with its first bit and its size in bits; bit 0 of byte n is bit 8 n."""
        return [
            (field, 8 * offset, 8 * field.size_bytes)
            for field, offset in zip(self.fields, self.offsets, strict=True)
        ]

    def text(self, values: tuple[int, ...]) -> str:
        """The values by name, with units and the names of codes."""
        return ", ".join(
            field.text(value) for field, value in zip(self.fields, values, strict=False)
        )


class OpenLayout(Layout):
    """Single bytes of which a frame may carry only the first ones, at least `least` of them."""

    __slots__ = ("_prefix", "is_opaque", "least")

    def __init__(
        self,
        fields: Iterable[Field],
        *,
        least: int = 0,
        prefix: bool = False,
        is_opaque: bool = False,
    ) -> None:
        """`fields` are u8; `least` counts fields; `prefix` makes room for byte 0, the code."""
        super().__init__(fields, prefix=prefix)
        self.is_opaque = is_opaque  # names of its bytes say nothing
        self._prefix = int(prefix)
        self.least = least
        self.pack = self._pack
        self.unpack = self._unpack

    def parse(self, data: bytes) -> tuple[int, ...] | None:
        """The bytes that there are; None when they are too few or too many."""
        if self._prefix + self.least <= len(data) <= self.dlc:
            return self._unpack(data)
        return None

    def parse_lenient(self, data: bytes) -> tuple[int, ...]:
        """The bytes that there are, of a payload of any length."""
        return self._unpack(data[: self.dlc])

    def refusal(self, name: str, values: tuple[int, ...]) -> WireError:
        """The error that names the first byte that does not fit."""
        if not self.least <= len(values) <= len(self.fields):
            most = len(self.fields)
            return WireError(f"{name} carries {self.least} to {most} bytes; got {len(values)}")
        padded = (*values, *(0,) * (len(self.fields) - len(values)))
        return super().refusal(name, padded)

    def _pack(self, *values: int) -> bytes:
        if not self._prefix + self.least <= len(values) <= self.dlc:
            raise struct.error("wrong number of bytes")
        return struct.pack(f"{len(values)}B", *values)

    def _unpack(self, data: bytes) -> tuple[int, ...]:
        return tuple(data[self._prefix :])


def opaque(*, prefix: bool = False) -> OpenLayout:
    """A payload whose meaning no source tells: kept byte by byte."""
    fields = numbered("byte", 8 - prefix, first=int(prefix))
    return OpenLayout(fields, prefix=prefix, is_opaque=True)


class NibblePair(Layout):
    """One byte that carries two values: the low half first, then the high half."""

    __slots__ = ()

    def __init__(self, low: Field, high: Field) -> None:
        """`low` and `high` are u4 fields."""
        super().__init__((u8("pair"),))
        self.fields = (low, high)
        self.offsets = (0, 0)
        self.pack = _pack_nibbles
        self.unpack = _unpack_nibbles

    def bits(self) -> list[tuple[Field, int, int]]:
        """The low half, then the high half."""
        low, high = self.fields
        return [(low, 0, 4), (high, 4, 4)]


def _pack_nibbles(low: int, high: int) -> bytes:
    if not (0 <= low <= 0xF and 0 <= high <= 0xF):
        raise struct.error("half a byte holds 0 to 15")
    return bytes((low | high << 4,))


def _unpack_nibbles(data: bytes) -> tuple[int, ...]:
    return data[0] & 0xF, data[0] >> 4
