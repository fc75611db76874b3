"""The wires between one axis of a motor board and its drive, as plain integers."""


class AxisPort:
    """What the board sees of a drive (inputs, set before each tick) and does to it (outputs)."""

    __slots__ = (
        "current_ma",
        "enabled",
        "encoder_fault",
        "external_fault",
        "hall_fault",
        "overheated",
        "pwm",
        "raw_encoder",
    )

    def __init__(self) -> None:
        self.raw_encoder = 0  # ticks; absolute: 0..4095, incremental: running count
        self.current_ma = 0
        self.external_fault = False  # emergency button pressed: the hardware opens the bridge
        self.encoder_fault = False  # the absolute encoder cannot be read
        self.hall_fault = 0  # Hall error code, bits 0..2
        self.overheated = False  # above 75 degrees
        self.pwm = 0  # signed counts really applied to the motor
        self.enabled = False  # bridge on; off means the motor terminals are open
