"""How far a motion has come, and whether its tips are where they are to be."""

import math

import numpy as np

from dforc.arrays import Vector
from dforc.cartesian.aim import Aim, Mode
from dforc.cartesian.params import CartesianParams
from dforc.cartesian.state import TipReport, worst

STAY = 1.5  # in target: it takes errors this much larger than the tolerances to leave
SLOW_M_S = 0.005  # a target or a plan slower than this is at rest
SLOW_RAD_S = 0.02
ALREADY_RAD = 1e-6  # a way this short has been made


def progress(aim: Aim, q_plan: Vector, free: Vector) -> float:
    """Share of the way in joint space that the plan has made, 0 to 1; 0 in speed mode."""
    if aim.mode is Mode.SPEED:
        return 0.0
    whole = float(np.linalg.norm((aim.q - aim.q_onset) * free))
    left = float(np.linalg.norm((aim.q - q_plan) * free))
    if whole <= ALREADY_RAD:
        return 1.0
    return min(max(1.0 - left / whole, 0.0), 1.0)


def plan_is_at_rest(dq_plan: Vector) -> bool:
    """Whether no joint of the plan moves."""
    return bool(np.abs(dq_plan).max() < SLOW_RAD_S)


def is_in_target(
    aim: Aim, reports: tuple[TipReport, ...], dq_plan: Vector, params: CartesianParams, *, was: bool
) -> bool:
    """Whether all measured tips are at their targets, and target and plan at rest."""
    if aim.mode is not Mode.REACH or not aim.active.any():
        return False
    share = STAY if was else 1.0
    position_m = worst([tip.position_error_m for tip in reports])
    turned_rad = worst([tip.orientation_error_rad for tip in reports])
    near = position_m <= share * params.position_tolerance_m
    turned = math.isnan(turned_rad) or turned_rad <= share * params.orientation_tolerance_rad
    still = (
        float(np.abs(aim.velocity[:, :3]).max()) < SLOW_M_S
        and float(np.abs(aim.velocity[:, 3:]).max()) < SLOW_RAD_S
    )
    return near and turned and still and plan_is_at_rest(dq_plan)
