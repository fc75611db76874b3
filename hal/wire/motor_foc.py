"""Polled commands that only the boards of later robots know: 2FOC and AMC (class 0).

DSP boards ignore these codes (can-protocol 2.1, marked with a dash). A layout that the sheet does
not give is kept byte by byte, so that a listing names the command; I2T_PARAMS is as the 2FOC
firmware reads it (robotology/icub-firmware, 2FOC-V3_6, can_icubProto_parser.c).
"""

from hal.wire.layout import Field, i16, i32, opaque, pad, u8, u16
from hal.wire.message import AxisCommand, Payload

COMMANDS: dict[int, AxisCommand] = {}
"""Every row by its code."""


def _row(code: int, name: str, request: Payload = (), reply: Payload | None = None) -> AxisCommand:
    command = AxisCommand(code, name, request, reply, lenient=request == ())
    COMMANDS[code] = command
    return command


def _pair(set_code: int, get_code: int, name: str, *fields: Field) -> None:
    """A SET and the GET whose reply has the same layout; opaque where no field is given."""
    if fields:
        _row(set_code, f"SET_{name}", fields)
        _row(get_code, f"GET_{name}", (), fields)
    else:
        _row(set_code, f"SET_{name}", opaque(prefix=True))
        _row(get_code, f"GET_{name}", opaque(prefix=True), opaque(prefix=True))


_PID = (i16("kp"), i16("ki"), i16("kd"), u8("shift"))

_pair(1, 2, "MOTOR_PARAM")
_row(5, "SET", opaque(prefix=True))
_row(6, "GET", opaque(prefix=True), opaque(prefix=True))
_row(70, "GET_ACTIVE_ENCODER_POSITION", opaque(prefix=True), opaque(prefix=True))
_row(71, "SET_ACTIVE_ENCODER_POSITION", opaque(prefix=True))
SET_CURRENT_LIMIT = _row(  # the code of the DSP boards, told apart by its 8 bytes
    72,
    "SET_CURRENT_LIMITS",
    (pad(1), i16("nominal", "mA"), i16("peak", "mA"), i16("overload", "mA")),
)
_row(77, "SET_SMOOTH_PID", opaque(prefix=True))
_pair(101, 102, "CURRENT_PID", *_PID)
_pair(103, 104, "CURRENT_PIDLIMITS")
_pair(105, 106, "VELOCITY_PID", *_PID)
_pair(107, 108, "VELOCITY_PIDLIMITS")
_pair(109, 110, "DESIRED_CURRENT", i32("current", "mA"))
_row(111, "SET_PERIODIC_MSG_CONTENTS", (u8("item0"), u8("item1"), u8("item2"), u8("item3")))
_pair(112, 113, "I2T_PARAMS", u16("time"), u16("threshold"))
_pair(
    119,
    123,
    "MOTOR_CONFIG",
    u8("flags"),
    i16("encoder_ticks"),
    i16("offset"),
    u8("poles"),
    u8("tolerance"),
)
_pair(121, 122, "TEMPERATURE_LIMIT")
_row(124, "GET_CURRENT_LIMIT", opaque(prefix=True), opaque(prefix=True))
_pair(125, 126, "PID")
