"""4DC: four brushed axes behind two consecutive addresses (head, forearm, hand)."""

from firmware_sim.boards import couplings
from firmware_sim.boards.brushless import unknown_firmware
from firmware_sim.boards.hardware import AxisWiring, Coupling, Encoder, Firmware, Hardware, strict
from firmware_sim.boards.motor_board import MotorBoard
from firmware_sim.description import BoardSpec
from hal.wire.management import BoardType
from hal.wire.modes import CalibrationType

HARDWARE = Hardware(
    board_type=int(BoardType.DC4),
    axes=4,
    slots=5,
    max_duty=1333,
    duty_step=2 * 1333,  # not on this board: the D term's one-sample pulse reaches the motor
    reports_duty=False,
    derivative_samples=1,
    speed_window_ms=1,
    scales_speed=False,  # as the real board: the host divides by 2^shift nevertheless
    i2t_shift=0,
    i2t_trip=1_800_000_000,
    trip_ma=None,
    max_current_limit_ma=1600,
    needs_calibration=False,
    pulses_stiction=True,
    presets_encoder=True,
)

_ABSOLUTE = AxisWiring()
_HARD_STOP = AxisWiring(
    encoder=Encoder.INCREMENTAL, calibrations=frozenset({CalibrationType.HARD_STOP})
)
_DIFFERENTIAL = frozenset({CalibrationType.HARD_STOP_DIFFERENTIAL})
_PROSUP = AxisWiring(
    encoder=Encoder.INCREMENTAL,
    calibrations=frozenset({CalibrationType.HARD_STOP}),
    torque_source=(12, 4),
)
# An analog sensor of its own and nothing to move to: whatever the type, it holds where it is.
_ANALOG = AxisWiring(
    calibrations=frozenset({CalibrationType.DIGITAL_ABSOLUTE, CalibrationType.HALL}),
    holds_here=True,
)


def _tendon(*hall: int, opposite_limit: int) -> AxisWiring:
    """An axis of the hand: its position is what the MAIS reads (can-protocol 5.4)."""
    return AxisWiring(
        encoder=Encoder.INCREMENTAL,
        calibrations=frozenset({CalibrationType.ABSOLUTE_INCREMENTAL, CalibrationType.MAIS}),
        hall=hall,
        opposite_limit=opposite_limit,
    )


_FOREARM_V1 = (
    _PROSUP,
    AxisWiring(encoder=Encoder.INCREMENTAL, calibrations=_DIFFERENTIAL, torque_source=(11, 0)),
    AxisWiring(encoder=Encoder.INCREMENTAL, calibrations=_DIFFERENTIAL, torque_source=(11, 1)),
    _ANALOG,
)
_FOREARM_V2 = (
    _PROSUP,
    AxisWiring(torque_source=(11, 0)),
    AxisWiring(torque_source=(11, 1)),
    _ANALOG,
)
# Values 0..6 come in the frame 0x3EC, 7..14 in 0x3ED.
_THUMB_AND_INDEX = (
    _ANALOG,  # thumb opposition
    _tendon(0, opposite_limit=-1800),  # thumb proximal
    _tendon(1, 2, opposite_limit=-3000),  # thumb distal
    _tendon(3, opposite_limit=-300),  # index proximal
)
_FINGERS = (
    _tendon(4, 5, opposite_limit=-3000),  # index distal
    _tendon(6, opposite_limit=-300),  # middle proximal
    _tendon(7, 8, opposite_limit=-3000),  # middle distal
    _tendon(12, 13, 14, opposite_limit=0),  # ring and little
)
_NONE = couplings.identity(4)

_FIRMWARE: dict[tuple[int, int], tuple[tuple[AxisWiring, ...], Coupling]] = {
    (0x01, 0x11): ((_HARD_STOP,) * 4, _NONE),
    (0x01, 0x15): ((_HARD_STOP,) * 4, couplings.EYES_V1),
    (0x02, 0x15): ((_ABSOLUTE, _ABSOLUTE, _HARD_STOP, _HARD_STOP), couplings.EYES_V2),
    (0x01, 0x19): (_FOREARM_V1, couplings.WRIST_V1),
    (0x02, 0x19): (_FOREARM_V2, couplings.WRIST_V2),
    (0x01, 0x28): (_THUMB_AND_INDEX, _NONE),
    (0x02, 0x28): (_THUMB_AND_INDEX, couplings.THUMB_RIGHT),
    (0x01, 0x30): (_FINGERS, _NONE),
    (0x02, 0x30): (_FINGERS, _NONE),
}
_FOREARM = 0x19
_HALL_TYPES = frozenset({0xC, 0xD})  # Hall values of the hand's MAIS
VERSIONS = tuple(_FIRMWARE)


class Dc4(MotorBoard):
    """One 4DC with a head, forearm or hand firmware."""

    def __init__(self, spec: BoardSpec) -> None:
        hardware = HARDWARE if spec.faithful else strict(HARDWARE)
        super().__init__(spec.address, hardware, _firmware(spec))


def _firmware(spec: BoardSpec) -> Firmware:
    known = _FIRMWARE.get(spec.firmware)
    if known is None:
        raise unknown_firmware(spec, "4DC", VERSIONS)
    axes, coupling = known
    has_thumb = coupling is couplings.THUMB_RIGHT and spec.coupled
    return Firmware(
        version=spec.firmware,
        axes=axes,
        coupling=coupling if spec.coupled else _NONE,
        thumb=(couplings.THUMB_LEFT, couplings.THUMB_RIGHT) if has_thumb else None,
        tolerated_types=_HALL_TYPES,
        complains=spec.firmware[1] == _FOREARM,
        faithful=spec.faithful,
    )
