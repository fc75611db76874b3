"""A posture that comes with a virtual point: taken as the answer where it is one."""

import math

import numpy as np

from dforc import rotation
from dforc.arrays import Vector
from dforc.ik.inverse_kinematics import IkResult, IkStatus
from dforc.ik.problem import IkProblem
from services.messages import VirtualPoint
from services.reaching.ik_targets import Targets

POSITION_M = 1e-4  # between the posture's hand and the point
ANGLE_RAD = 1e-3
ROUNDING_RAD = 1e-6  # outside a limit or a row, and of a blocked joint


def posture_of(point: VirtualPoint, n: int) -> Vector | None:
    """The posture (n,) that a point carries; None without one, or where it is none."""
    if len(point.q_rad) != n:
        return None
    q_rad = np.array(point.q_rad)
    return q_rad if math.isfinite(float(q_rad @ q_rad)) else None


def answer_given(
    problem: IkProblem, targets: Targets, q_rad: Vector, before: Vector, step_limit_rad: float
) -> IkResult | None:
    """The posture as an answer: its hands are at the targets, and it keeps limits, rows and step.

    None where it does not.
    """
    moved = np.abs(q_rad - before)
    if moved.max() > step_limit_rad or (moved[~problem.free] > ROUNDING_RAD).any():
        return None
    if problem.limits.violation(q_rad) > ROUNDING_RAD:
        return None
    errors: list[tuple[float, float] | None] = []
    for tip, target in zip(problem.tips, targets, strict=True):
        if target is None:
            errors.append(None)
            continue
        turned, place = tip.pose(q_rad)
        away_m, off_rad = 0.0, 0.0
        if target.position_m is not None:
            away_m = math.dist(place, target.position_m)
        if target.rotation is not None:
            off_rad = rotation.angle_between(turned, target.rotation)
        if away_m > POSITION_M or off_rad > ANGLE_RAD:
            return None
        errors.append((away_m, off_rad))
    known = [error for error in errors if error is not None]
    return IkResult(
        q_rad=q_rad,
        status=IkStatus.CONVERGED,
        position_error_m=max(error[0] for error in known),
        orientation_error_rad=max(error[1] for error in known),
        tip_errors=tuple(errors),
        objective=0.0,
        iterations=0,
        step_limited=False,
        reason="",
    )
