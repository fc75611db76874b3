"""Back inside: an axis whose board took a place beyond the limits as its reference.

Boards do that at every switch of mode and of interaction, with an axis in motion too.
"""

from hal.axis import Axis
from hal.limiting import way_back
from hal.units import move_speed_counts
from hal.wire import motor
from hal.wire.modes import ControlMode

RETURN_S = 0.5


def bring_back(axis: Axis) -> int | None:
    """Move an axis in position mode back; for one in direct mode, the reference that does.

    Where calibration or somebody's hand has put an axis it stays until it is asked for.
    """
    target = way_back(axis.units, axis.ticks, axis.motion[1])
    if target is None or axis.calibrating or not axis.is_calibrated:
        return None
    if axis.mode == ControlMode.POSITION:
        speed = move_speed_counts(target - axis.ticks, RETURN_S)
        axis.send(motor.POSITION_MOVE, target, min(speed, axis.units.max_move_speed_counts))
    return target if axis.mode == ControlMode.DIRECT else None
