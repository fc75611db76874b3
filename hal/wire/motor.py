"""Polled motor commands, class 0 (can-protocol 2): what the host asks and sets, axis by axis.

A SET has no reply; a GET answers with its own code. Numbers are raw: ticks, PWM counts, torque
units (TorqueMax / 0x8000 Nm). Commands that DSP boards ignore have no row: to a board their codes
are unknown.
"""

from collections.abc import Iterable

from hal.wire.layout import Field, characters, i16, i32, pad, u8, u32
from hal.wire.management import FIRMWARE_FIELDS, HOST_PROTOCOL_FIELDS
from hal.wire.message import CODE_MASK, AxisCommand
from hal.wire.modes import CalibrationType, ControlMode, InteractionMode

HOST_PROTOCOL = (1, 6)
"""Protocol version that the host states in GET_FIRMWARE_VERSION."""

COMMANDS: dict[int, AxisCommand] = {}
"""Every row by its code."""


def _row(
    code: int,
    name: str,
    request: Iterable[Field] = (),
    reply: Iterable[Field] | None = None,
    *,
    lenient: bool = False,
) -> AxisCommand:
    command = AxisCommand(code, name, request, reply, lenient=lenient)
    COMMANDS[code] = command
    return command


def _pair(
    set_code: int, get_code: int, name: str, *fields: Field, lenient: bool = False
) -> tuple[AxisCommand, AxisCommand]:
    """A SET and the GET whose reply has the same layout."""
    return (
        _row(set_code, f"SET_{name}", fields, lenient=lenient),
        _row(get_code, f"GET_{name}", (), fields),
    )


def command_of(data: bytes) -> AxisCommand | None:
    """The row that byte 0 names, None for an empty payload or an unknown code."""
    return COMMANDS.get(data[0] & CODE_MASK) if data else None


def axis_of(data: bytes) -> int:
    """Axis that byte 0 of a non-empty payload selects."""
    return data[0] >> 7


_TORQUE_UNIT = "TorqueMax/0x8000"
_SPEED_UNIT = "tick/ms / 2^shift"  # 4DC boards leave the shift out
_PID = (i16("kp"), i16("ki"), i16("kd"), u8("shift"))
_PID_LIMITS = (
    i16("offset", "PWM"),
    i16("output_limit", "PWM"),
    i16("integral_limit", "PWM"),
    pad(1),
)
_IMPEDANCE = (i16("stiffness", f"{_TORQUE_UNIT}/tick"), i16("damping", f"{_TORQUE_UNIT}*ms/tick"))
_STICTION = (i16("up", "PWM"), i16("down", "PWM"))
_LABEL = (u8("index"), *characters(4))

