"""What distinguishes one type of motor board from another, and one firmware from another."""

from dataclasses import dataclass
from enum import Enum

from hal.wire.modes import CalibrationType


class Encoder(Enum):
    """How an axis measures its position."""

    ABSOLUTE = "absolute"  # 12 bits, one turn: position = (raw - offset) mod 4096
    INCREMENTAL = "incremental"  # counted from power-up: position = raw - offset


@dataclass(frozen=True, kw_only=True, slots=True)
class Hardware:
    """Constants of a board type (can-protocol 3.2 and 9.3)."""

    board_type: int  # code in handshake and discovery
    axes: int
    slots: int  # the broadcast schedule repeats after this many milliseconds
    max_duty: int  # PWM counts
    duty_step: int  # the bridge follows the command by at most this many counts per millisecond
    reports_duty: bool  # PID_VAL carries the applied duty
    derivative_samples: int
    speed_window_ms: int
    scales_speed: bool  # speed estimates are multiplied by 2^estimator shift
    i2t_shift: int
    i2t_trip: int
    trip_ma: int | None  # hard over-current trip
    max_current_limit_ma: int
    needs_calibration: bool  # command 9 is refused before calibration
    pulses_stiction: bool  # the position loop has a stiction term
    presets_encoder: bool  # knows SET_ENCODER_POSITION


@dataclass(frozen=True, kw_only=True, slots=True)
class AxisWiring:
    """What a firmware number says about one axis."""

    encoder: Encoder = Encoder.ABSOLUTE
    calibrations: frozenset[CalibrationType] = frozenset({CalibrationType.DIGITAL_ABSOLUTE})
    holds_here: bool = False  # calibration type 3 stays where it is instead of moving to p1
    torque_source: tuple[int, int] | None = None  # virtual sensor address and channel


@dataclass(frozen=True, kw_only=True, slots=True)
class Firmware:
    """One firmware number on one board."""

    version: tuple[int, int]  # as reported: 2.57 is (0x02, 0x57)
    axes: tuple[AxisWiring, ...]
    tolerated_types: frozenset[int] = frozenset()  # of class 3, beside force and torque
    position_needs_encoders: bool = False  # no POSITION frame while an absolute encoder fails
