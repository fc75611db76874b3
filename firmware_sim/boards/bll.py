"""2BLL: two brushless axes behind one address, the first generation (iCub 1.x)."""

from dataclasses import replace

from firmware_sim.boards import bll_ie
from firmware_sim.boards.brushless import BODY_VERSIONS, brushless_firmware
from firmware_sim.boards.hardware import strict
from firmware_sim.boards.motor_board import MotorBoard
from firmware_sim.description import BoardSpec

HARDWARE = replace(bll_ie.HARDWARE, max_duty=1250)  # of 1333


class Bll(MotorBoard):
    """One 2BLL with a firmware of the x.50 family."""

    def __init__(self, spec: BoardSpec) -> None:
        firmware = brushless_firmware(spec, "2BLL", BODY_VERSIONS)
        hardware = HARDWARE if spec.faithful else strict(HARDWARE)
        super().__init__(spec.address, hardware, firmware)
