"""Periodic motor messages, class 1 (can-protocol 3): what a motor board broadcasts by itself.

STATUS bits are the state of one cycle, not latched. A frame speaks of the two axes that its source
address owns.
"""

from enum import IntFlag

from hal.wire.can import CLASS_MOTOR_PERIODIC
from hal.wire.layout import Field, Layout, NibblePair, OpenLayout, characters, i16, i32, pad, u4, u8
from hal.wire.message import PeriodicMessage
from hal.wire.modes import ControlMode, InteractionMode


class AxisFault(IntFlag):
    """Fault byte of one axis in STATUS. HALL_B and HALL_C alone also stand for Hall errors."""

    UNDERVOLTAGE = 0x01
    OVERVOLTAGE = 0x02
    EXTERNAL = 0x04  # emergency button
    OVERCURRENT = 0x08  # over-current or I2T trip
    HALL_A = 0x10
    ENCODER = 0x20  # absolute encoder (SSI) read error
    HALL_B = 0x40  # shared with optical encoder drift
    HALL_C = 0x80


class CanStatus(IntFlag):
    """Byte 4 of STATUS; reporting clears it on the board."""

    TX_OVERRUN = 0x01  # software buffer
    BUS_OFF = 0x02
    TX_ERROR_PASSIVE = 0x04
    RX_ERROR_PASSIVE = 0x08
    TX_WARNING = 0x10
    RX_WARNING = 0x20
    RX_OVERRUN = 0x40  # hardware


class BoardStatus(IntFlag):
    """Byte 5 of STATUS."""

    LOOP_OVERRUN = 0x01  # the control loop lasted more than 1 ms
    OVERTEMPERATURE_0 = 0x02
    OVERTEMPERATURE_1 = 0x04
    TEMPERATURE_UNREADABLE_0 = 0x08
    TEMPERATURE_UNREADABLE_1 = 0x10


_FAULT_TEXT = {
    AxisFault.UNDERVOLTAGE: "undervoltage",
    AxisFault.OVERVOLTAGE: "overvoltage or driver overload",
    AxisFault.EXTERNAL: "emergency button pressed",
    AxisFault.OVERCURRENT: "over-current or I2T trip",
    AxisFault.HALL_A: "Hall sensor error",
    AxisFault.ENCODER: "absolute encoder read error",
    AxisFault.HALL_B: "Hall sensor error or optical encoder drift",
    AxisFault.HALL_C: "Hall sensor error",
}
_CAN_TEXT = {
    CanStatus.TX_OVERRUN: "CAN transmit buffer overrun",
    CanStatus.BUS_OFF: "CAN bus-off",
    CanStatus.TX_ERROR_PASSIVE: "CAN transmit error-passive",
    CanStatus.RX_ERROR_PASSIVE: "CAN receive error-passive",
    CanStatus.TX_WARNING: "CAN transmit warning",
    CanStatus.RX_WARNING: "CAN receive warning",
    CanStatus.RX_OVERRUN: "CAN receive overrun",
}
_BOARD_TEXT = {
    BoardStatus.LOOP_OVERRUN: "control loop longer than 1 ms",
    BoardStatus.OVERTEMPERATURE_0: "over-temperature axis 0",
    BoardStatus.OVERTEMPERATURE_1: "over-temperature axis 1",
    BoardStatus.TEMPERATURE_UNREADABLE_0: "temperature sensor 0 not readable",
    BoardStatus.TEMPERATURE_UNREADABLE_1: "temperature sensor 1 not readable",
}


def axis_fault_text(bits: int) -> str:
    """Reasons in an axis fault byte, comma-separated, empty when there is none."""
    return ", ".join(dict.fromkeys(text for bit, text in _FAULT_TEXT.items() if bits & bit))


def can_status_text(bits: int) -> str:
    """Reasons in a CAN status byte, comma-separated, empty when there is none."""
    return ", ".join(text for bit, text in _CAN_TEXT.items() if bits & bit)


def board_status_text(bits: int) -> str:
    """Reasons in a board status byte, comma-separated, empty when there is none."""
    return ", ".join(text for bit, text in _BOARD_TEXT.items() if bits & bit)


MESSAGES: dict[int, PeriodicMessage] = {}
"""Every row by its type."""


def _row(kind: int, name: str, *fields: Field, mask_bit: int = 0) -> PeriodicMessage:
    message = PeriodicMessage(CLASS_MOTOR_PERIODIC, kind, name, Layout(fields), mask_bit=mask_bit)
    MESSAGES[kind] = message
    return message


_STATUS = (
    u8("fault0", choices=AxisFault),
    u8("mode0", choices=ControlMode),
    u8("fault1", choices=AxisFault),
    u8("mode1", choices=ControlMode),
    u8("can_status", choices=CanStatus),
    u8("board_status", choices=BoardStatus),
    u8("tx_errors"),  # the last two only in the copy sent every 5 s
    u8("rx_errors"),
)

FOC = _row(  # 2FOC boards only
    0, "FOC", i16("current", "mA"), i16("velocity", "icubdeg/ms"), i32("position", "icubdeg")
)
POSITION = _row(1, "POSITION", i32("position0", "tick"), i32("position1", "tick"), mask_bit=0x001)
PID_VAL = _row(
    2,
    "PID_VAL",
    i16("pid0", "PWM"),
    i16("pid1", "PWM"),
    i16("duty0", "PWM"),
    i16("duty1", "PWM"),
    mask_bit=0x002,
)
STATUS = _row(3, "STATUS", *_STATUS, mask_bit=0x004)
CURRENT = _row(4, "CURRENT", i16("current0", "mA"), i16("current1", "mA"), pad(4), mask_bit=0x008)
OVERFLOW = _row(5, "OVERFLOW", mask_bit=0x010)
PRINT = MESSAGES[6] = PeriodicMessage(
    CLASS_MOTOR_PERIODIC,
    6,
    "PRINT",
    OpenLayout((u8("head"), u8("tag"), *characters(6)), least=2),
    mask_bit=0x020,
)
VELOCITY = _row(
    7,
    "VELOCITY",
    i16("velocity0", "tick/ms / 2^shift"),
    i16("velocity1", "tick/ms / 2^shift"),
    i16("acceleration0"),
    i16("acceleration1"),
    mask_bit=0x040,
)
PID_ERROR = _row(
    8,
    "PID_ERROR",
    i16("position_error0", "tick"),
    i16("position_error1", "tick"),
    i16("torque_error0", "TorqueMax/0x8000"),
    i16("torque_error1", "TorqueMax/0x8000"),
    mask_bit=0x080,
)
DEBUG = _row(9, "DEBUG", i16("value0"), i16("value1"), i16("value2"), i16("value3"), mask_bit=0x100)
MOTOR_POSITION = _row(
    10, "MOTOR_POSITION", i32("position0", "count"), i32("position1", "count"), mask_bit=0x200
)
MOTOR_SPEED = _row(11, "MOTOR_SPEED", i16("speed0"), i16("speed1"), pad(4), mask_bit=0x400)
ADDITIONAL_STATUS = MESSAGES[12] = PeriodicMessage(
    CLASS_MOTOR_PERIODIC,
    12,
    "ADDITIONAL_STATUS",
    NibblePair(
        u4("interaction0", choices=InteractionMode), u4("interaction1", choices=InteractionMode)
    ),
)
EMSTO2FOC_DESIRED_CURRENT = _row(
    15,
    "EMSTO2FOC_DESIRED_CURRENT",
    i16("current1", "mA"),
    i16("current2", "mA"),
    i16("current3", "mA"),
    i16("current4", "mA"),
)
