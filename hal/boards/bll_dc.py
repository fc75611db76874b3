"""Host side of the 2BLLDC board: two DC axes behind one address."""

from hal.boards.bll import Bll


class BllDc(Bll):
    """Position each 5 ms; otherwise a 2BLL with another scale of PWM."""

    full_pwm = 800
