"""STRAIN force/torque sensors: commands (class 2), force and torque frames (class 3).

Polled words are big-endian, periodic words little-endian (can-protocol 5). A word w stands for
(w - 0x8000) * full_scale / 0x8000. The host poses as a STRAIN too: it broadcasts joint torques in
the same frames (can-protocol 6).
"""

import struct
from collections.abc import Iterable, Sequence
from enum import IntEnum

from hal.wire import analog_setup
from hal.wire.can import (
    CLASS_ANALOG_PERIODIC,
    CLASS_ANALOG_POLLING,
    CLASS_MOTOR_PERIODIC,
    HOST,
    Frame,
    frame_id,
)
from hal.wire.layout import Field, Layout, characters, i16, opaque, u8, u16
from hal.wire.management import FIRMWARE_FIELDS, HOST_PROTOCOL_FIELDS
from hal.wire.message import Command, PeriodicMessage
from hal.wire.numbers import round_half_away

HOST_PROTOCOL = (1, 0)  # STRAIN accepts equality only
ZERO_WORD = 0x8000
CHANNELS = 6  # Fx Fy Fz in N, Tx Ty Tz in Nm


class TxMode(IntEnum):
    """Argument of SET_TXMODE; any other value stops the acquisition."""

    CALIBRATED = 0
    SILENT = 1  # acquires, does not transmit
    RAW = 3  # raw words in the frames of the calibrated ones
    BOTH = 4  # calibrated in FORCE and TORQUE, raw in RAW_FORCE and RAW_TORQUE


class Saturation(IntEnum):
    """State of one channel in the saturation byte."""

    OK = 0
    LOW = 1
    HIGH = 2


class TareMode(IntEnum):
    """First argument of SET_CALIB_TARE and SET_CURR_TARE."""

    CLEAR = 0
    PRESENT = 1
    VALUE = 2


COMMANDS: dict[int, Command] = dict(analog_setup.COMMANDS)
"""Every row of class 2 by its code: those below and those of hal/wire/analog_setup.py."""


def _row(
    code: int,
    name: str,
    request: Iterable[Field] | Layout = (),
    reply: Iterable[Field] | None = None,
) -> Command:
    command = Command(CLASS_ANALOG_POLLING, code, name, request, reply, order=">")
    COMMANDS[code] = command
    return command


_ROW_COLUMN = (u8("row"), u8("column"))
_TARE = (u8("mode", choices=TareMode), u8("channel"), i16("value"))
_CHANNEL = (u8("channel"),)
_CHANNEL_VALUE = (u8("channel"), i16("value"))
_CHANNEL_WORD = (u8("channel"), u16("word"))
_FULL_SCALE = (u8("channel"), u16("full_scale", "N or Nm"))

