"""Host side of the BLL_IE board: two brushless axes behind one address."""

from hal.boards.bll import Bll


class BllIe(Bll):
    """A 2BLL but for the scale of its PWM."""

    full_pwm = 800
