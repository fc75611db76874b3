"""The wires between one axis of a motor board and its drive, as plain integers."""

from firmware_sim.boards.fields import (
    CURRENT_MA,
    ENCODER_FAULT,
    EXTERNAL_FAULT,
    HALL_FAULT,
    OVERHEATED,
    PORT_ENABLED,
    PORT_PWM,
    RAW_ENCODER,
)
from firmware_sim.boards.view import Flag, View, Word


class AxisPort(View):
    """What the board sees of a drive (inputs, set before each tick) and does to it (outputs)."""

    __slots__ = ()

    raw_encoder = Word(RAW_ENCODER)  # ticks; absolute: 0..4095, incremental: running count
    current_ma = Word(CURRENT_MA)
    external_fault = Flag(EXTERNAL_FAULT)  # emergency button pressed: the hardware opens the bridge
    encoder_fault = Flag(ENCODER_FAULT)  # the absolute encoder cannot be read
    hall_fault = Word(HALL_FAULT)  # Hall error code, bits 0..2
    overheated = Flag(OVERHEATED)  # above 75 degrees
    pwm = Word(PORT_PWM)  # signed counts really applied to the motor
    enabled = Flag(PORT_ENABLED)  # bridge on; off means the motor terminals are open