SET_IIR = _row(0x01, "SET_IIR")  # disabled on STRAIN: acknowledged, nothing else
SET_MATRIX_RC = _row(0x03, "SET_MATRIX_RC", (*_ROW_COLUMN, i16("value", "1/0x8000")))
SET_CH_DAC = _row(0x04, "SET_CH_DAC", _CHANNEL_WORD)
SELECT_ACTIVE_CH = _row(0x05, "SELECT_ACTIVE_CH", (u8("channels"),))  # one bit each
CALIBRATE_OFFSET = _row(0x06, "CALIBRATE_OFFSET", opaque(prefix=True))  # unknown to STRAIN itself
SET_TXMODE = _row(0x07, "SET_TXMODE", (u8("mode", choices=TxMode),))
SET_CANDATARATE = _row(0x08, "SET_CANDATARATE", (u8("period", "ms"),))
SAVE2EE = _row(0x09, "SAVE2EE", (), (u8("ok"),))
GET_MATRIX_RC = _row(0x0A, "GET_MATRIX_RC", _ROW_COLUMN, (*_ROW_COLUMN, i16("value", "1/0x8000")))
GET_CH_DAC = _row(0x0B, "GET_CH_DAC", _CHANNEL, _CHANNEL_WORD)
GET_CH_ADC = _row(
    0x0C,
    "GET_CH_ADC",
    (u8("channel"), u8("calibrated")),
    (u8("channel"), u8("calibrated"), u16("word")),
)
FILTER_EN = _row(0x0D, "FILTER_EN", (u8("value"),))
MUX_EN = _row(0x0E, "MUX_EN", (u8("value"),))
MUX_NUM = _row(0x0F, "MUX_NUM", (u8("value"),))
SET_RESOLUTION = _row(0x10, "SET_RESOLUTION", (u8("resolution"),))  # MAIS
SET_MATRIX_G = _row(0x11, "SET_MATRIX_G", (u8("gain"),))
GET_MATRIX_G = _row(0x12, "GET_MATRIX_G", (), (u8("gain"),))
SET_CALIB_TARE = _row(0x13, "SET_CALIB_TARE", _TARE)
GET_CALIB_TARE = _row(0x14, "GET_CALIB_TARE", _CHANNEL, _CHANNEL_VALUE)
SET_CURR_TARE = _row(0x15, "SET_CURR_TARE", _TARE)
GET_CURR_TARE = _row(0x16, "GET_CURR_TARE", _CHANNEL, _CHANNEL_VALUE)
SET_FULL_SCALES = _row(0x17, "SET_FULL_SCALES", _FULL_SCALE)
GET_FULL_SCALES = _row(0x18, "GET_FULL_SCALES", _CHANNEL, _FULL_SCALE)
SET_SERIAL_NO = _row(0x19, "SET_SERIAL_NO", characters(7))
GET_SERIAL_NO = _row(0x1A, "GET_SERIAL_NO", (), characters(7))
GET_EEPROM_STATUS = _row(0x1B, "GET_EEPROM_STATUS", (), (u8("ram_equals_eeprom"),))
GET_FW_VERSION = _row(
    0x1C,
    "GET_FW_VERSION",
    HOST_PROTOCOL_FIELDS,
    FIRMWARE_FIELDS,
)
SET_BOARD_ADX = _row(0x32, "SET_BOARD_ADX", (u8("address"),))

RESET_CAUSE = Layout(
    (u8("por"), u8("bor"), u8("idle"), u8("lvd_latch"), u8("lvd_enable"), u8("wdto"))
)
"""Payload of the one frame that STRAIN sends at power-up, on its reply identifier."""


def reply_id(source: int) -> int:
    """Identifier of everything that the sensor at `source` answers to the host."""
    return frame_id(CLASS_ANALOG_POLLING, source, HOST)


def ack(source: int) -> Frame:
    """Empty frame with which STRAIN and MAIS acknowledge every SET; a host ignores it."""
    return reply_id(source), b""


def reset_cause(source: int, *flags: int) -> Frame:
    """The six reset-cause flags sent at power-up."""
    return reply_id(source), RESET_CAUSE.pack(*flags)


def parse_reset_cause(data: bytes) -> tuple[int, ...] | None:
    """The six flags; None when this answer of a sensor is not the frame sent at power-up."""
    # No reply has 6 bytes, so the length alone tells it.
    return RESET_CAUSE.parse(data)


def unknown_command(source: int, code: int) -> Frame:
    """STRAIN's answer to a command that it does not know."""
    return reply_id(source), bytes((code,)) + b"BUG"


def is_unknown_command(data: bytes) -> bool:
    """True for STRAIN's answer to a command that it does not know."""
    return len(data) == 4 and data[1:] == b"BUG"


