"""Discovery and labels, class 7, and the types that boards report (can-protocol 1 and 8).

HAZARD: a discovery (0xFF) makes a running DSP board switch off the PWM of all axes and zero its
broadcast masks, and stops the stream of STRAIN. While the robot moves it is an emergency stop
without a status message.
"""

from enum import IntEnum

from hal.wire.can import CLASS_MANAGEMENT, EVERYBODY, HOST, class_of, low_of, source_of
from hal.wire.layout import characters, u8
from hal.wire.message import Command


class BoardType(IntEnum):
    """Board types; BLL is also reported by 2BLL, BLL_IE and 2BLLDC."""

    GENERIC_DSP = 0  # every DSP bootloader
    PIC = 1
    DC2 = 2
    DC4 = 3
    BLL = 4
    SKIN = 5
    STRAIN = 6
    MAIS = 7
    FOC2 = 8
    SG6 = 9
    JOG = 10
    MTB4 = 11
    STRAIN2 = 12
    RFE = 13
    SG3 = 14
    PSC = 15
    MTB4W = 16
    PMC = 17
    AMCBLDC = 18
    BMS = 19
    MTB4C = 20
    AMC2C = 21
    STRAIN2C = 22
    BAT = 23
    AMCFOC2C = 24
    AMCMJ1 = 25
    UNKNOWN = 255


_VERSION = (u8("board_type", choices=BoardType), u8("firmware_major"), u8("firmware_minor"))

HOST_PROTOCOL_FIELDS = (u8("host_protocol_major"), u8("host_protocol_minor"))
FIRMWARE_FIELDS = (
    *_VERSION,
    u8("build"),
    u8("protocol_major"),
    u8("protocol_minor"),
    u8("accepted"),
)
"""The handshake of classes 0 and 2: what the host states and what the board answers."""

DISCOVER = Command(CLASS_MANAGEMENT, 0xFF, "DISCOVER", (), (*_VERSION, u8("build")))
"""Asks one address or EVERYBODY; this reply is the application's, of 5 bytes."""

DISCOVER_BOOTLOADER = Command(CLASS_MANAGEMENT, 0xFF, "DISCOVER", (), _VERSION)
"""The same question; this reply is the bootloader's, of 4 bytes."""

BOARD = Command(CLASS_MANAGEMENT, 0x00, "BOARD", (u8("eeprom"),), (u8("ok"),))
START = Command(CLASS_MANAGEMENT, 0x02, "START", characters(4), (u8("ok"),))
END = Command(CLASS_MANAGEMENT, 0x04, "END", (), (u8("ok"),))
GET_ADDITIONAL_INFO = Command(
    CLASS_MANAGEMENT, 0x0C, "GET_ADDITIONAL_INFO", (), (u8("index"), *characters(4))
)
SET_ADDITIONAL_INFO = Command(
    CLASS_MANAGEMENT, 0x0D, "SET_ADDITIONAL_INFO", (u8("index"), *characters(4))
)

COMMANDS: dict[int, Command] = {
    command.code: command
    for command in (DISCOVER, BOARD, START, END, GET_ADDITIONAL_INFO, SET_ADDITIONAL_INFO)
}
"""Rows of class 7 by code."""


def is_discovery(can_id: int, data: bytes) -> bool:
    """True for the host's discovery frame, to whichever address."""
    return (
        class_of(can_id) == CLASS_MANAGEMENT and source_of(can_id) == HOST and data[:1] == b"\xff"
    )


def is_addressed_to(can_id: int, address: int) -> bool:
    """True when the destination of a class 7 frame is `address` or everybody."""
    return low_of(can_id) in (address, EVERYBODY)
