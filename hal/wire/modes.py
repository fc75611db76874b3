"""Control modes, interaction modes and calibration types (can-protocol 10.1 and 10.5)."""

from enum import IntEnum


class ControlMode(IntEnum):
    """Codes of SET_CONTROL_MODE, GET_CONTROL_MODE and the STATUS frame."""

    IDLE = 0x00
    POSITION = 0x01
    VELOCITY = 0x02
    TORQUE = 0x03
    IMPEDANCE_POSITION = 0x04  # deprecated: sets the interaction to compliant
    IMPEDANCE_VELOCITY = 0x05  # deprecated: sets the interaction to compliant
    CURRENT = 0x06  # not on DSP boards
    MIXED = 0x07
    DIRECT = 0x08
    FORCE_IDLE = 0x09  # command only: the one way out of HW_FAULT
    SPEED_BY_VOLTAGE = 0x0A
    SPEED_BY_CURRENT = 0x0B
    CALIB_ABSOLUTE = 0x10  # the four CALIB_ codes are internal, seen by GET_CALIBRATION_STATUS only
    CALIB_HARD_STOP = 0x20
    CALIB_MARGIN_REACHED = 0x40
    CALIB_ABSOLUTE_INCREMENTAL = 0x41
    OPENLOOP = 0x50
    CALIBRATION = 0x60  # read only
    HW_FAULT = 0xA0
    NOT_CONFIGURED = 0xB0
    CONFIGURED = 0xB1
    NO_REQUEST = 0xB2
    UNKNOWN_ERROR = 0xFF


class InteractionMode(IntEnum):
    """Codes of SET_INTERACTION_MODE and the ADDITIONAL_STATUS frame."""

    STIFF = 0
    COMPLIANT = 1
    UNKNOWN = 0xFF


class CalibrationType(IntEnum):
    """First argument of CALIBRATE_ENCODER; the meaning of p1..p3 depends on it."""

    HARD_STOP = 0
    ANALOG_ABSOLUTE = 1
    HARD_STOP_DIFFERENTIAL = 2
    DIGITAL_ABSOLUTE = 3
    ABSOLUTE_INCREMENTAL = 4
    MAIS = 6
    HALL = 7


CALIBRATING = frozenset(
    {
        ControlMode.CALIB_ABSOLUTE,
        ControlMode.CALIB_HARD_STOP,
        ControlMode.CALIB_MARGIN_REACHED,
        ControlMode.CALIB_ABSOLUTE_INCREMENTAL,
    }
)
"""Internal modes that STATUS and GET_CONTROL_MODE report as CALIBRATION."""


def reported_mode(internal: int) -> int:
    """Code that STATUS and GET_CONTROL_MODE show for an internal mode."""
    return ControlMode.CALIBRATION if internal in CALIBRATING else internal