class TripleMessage:
    """Three words of class 3, and a saturation byte once any channel of the sensor is saturated."""

    __slots__ = ("_base", "layout", "name", "saturated_layout", "type")

    def __init__(self, kind: int, name: str, words: tuple[Field, Field, Field]) -> None:
        """`words` are the fields of the three words."""
        self._base = frame_id(CLASS_ANALOG_PERIODIC, HOST, kind)
        self.type = kind
        self.name = name
        self.layout = Layout(words)
        self.saturated_layout = Layout((*words, u8("saturation")))

    def frame(self, source: int, a: int, b: int, c: int, saturation: int | None = None) -> Frame:
        """Frame of 6 bytes, or of 7 with a saturation byte (see `saturation_byte`)."""
        try:
            if saturation is None:
                return self._base | source << 4, self.layout.pack(a, b, c)
            return self._base | source << 4, self.saturated_layout.pack(a, b, c, saturation)
        except struct.error:
            raise self.saturated_layout.refusal(self.name, (a, b, c, saturation or 0)) from None

    def parse(self, data: bytes) -> tuple[int, ...] | None:
        """The three words and the saturation byte, which is 0 in a frame of 6 bytes."""
        if len(data) == 6:
            return *self.layout.unpack(data), 0
        if len(data) == 7:
            return self.saturated_layout.unpack(data)
        return None


_FORCE = (u16("fx"), u16("fy"), u16("fz"))
_TORQUE = (u16("tx"), u16("ty"), u16("tz"))

RAW_FORCE = TripleMessage(0x8, "RAW_FORCE", _FORCE)
RAW_TORQUE = TripleMessage(0x9, "RAW_TORQUE", _TORQUE)
FORCE = TripleMessage(0xA, "FORCE", _FORCE)
TORQUE = TripleMessage(0xB, "TORQUE", _TORQUE)
THERMOMETER = PeriodicMessage(
    CLASS_ANALOG_PERIODIC,
    0xE,
    "THERMOMETER",
    Layout((u8("mask"), i16("temperature0", "0.1 degC"), i16("temperature1", "0.1 degC"))),
)

RECEIVE_OVERFLOW = PeriodicMessage(CLASS_MOTOR_PERIODIC, 0x0, "RECEIVE_OVERFLOW", Layout(()))
"""Empty frame of a STRAIN or MAIS whose receive queue was full."""

MESSAGES: dict[int, TripleMessage | PeriodicMessage] = {
    message.type: message for message in (RAW_FORCE, RAW_TORQUE, FORCE, TORQUE, THERMOMETER)
}
"""Rows of class 3 by type."""


def saturation_byte(first: int, second: int, third: int) -> int:
    """Byte 6 of a frame while the sensor is saturated, from the states of that frame's channels."""
    return 1 | first << 2 | second << 4 | third << 6


def saturation_states(byte: int) -> tuple[int, int, int]:
    """States of the three channels of the frame (see Saturation)."""
    return byte >> 2 & 3, byte >> 4 & 3, byte >> 6 & 3


def to_word(value: float, full_scale: float) -> int:
    """Nearest word of a physical value, limited to the range of the word."""
    return min(max(round_half_away(value * 0x8000 / full_scale) + ZERO_WORD, 0), 0xFFFF)


def to_physical(word: int, full_scale: float) -> float:
    """Physical value of a word, in the unit of the full scale."""
    return (word - ZERO_WORD) * full_scale / 0x8000


def virtual_torque_frames(
    address: int, torques_nm: Sequence[float], full_scales_nm: Sequence[float]
) -> tuple[Frame, Frame, int]:
    """The two frames of a virtual sensor, and how many of its six torques were clamped.

    Clamped, scaled by 0x7FFF and truncated, as the iCub's PC does it. Boards read the words back
    with 0x8000 (`to_physical`): a gain error of 3e-5 that is part of the protocol. Both frames go
    out at every update. NaN raises ValueError: refuse it before.
    """
    words = []
    clamped = 0
    for torque_nm, full_scale_nm in zip(torques_nm, full_scales_nm, strict=True):
        ratio = torque_nm / full_scale_nm
        if ratio > 1.0:
            ratio = 1.0
            clamped += 1
        elif ratio < -1.0:
            ratio = -1.0
            clamped += 1
        words.append(int(ratio * 0x7FFF) + ZERO_WORD)
    a, b, c, d, e, f = words
    return FORCE.frame(address, a, b, c), TORQUE.frame(address, d, e, f), clamped
