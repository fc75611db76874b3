"""What distinguishes one type of motor board from another, and one firmware from another."""

from dataclasses import dataclass, replace
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
    damps_speed: bool = False  # the position loop's D term acts on the speed, not on the error
    drops_integral: bool = True  # to its limit, unshifted, when it reaches it


def strict(hardware: Hardware) -> Hardware:
    """The same without the quirks that the sheet calls switches of fidelity (can-protocol 15)."""
    return replace(hardware, drops_integral=False, scales_speed=True)


@dataclass(frozen=True, kw_only=True, slots=True)
class AxisWiring:
    """What a firmware number says about one axis."""

    encoder: Encoder = Encoder.ABSOLUTE
    calibrations: frozenset[CalibrationType] = frozenset({CalibrationType.DIGITAL_ABSOLUTE})
    holds_here: bool = False  # calibration type 3 stays where it is instead of moving to p1
    torque_source: tuple[int, int] | None = None  # virtual sensor address and channel
    hall: tuple[int, ...] = ()  # MAIS values whose sum is the position; () = the encoder is
    opposite_limit: int = 0  # of the motor's counts behind calibration 4, for a positive p3


Row = tuple[float, ...]


@dataclass(frozen=True, slots=True)
class Coupling:
    """Motors and encoders of a board that act on several joints (can-protocol 9.4).

    Indices are axes of the board; every sum is cut towards zero.
    """

    motors: tuple[Row, ...]  # PWM of motor i = sum over j of motors[i][j] * PWM wanted by axis j
    encoders: tuple[
        Row, ...
    ]  # ticks of joint i = sum over j of encoders[i][j] * ticks of encoder j
    partner_motors: tuple[tuple[float, float], ...]  # added: times the partner board's two duties
    partner_positions: tuple[tuple[float, float], ...]  # added: times its two joint positions
    groups: tuple[tuple[int, ...], ...]  # axes enabled, disabled and calibrated together


@dataclass(frozen=True, slots=True)
class PartnerSpec:
    """The other board of a shoulder, to whose broadcasts a firmware listens."""

    address: int
    needs_position: bool  # its POSITION frames are watched as its PID_VAL frames are
    axes: tuple[int, ...]  # own axes that may not move while it is silent


@dataclass(frozen=True, kw_only=True, slots=True)
class Firmware:
    """One firmware number on one board."""

    version: tuple[int, int]  # as reported: 2.57 is (0x02, 0x57)
    axes: tuple[AxisWiring, ...]
    coupling: Coupling
    partner: PartnerSpec | None = None
    thumb: tuple[Coupling, Coupling] | None = None  # for negative and positive kp of axis 0
    tolerated_types: frozenset[int] = frozenset()  # of class 3, beside force and torque
    complains: bool = True  # of other types of class 3, in a print
    position_needs_encoders: bool = False  # no POSITION frame while an absolute encoder fails
    faithful: bool = True  # False: where the sheet offers a strict reading, that one
