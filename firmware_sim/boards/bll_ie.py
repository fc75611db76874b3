"""BLL_IE: two brushless axes behind one address (shoulder, elbow, torso, legs)."""

from firmware_sim.boards.board import BoardError
from firmware_sim.boards.hardware import AxisWiring, Firmware, Hardware
from firmware_sim.boards.motor_board import MotorBoard
from firmware_sim.description import BoardSpec
from hal.wire.management import BoardType

HARDWARE = Hardware(
    board_type=int(BoardType.BLL),
    axes=2,
    slots=4,
    max_duty=760,  # of 800
    duty_step=10,  # the sheet gives the step, not its period: one per millisecond here
    reports_duty=True,
    derivative_samples=10,
    speed_window_ms=29,
    scales_speed=True,
    i2t_shift=4,
    i2t_trip=2_000_000_000,
    trip_ma=25_000,
    max_current_limit_ma=7000,
    needs_calibration=True,
    pulses_stiction=False,
    presets_encoder=False,
)

# Virtual sensor and channel of both axes (can-protocol 6). x.51 chooses by the board's address.
_SOURCES = {
    0x50: ((12, 0), (12, 1)),
    0x52: ((12, 1), (12, 2)),
    0x54: ((12, 0), None),
    0x57: ((12, 2), (12, 3)),
}
_LEG = 0x51
_LEG_SOURCES = {
    5: ((12, 2), (12, 3)),
    6: ((12, 0), (12, 1)),
    7: ((12, 4), (12, 5)),
    8: ((11, 2), (11, 3)),
    9: ((11, 0), (11, 1)),
    10: ((11, 4), (11, 5)),
}
_NEEDS_ENCODERS = frozenset({0x51, 0x54})


class BllIe(MotorBoard):
    """One BLL_IE with a firmware of the x.50 family."""

    def __init__(self, spec: BoardSpec) -> None:
        super().__init__(spec.address, HARDWARE, _firmware(spec))


def _firmware(spec: BoardSpec) -> Firmware:
    minor = spec.firmware[1]
    sources = _LEG_SOURCES.get(spec.address) if minor == _LEG else _SOURCES.get(minor)
    if sources is None:
        known = ", ".join(f"x.{number:02X}" for number in sorted(_SOURCES))
        raise BoardError(
            f"BLL_IE firmware {spec.firmware[0]:X}.{minor:02X} at address {spec.address} is not "
            f"emulated; known: {known} anywhere, x.51 at addresses 5 to 10"
        )
    return Firmware(
        version=spec.firmware,
        axes=tuple(AxisWiring(torque_source=source) for source in sources),
        position_needs_encoders=minor in _NEEDS_ENCODERS,
    )
