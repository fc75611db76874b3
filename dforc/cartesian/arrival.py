"""How far a motion has come, and whether its tips are where they are to be."""

import math

import numpy as np

from dforc.arrays import Matrix, Vector
from dforc.cartesian.aim import Aim, Mode
from dforc.cartesian.params import CartesianParams
from dforc.cartesian.rotation_kernel import pose_misses
from dforc.cartesian.scalar_kernel import largest, weighted_distance
from dforc.cartesian.state import Poses, TipReport, worst

STAY = 1.5  # in target: it takes errors this much larger than the tolerances to leave
SLOW_M_S = 0.005  # a target or a plan slower than this is at rest
SLOW_RAD_S = 0.02
ALREADY_RAD = 1e-6  # a way this short has been made


def progress(aim: Aim, q_plan: Vector, free: Vector) -> float:
    """Share of the way in joint space that the plan has made, 0 to 1; 0 in speed mode."""
    if aim.mode is Mode.SPEED:
        return 0.0
    whole = weighted_distance(aim.q, aim.q_onset, free)
    left = weighted_distance(aim.q, q_plan, free)
    if whole <= ALREADY_RAD:
        return 1.0
    return min(max(1.0 - left / whole, 0.0), 1.0)


def plan_is_at_rest(dq_plan: Vector) -> bool:
    """Whether no joint of the plan moves."""
    return largest(dq_plan) < SLOW_RAD_S


def is_in_target(
    aim: Aim, reports: tuple[TipReport, ...], dq_plan: Vector, params: CartesianParams, *, was: bool
) -> bool:
    """Whether all measured tips are at their targets, and target and plan at rest."""
    if aim.mode is not Mode.REACH:
        return False
    share = STAY if was else 1.0
    position_m = worst([tip.position_error_m for tip in reports])
    turned_rad = worst([tip.orientation_error_rad for tip in reports])
    # nan, where no tip has a target, is no arrival
    near = position_m <= share * params.position_tolerance_m
    turned = math.isnan(turned_rad) or turned_rad <= share * params.orientation_tolerance_rad
    if not (near and turned and plan_is_at_rest(dq_plan)):
        return False
    return all(
        largest(velocity[:3]) < SLOW_M_S and largest(velocity[3:]) < SLOW_RAD_S
        for velocity in aim.velocity
    )


def tip_reports(
    aim: Aim, velocities: Matrix, plan: Poses, measured: Poses
) -> tuple[TipReport, ...]:
    """Each tip of the plan, and how far the measured one is from its target and from the plan."""
    misses = np.empty((len(velocities), 3))
    pose_misses(
        measured.position, measured.rotation, plan.position, aim.position, aim.rotation, misses
    )
    reports = []
    for i, (away_m, turned_rad, beside_m) in enumerate(misses.tolist()):
        reaching = aim.mode is Mode.REACH
        reports.append(
            TipReport(
                plan_position_m=plan.position[i],
                plan_rotation=plan.rotation[i],
                plan_velocity=velocities[i],
                position_error_m=away_m if reaching and aim.active[i, 0] else math.nan,
                orientation_error_rad=turned_rad if reaching and aim.active[i, 3] else math.nan,
                plan_error_m=beside_m,
            )
        )
    return tuple(reports)
