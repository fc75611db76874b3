"""Host side of the 4DC board: four brushed axes behind its own address and the next."""

from hal.boards.motor import MotorBoard
from hal.wire.management import BoardType


class Dc4(MotorBoard):
    """Position each 5 ms; speeds are differences of one ms, unshifted (can-protocol 9.2)."""

    type_code = BoardType.DC4
    addresses = 2
    full_pwm = 1333
    max_current_ma = 1600

    @classmethod
    def velocity_count(cls, speed_estimate_shift: int) -> float:  # noqa: ARG003  (not shifted)
        """One count in ticks/ms: 88 deg/s on a wrist axis, so POSITION frames serve instead."""
        return 1.0
