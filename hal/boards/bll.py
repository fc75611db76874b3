"""Host side of the 2BLL board: two brushless axes behind one address."""

from hal.boards.motor import MotorBoard
from hal.wire.management import BoardType


class Bll(MotorBoard):
    """Position each 4 ms; speeds in ticks/ms * 2^shift."""

    type_code = BoardType.BLL
    addresses = 1
    full_pwm = 1333
    max_current_ma = 7000

    @classmethod
    def velocity_count(cls, speed_estimate_shift: int) -> float:
        """One count in ticks/ms."""
        return 1.0 / (1 << speed_estimate_shift)
