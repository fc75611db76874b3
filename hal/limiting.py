"""How much of a set-point may be sent: pure arithmetic on limits, room and rates.

A board's loop trails a moving reference and runs past where it stops. So whatever moves towards a
limit slows down with the room that is left.
"""

import math

from hal.units import AxisUnits

CYCLE_S = 0.01  # one set-point per axis
BRAKING_S = 0.6  # the slowest of the boards' position loops settle in this
CREEP_TICKS = 0.2  # so that the limit itself is reached
COASTING_S = 0.25  # how long an axis without power may run on


def limited_step(value: float, reached: float, largest: float) -> float:
    """`value`, or as near to it as one step of at most `largest` from `reached` gets."""
    step = value - reached
    return value if abs(step) <= largest else reached + math.copysign(largest, step)


def position_step(units: AxisUnits, reached_ticks: float, step: float, largest: float) -> float:
    """Largest change of one cycle in the direction of `step`, ticks."""
    room = units.high_ticks - reached_ticks if step > 0 else reached_ticks - units.low_ticks
    braked = max(room, 0.0) * CYCLE_S / BRAKING_S + CREEP_TICKS
    return min(largest, braked)


def limited_velocity(units: AxisUnits, q_rad: float, dq_rad_s: float, look_ahead_s: float) -> float:
    """A velocity that ends inside the limits even if it is kept for `look_ahead_s`."""
    room_up = max(units.max_rad - q_rad, 0.0) / look_ahead_s
    room_down = max(q_rad - units.min_rad, 0.0) / look_ahead_s
    highest = min(room_up, units.max_velocity_rad_s)
    lowest = -min(room_down, units.max_velocity_rad_s)
    return min(max(dq_rad_s, lowest), highest)


def is_near_limit(units: AxisUnits, q_rad: float, dq_rad_s: float) -> bool:
    """Whether an axis that loses its power now may leave its limits, or has left them."""
    coasted_rad = q_rad + dq_rad_s * COASTING_S
    low, high = min(q_rad, coasted_rad), max(q_rad, coasted_rad)
    return low < units.min_rad or high > units.max_rad
