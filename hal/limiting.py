"""How much of a set-point may be sent: pure arithmetic on limits, room and rates.

A board's loop trails a moving reference and runs past where it stops. So whatever moves towards a
limit slows down with the room that is left.
"""

import math
from collections.abc import Sequence

from hal.units import AxisUnits

CYCLE_S = 0.01  # one set-point per axis
BRAKING_S = 0.6  # the slowest of the boards' position loops settle in this
CREEP_TICKS = 0.2  # so that the limit itself is reached
COASTING_S = 0.25  # how long an axis may run on without power, or from torques at full scale
STOPPING_S = 0.08  # how far a compliant axis may run on at the speed at which it is made stiff
ONSET_S = 0.015  # of making stiff: a frame's age, the switch, the loop
FRAMES_S = 0.004  # between two POSITION frames
NOISE_TICKS = 1.0  # of a difference of angles: an axis that stands may show as much
REACTION_S = 0.005  # from a board's reference to the POSITION frame that is known here
MOST_BEYOND_RAD = math.radians(5.0)  # farther out it has not overshot: somebody has put it there


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
    """A velocity that ends inside the limits even if it is kept for `look_ahead_s`.

    An axis that has overshot a limit goes back, whatever is asked for.
    """
    highest = min(_room(units.max_rad - q_rad) / look_ahead_s, units.max_velocity_rad_s)
    lowest = -min(_room(q_rad - units.min_rad) / look_ahead_s, units.max_velocity_rad_s)
    return min(max(dq_rad_s, lowest), highest)


def _room(left_rad: float) -> float:
    """Room up to a limit, negative behind it; none far out, where nothing overshoots."""
    return left_rad if left_rad >= -MOST_BEYOND_RAD else 0.0


def is_near_limit(
    units: AxisUnits, motion: tuple[float, float], ahead_s: float, slack_rad: float
) -> bool:
    """Whether an axis that runs on for `ahead_s` leaves its limits, or has left them.

    `slack_rad` outside is inside: one tick at least, for there an axis may stand that was moved to
    its limit.
    """
    q_rad, dq_rad_s = motion
    coasted_rad = q_rad + dq_rad_s * ahead_s
    low, high = min(q_rad, coasted_rad), max(q_rad, coasted_rad)
    return low < units.min_rad - slack_rad or high > units.max_rad + slack_rad


def speed_ahead(units: AxisUnits, recent: Sequence[tuple[int, int]]) -> float:
    """Speed of an axis, rad/s, by the time that a loop which brakes it takes hold.

    `recent` are its last POSITION frames, as of Axis. Their mean speed is half a window old: a
    drive that believes a wrong torque is twice as fast by then. One that loses speed is not
    credited with it.
    """
    if len(recent) < 3:
        return 0.0
    half = len(recent) // 2
    first, first_ns = recent[0]
    between, between_ns = recent[half]
    last, last_ns = recent[-1]
    # Frames that were held up come together: no axis is faster for that.
    old_s = max((between_ns - first_ns) * 1e-9, half * FRAMES_S)
    new_s = max((last_ns - between_ns) * 1e-9, (len(recent) - 1 - half) * FRAMES_S)
    window_s = old_s + new_s
    speed = _beyond(last - first, NOISE_TICKS) / window_s
    gained = (last - between) / new_s - (between - first) / old_s
    gained = _beyond(gained, 2.0 * NOISE_TICKS / min(old_s, new_s))
    if gained * speed > 0.0:
        speed += gained * (0.5 * window_s + ONSET_S) / (0.5 * window_s)
    return speed * units.rad_per_tick


def _beyond(value: float, noise: float) -> float:
    return math.copysign(max(abs(value) - noise, 0.0), value)


def way_back(units: AxisUnits, ticks: int, dq_rad_s: float) -> int | None:
    """Where an axis has to return to whose reference was set where it is, None if nowhere."""
    reference = ticks + dq_rad_s * REACTION_S * units.ticks_per_rad
    target = min(max(reference, units.low_ticks), units.high_ticks)
    beyond_rad = abs((reference - target) * units.rad_per_tick)
    return round(target) if 0.0 < beyond_rad <= MOST_BEYOND_RAD else None
