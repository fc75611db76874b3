"""Constants of the virtual arm, in the papers' terms where they have one."""

import math
from dataclasses import dataclass, fields

from dforc.errors import DforcError


class ArmParamsError(DforcError, ValueError):
    """A constant that lets the arm run away, or never move."""


@dataclass(frozen=True, slots=True, kw_only=True)
class ArmParams:
    """How the virtual arm moves.

    Far from everything the hand obeys eq. 3 with these K and D, up to the speed limits:
    D (v - dx) with v = (K/D) (x_t - x) + dx_t. K = 16, D = 8 is critically damped.
    """

    stiffness_n_m: float = 16.0
    damping_ns_m: float = 8.0
    speed_m_s: float = 0.3  # of the hand
    turn_rad_s: float = 1.5
    turn_gate_m: float = 0.3  # farther from the goal than this the hand turns less
    speed_share: float = 0.8  # of the joints' speed limits
    acceleration_rad_s2: float = 12.0
    margin_m: float = 0.02  # kept from obstacles where a way with it exists
    least_margin_m: float = 0.004  # and else: halved as often as needed, down to this
    self_margin_m: float = 0.005
    approach_1_s: float = 5.0  # largest speed towards an obstacle, over the distance left
    withdraw_1_s: float = 8.0  # speed out of a margin, over its depth
    reach_m: float = 0.20  # obstacles farther than this are not looked at
    stuck_s: float = 0.4  # without progress for so long, a path is planned
    goal_tries: int = 2  # searches of a goal posture in one step
    most_goal_tries: int = 160  # for one goal, at one margin
    enough_postures: int = 4
    planner_states: int = 120  # iterations of the planner in one step
    most_planner_states: int = 20000  # of one plan, before another begins
    retry_s: float = 1.0  # between two attempts at a goal that cannot be had
    position_tolerance_m: float = 0.001
    orientation_tolerance_rad: float = math.radians(0.5)
    lag_slow_m: float = 0.04  # measured hand behind the virtual one: slower from here
    lag_stop_m: float = 0.10  # and no further from here

    def __post_init__(self) -> None:
        """Refuse what is no number or not positive."""
        for field in fields(self):
            value = getattr(self, field.name)
            zero_will_do = field.name in ("margin_m", "least_margin_m", "self_margin_m")
            if not math.isfinite(value) or value < 0.0 or (value == 0.0 and not zero_will_do):
                raise ArmParamsError(f"{field.name} must be a positive number, not {value}")