NO_MESSAGE = _row(0, "NO_MESSAGE")
TOGGLE_VERBOSE = _row(3, "TOGGLE_VERBOSE")
CALIBRATE_ENCODER = _row(
    4,
    "CALIBRATE_ENCODER",
    (u8("type", choices=CalibrationType), i16("p1"), i16("p2"), i16("p3")),
    lenient=True,
)
GET_CONTROL_MODE = _row(7, "GET_CONTROL_MODE", (), (u8("mode", choices=ControlMode), pad(1)))
MOTION_DONE = _row(8, "MOTION_DONE", (), (i16("done"),))
SET_CONTROL_MODE = _row(9, "SET_CONTROL_MODE", (u8("mode", choices=ControlMode),))
WRITE_FLASH_MEM = _row(10, "WRITE_FLASH_MEM")
READ_FLASH_MEM = _row(11, "READ_FLASH_MEM")
GET_ADDITIONAL_INFO = _row(12, "GET_ADDITIONAL_INFO", (), _LABEL)  # eight replies, in any order
SET_ADDITIONAL_INFO = _row(13, "SET_ADDITIONAL_INFO", _LABEL)
SET_SPEED_ESTIM_SHIFT = _row(
    14,
    "SET_SPEED_ESTIM_SHIFT",
    (
        u8("joint_velocity"),
        u8("joint_acceleration"),
        u8("motor_velocity"),
        u8("motor_acceleration"),
    ),
    lenient=True,
)
SET_MAX_MOTOR_POS = _row(15, "SET_MAX_MOTOR_POS", (i32("position", "tick"),))
SET_MIN_MOTOR_POS = _row(16, "SET_MIN_MOTOR_POS", (i32("position", "tick"),))
SET_DEBUG_PARAM = _row(18, "SET_DEBUG_PARAM", (u8("index"), i16("value")), lenient=True)
GET_DEBUG_PARAM = _row(19, "GET_DEBUG_PARAM", (u8("index"),), (i16("value"),))
GET_ENCODER_POSITION = _row(
    20, "GET_ENCODER_POSITION", (), (i32("position", "tick"), i16("speed", _SPEED_UNIT))
)
SET_DESIRED_POSITION, GET_DESIRED_POSITION = _pair(
    21, 22, "DESIRED_POSITION", i32("position", "tick")
)
SET_DESIRED_VELOCITY, GET_DESIRED_VELOCITY = _pair(23, 24, "DESIRED_VELOCITY", i16("velocity"))
SET_DESIRED_ACCELER, GET_DESIRED_ACCELER = _pair(25, 26, "DESIRED_ACCELER", i16("acceleration"))
POSITION_MOVE = _row(27, "POSITION_MOVE", (i32("target", "tick"), i16("speed", "10 tick/s")))
VELOCITY_MOVE = _row(
    28,
    "VELOCITY_MOVE",
    (
        i16("velocity", "tick/ms / 2^velocity_shift"),
        i16("acceleration", "tick/ms^2 / 2^velocity_shift"),
    ),
)
SET_ENCODER_POSITION = _row(29, "SET_ENCODER_POSITION", (i32("position", "tick"),))  # 4DC only
SET_P_GAIN, GET_P_GAIN = _pair(30, 31, "P_GAIN", i16("kp"))
SET_D_GAIN, GET_D_GAIN = _pair(32, 33, "D_GAIN", i16("kd"))
SET_I_GAIN, GET_I_GAIN = _pair(34, 35, "I_GAIN", i16("ki"))
SET_ILIM_GAIN, GET_ILIM_GAIN = _pair(36, 37, "ILIM_GAIN", i16("integral_limit", "PWM"))
SET_OFFSET, GET_OFFSET = _pair(38, 39, "OFFSET", i16("offset", "PWM"))
SET_SCALE, GET_SCALE = _pair(40, 41, "SCALE", i16("shift"))
SET_TLIM, GET_TLIM = _pair(42, 43, "TLIM", i16("output_limit", "PWM"))
SET_DESIRED_TORQUE, GET_DESIRED_TORQUE = _pair(
    44, 45, "DESIRED_TORQUE", i32("torque", _TORQUE_UNIT)
)
STOP_TRAJECTORY = _row(46, "STOP_TRAJECTORY", lenient=True)
SET_PWM_LIMIT, GET_PWM_LIMIT = _pair(47, 48, "PWM_LIMIT", i16("limit", "PWM"))
SET_BOARD_ID = _row(50, "SET_BOARD_ID", (u8("address"),))
GET_BOARD_ID = _row(51, "GET_BOARD_ID", (), (u8("address"),))
SET_TORQUE_SOURCE = _row(52, "SET_TORQUE_SOURCE", (u8("address"), u8("channel"), pad(5)))
GET_PID_ERROR = _row(55, "GET_PID_ERROR", (), (i16("error", "tick"),))
GET_CALIBRATION_STATUS = _row(
    56,
    "GET_CALIBRATION_STATUS",
    (),
    (
        u8("calibrated"),
        u8("internal_mode", choices=ControlMode),
        u8("interaction", choices=InteractionMode),
    ),
)
GET_POSITION_MOVE_REF = _row(57, "GET_POSITION_MOVE_REF", (), (i32("position", "tick"),))
GET_VELOCITY_MOVE_REF = _row(58, "GET_VELOCITY_MOVE_REF", (), (i16("velocity"),))
GET_ERROR_STATUS = _row(60, "GET_ERROR_STATUS", (), (u8("error"), u8("undefined")))
GET_ENCODER_VELOCITY = _row(61, "GET_ENCODER_VELOCITY", (), (i16("speed", _SPEED_UNIT),))
SET_COMMAND_POSITION = _row(62, "SET_COMMAND_POSITION", (i32("position", "tick"),))
GET_PID_OUTPUT = _row(63, "GET_PID_OUTPUT", (), (i16("output", "PWM"),))
SET_MIN_POSITION, GET_MIN_POSITION = _pair(64, 65, "MIN_POSITION", i32("position", "tick"))
SET_MAX_POSITION, GET_MAX_POSITION = _pair(66, 67, "MAX_POSITION", i32("position", "tick"))
SET_MAX_VELOCITY, GET_MAX_VELOCITY = _pair(68, 69, "MAX_VELOCITY", i16("velocity"))
SET_CURRENT_LIMIT = _row(72, "SET_CURRENT_LIMIT", (u32("limit", "mA"),))
SET_BCAST_POLICY = _row(73, "SET_BCAST_POLICY", (u32("mask"),))
SET_VEL_SHIFT = _row(74, "SET_VEL_SHIFT", (i16("velocity_shift"),))
SET_OFFSET_ABS_ENCODER, GET_OFFSET_ABS_ENCODER = _pair(
    75, 76, "OFFSET_ABS_ENCODER", i32("offset", "tick")
)
SET_TORQUE_PID, GET_TORQUE_PID = _pair(78, 79, "TORQUE_PID", *_PID)
SET_TORQUE_PIDLIMITS, GET_TORQUE_PIDLIMITS = _pair(80, 81, "TORQUE_PIDLIMITS", *_PID_LIMITS)
SET_POS_PID, GET_POS_PID = _pair(82, 83, "POS_PID", *_PID)
SET_POS_PIDLIMITS, GET_POS_PIDLIMITS = _pair(84, 85, "POS_PIDLIMITS", *_PID_LIMITS)
SET_VEL_TIMEOUT = _row(86, "SET_VEL_TIMEOUT", (i16("timeout", "ms"),))
SET_IMPEDANCE_PARAMS = _row(87, "SET_IMPEDANCE_PARAMS", (*_IMPEDANCE, pad(3)))
GET_IMPEDANCE_PARAMS = _row(
    88,
    "GET_IMPEDANCE_PARAMS",
    (),
    (*_IMPEDANCE, i16("offset", _TORQUE_UNIT), pad(1)),
)
SET_IMPEDANCE_OFFSET, GET_IMPEDANCE_OFFSET = _pair(
    89, 90, "IMPEDANCE_OFFSET", i16("offset", _TORQUE_UNIT)
)
GET_FIRMWARE_VERSION = _row(
    91,
    "GET_FIRMWARE_VERSION",
    HOST_PROTOCOL_FIELDS,
    FIRMWARE_FIELDS,
)
SET_OPTICAL_ENC_RATIO = _row(92, "SET_OPTICAL_ENC_RATIO", (i16("ratio"),))
SET_POS_STICTION_PARAMS, GET_POS_STICTION_PARAMS = _pair(93, 94, "POS_STICTION_PARAMS", *_STICTION)
SET_TORQUE_STICTION_PARAMS, GET_TORQUE_STICTION_PARAMS = _pair(
    95, 96, "TORQUE_STICTION_PARAMS", *_STICTION
)
SET_MOTOR_PARAMS, GET_MOTOR_PARAMS = _pair(
    97, 98, "MOTOR_PARAMS", i16("bemf"), u8("bemf_shift"), i16("ktau"), u8("ktau_shift"), pad(1)
)
SET_MODEL_PARAMS, GET_MODEL_PARAMS = _pair(
    99, 100, "MODEL_PARAMS", i16("kff"), u8("kff_shift"), pad(4)
)
SET_OPENLOOP_PARAMS, GET_OPENLOOP_PARAMS = _pair(114, 115, "OPENLOOP_PARAMS", i16("duty", "PWM"))
SET_INTERACTION_MODE = _row(
    116, "SET_INTERACTION_MODE", (u8("interaction", choices=InteractionMode),), lenient=True
)
GET_INTERACTION_MODE = _row(
    117, "GET_INTERACTION_MODE", (), (u8("interaction", choices=InteractionMode), pad(1))
)
SET_TCFILTER_TYPE, GET_TCFILTER_TYPE = _pair(118, 120, "TCFILTER_TYPE", u8("filter"))

LONGER_FORMS = (
    AxisCommand(
        SET_DEBUG_PARAM.code,
        SET_DEBUG_PARAM.name,
        (u8("index"), i16("value"), i16("value1"), i16("value2")),
    ),
)
"""Second forms of a code: of debug parameter 20, the head's micro-saccades, there are three."""
