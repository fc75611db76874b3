"""BLL_IE: two brushless axes behind one address (shoulder, elbow, torso, legs)."""

from firmware_sim.boards.brushless import BODY_VERSIONS, brushless_firmware
from firmware_sim.boards.hardware import Hardware, strict
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


class BllIe(MotorBoard):
    """One BLL_IE with a firmware of the x.50 family."""

    def __init__(self, spec: BoardSpec) -> None:
        firmware = brushless_firmware(spec, "BLL_IE", BODY_VERSIONS)
        hardware = HARDWARE if spec.faithful else strict(HARDWARE)
        super().__init__(spec.address, hardware, firmware)
