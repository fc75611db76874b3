"""Discovery and labels, class 7, and the types that boards report (can-protocol 1 and 8).

HAZARD: a discovery (0xFF) makes a running DSP board switch off the PWM of all axes and zero its
broadcast masks, and stops the stream of STRAIN. While the robot moves it is an emergency stop
without a status message.
"""

from enum import IntEnum

from hal.wire.can import CLASS_MANAGEMENT, EVERYBODY, HOST, class_of, low_of, source_of
from hal.wire.layout import OpenLayout, characters, numbered, opaque, u8, u16
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


class Memory(IntEnum):
    """Where a firmware line belongs, in ADDRESS."""

    PROGRAM = 0
    DATA = 1


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
"""Makes an application jump to its boot loader, which answers; 5 s later it leaves by itself."""

ADDRESS = Command(
    CLASS_MANAGEMENT,
    0x01,
    "ADDRESS",
    (u8("bytes"), u16("address"), u8("memory", choices=Memory)),
)
"""Where the bytes of the next DATA frames belong, as a Motorola S-record has it: 5 bytes."""

ADDRESS_EXTENDED = Command(
    CLASS_MANAGEMENT,
    0x01,
    "ADDRESS",
    (u8("bytes"), u16("address"), u8("memory", choices=Memory), u16("upper_address")),
)
"""The same as Intel hex has it: 7 bytes."""

START = Command(CLASS_MANAGEMENT, 0x02, "START", numbered("byte", 4), (u8("ok"),))
DATA = Command(
    CLASS_MANAGEMENT,
    0x03,
    "DATA",
    OpenLayout(numbered("byte", 6), prefix=True, is_opaque=True),
    (u8("ok"),),
)
"""Up to six bytes of a line; each board in its boot loader acknowledges a complete line."""

END = Command(CLASS_MANAGEMENT, 0x04, "END", (), (u8("ok"),))
"""Ends a download and starts the application, which takes it as a ping."""

ERROR = Command(CLASS_MANAGEMENT, 0x05, "ERROR", opaque(prefix=True), opaque(prefix=True))
GET_ADDITIONAL_INFO = Command(
    CLASS_MANAGEMENT, 0x0C, "GET_ADDITIONAL_INFO", (), (u8("index"), *characters(4))
)
SET_ADDITIONAL_INFO = Command(
    CLASS_MANAGEMENT, 0x0D, "SET_ADDITIONAL_INFO", (u8("index"), *characters(4))
)
SET_CAN_ADDRESS = Command(CLASS_MANAGEMENT, 0x32, "SET_CAN_ADDRESS", (u8("address"),))
"""New boards only; older ones take command 50 of class 0 or 0x32 of class 2."""

ROWS = (
    DISCOVER,
    DISCOVER_BOOTLOADER,
    BOARD,
    ADDRESS_EXTENDED,
    ADDRESS,
    START,
    DATA,
    END,
    ERROR,
    GET_ADDITIONAL_INFO,
    SET_ADDITIONAL_INFO,
    SET_CAN_ADDRESS,
)
"""Every form of every row of class 7; of one code the longest comes first."""

COMMANDS: dict[int, Command] = {command.code: command for command in reversed(ROWS)}
"""Rows of class 7 by code."""


def is_discovery(can_id: int, data: bytes) -> bool:
    """True for the host's discovery frame, to whichever address."""
    return (
        class_of(can_id) == CLASS_MANAGEMENT and source_of(can_id) == HOST and data[:1] == b"\xff"
    )


def is_addressed_to(can_id: int, address: int) -> bool:
    """True when the destination of a class 7 frame is `address` or everybody."""
    return low_of(can_id) in (address, EVERYBODY)
