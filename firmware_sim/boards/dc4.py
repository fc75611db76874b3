"""4DC: four brushed axes behind two consecutive addresses (forearm, wrist)."""

from firmware_sim.boards.board import BoardError
from firmware_sim.boards.hardware import AxisWiring, Encoder, Firmware, Hardware
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

# Pronosupination, wrist pitch and yaw with absolute encoders, finger ab/adduction.
_WRIST_V2 = (
    AxisWiring(
        encoder=Encoder.INCREMENTAL,
        calibrations=frozenset({CalibrationType.HARD_STOP}),
        torque_source=(12, 4),
    ),
    AxisWiring(torque_source=(11, 0)),
    AxisWiring(torque_source=(11, 1)),
    AxisWiring(holds_here=True),
)
_HALL_TYPES = frozenset({0xC, 0xD})  # Hall values of the hand's MAIS
_FIRMWARE = {(0x02, 0x19): _WRIST_V2}


class Dc4(MotorBoard):
    """One 4DC with the forearm firmware."""

    def __init__(self, spec: BoardSpec) -> None:
        super().__init__(spec.address, HARDWARE, _firmware(spec))


def _firmware(spec: BoardSpec) -> Firmware:
    axes = _FIRMWARE.get(spec.firmware)
    if axes is None:
        known = ", ".join(f"{major:X}.{minor:02X}" for major, minor in _FIRMWARE)
        raise BoardError(
            f"4DC firmware {spec.firmware[0]:X}.{spec.firmware[1]:02X} is not emulated; "
            f"known: {known}"
        )
    return Firmware(version=spec.firmware, axes=axes, tolerated_types=_HALL_TYPES)
