"""2BLLDC: two brushed axes on the brushless boards' code (neck of head v2)."""

from dataclasses import replace

from firmware_sim.boards import bll_ie
from firmware_sim.boards.brushless import NECK_VERSIONS, brushless_firmware
from firmware_sim.boards.hardware import strict
from firmware_sim.boards.motor_board import MotorBoard
from firmware_sim.description import BoardSpec

# The sheet gives slots and duty; ramp, trip and current limit are assumed to be the family's.
HARDWARE = replace(bll_ie.HARDWARE, slots=5, max_duty=756, damps_speed=True)  # of 800


class BllDc(MotorBoard):
    """One 2BLLDC with a neck firmware."""

    def __init__(self, spec: BoardSpec) -> None:
        firmware = brushless_firmware(spec, "2BLLDC", NECK_VERSIONS)
        hardware = HARDWARE if spec.faithful else strict(HARDWARE)
        super().__init__(spec.address, hardware, firmware)
