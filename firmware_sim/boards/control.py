"""Laws of modes that are not compiled: rare ones, each a function of an axis (can-protocol 10.5).

All others run in kernel.py.
"""

from collections.abc import Callable

from firmware_sim.boards.axis_state import Axis
from firmware_sim.boards.calibration import creep_to_hard_stop
from firmware_sim.boards.modes import CALIB_HARD_STOP

Law = Callable[[Axis], int]
"""PWM before coupling for this millisecond. May put the axis into another mode or HW_FAULT."""


def undefined(axis: Axis) -> int:
    """A mode that the board does not have faults one millisecond after it was entered."""
    if axis.undefined_mode:
        axis.fault()
    axis.undefined_mode = True
    return 0


LAWS: dict[int, Law] = {
    CALIB_HARD_STOP: creep_to_hard_stop,
}
