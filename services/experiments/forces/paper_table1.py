"""Table 1 of the force control paper: errors in predicting FT measurements, mean and spread.

In the scanned table each label follows its rows. N and Nm, in the axes of the robot's sensors;
another robot than the one of the recording and the one of the model.
"""

from typing import NamedTuple

Six = tuple[float, float, float, float, float, float]


class Errors(NamedTuple):
    """Mean and standard deviation per component: force, moment."""

    mean: Six
    std: Six


PAPER: dict[str, Errors] = {
    "right_arm": Errors(
        (-0.3157, -0.5209, 0.7723, -0.0252, 0.0582, 0.0197),
        (0.5845, 0.7156, 0.7550, 0.0882, 0.0688, 0.0364),
    ),
    "left_arm": Errors(
        (-0.0908, -0.4811, 0.8699, 0.0436, 0.0382, 0.0030),
        (0.5742, 0.6677, 0.7920, 0.1048, 0.0702, 0.0332),
    ),
    "right_leg": Errors(
        (-1.6678, 3.4476, -1.5505, 0.4050, -0.7340, 0.0171),
        (3.3146, 2.7039, 1.7996, 0.3423, 0.7141, 0.0771),
    ),
    "left_leg": Errors(
        (0.2941, -5.1476, -1.9459, -0.3084, -0.8399, 0.0270),
        (1.8031, 1.8327, 2.3490, 0.3365, 0.8348, 0.0498),
    ),
}
