"""DForC on PMP's targets: the paper's virtual point (eq. 3) and the inverse kinematics behind it.

The point moves by K = 4 N/m, D = 8 Ns/m and turns as in mode dforc of the stack; every 10 ms the
inverse kinematics answers with a posture near the one before, position first. An orientation is
missed by more than a degree; whether it could have been attained is asked of many starts.
"""

import math
from dataclasses import dataclass

import numpy as np

from dforc.arrays import Vector
from dforc.field.force import FieldParams, PointState, Target, scene_of
from dforc.field.rollout import roll_out
from dforc.field.turning import Turning
from dforc.ik.inverse_kinematics import InverseKinematics
from dforc.ik.problem import IkProblem, Tip, TipTarget
from dforc.limits import JointLimits
from dforc.rotation import angle_between
from services.experiments.field_figures.pmp import SHORT_TARGETS, TARGETS, targets_of
from services.experiments.field_figures.pmp_arm import MEASURED, TORSO, HandPose, PmpArm, arm_of
from services.experiments.reporting import Tell
from services.experiments.rows import Row, at_most

PERIOD_S = 0.01
STEPS = 1200  # 12 s: eq. 3 needs 9.5 s to come within 2 mm from 0.3 m away
POSITION_M, ORIENTATION_RAD = 0.002, math.radians(1.0)
STARTS, BUDGET = 40, 8000
REST_DEG = (0.0, 0.0, 0.0, -30.0, 30.0, 0.0, 50.0, 0.0, 0.0, 0.0)
TORSO_WEIGHT, ARM_WEIGHT = 1.0, 0.1
PAPER = FieldParams(stiffness_n_m=4.0, damping_ns_m=8.0)


@dataclass(frozen=True, slots=True, kw_only=True)
class Reached:
    """How one target ended."""

    error_m: float
    error_rad: float
    outside_rad: float  # of the limits, at worst on the way
    is_attainable: bool  # position and orientation together

    @property
    def is_missed(self) -> bool:
        """The orientation, though it could have been had."""
        return self.error_rad > ORIENTATION_RAD and self.is_attainable


def dforc_targets_rows(short: bool = False, seed: int = 0, tell: Tell | None = None) -> list[Row]:
    """Bars over all targets of PMP's table, mid-range and at the edge."""
    arm = arm_of(MEASURED)
    count = SHORT_TARGETS // 6 if short else TARGETS
    targets = targets_of(arm, seed, count)
    rows: list[Row] = []
    for at_edge, name in ((False, "mid-range"), (True, "edge")):
        found = []
        for number, target in enumerate(targets[at_edge]):
            if tell is not None:
                tell(f"DForC, {name} target {number + 1} of {count}")
            found.append(reach(arm, target))
        rows += _rows(f"DForC on PMP's {name} targets", found)
    return rows


def problem_of(arm: PmpArm) -> IkProblem:
    """The arm's inverse kinematics, within the limits that PMP has."""
    weights = [TORSO_WEIGHT] * len(TORSO) + [ARM_WEIGHT] * (arm.model.n - len(TORSO))
    limits = JointLimits.make(arm.model.lower_rad, arm.model.upper_rad)
    return IkProblem.make((Tip("hand", arm.model),), limits, np.radians(REST_DEG), weights)


def reach(arm: PmpArm, target: HandPose) -> Reached:
    """From home to one target."""
    problem = problem_of(arm)
    inverse, limits = InverseKinematics(problem), problem.limits
    q, outside = arm.home_rad, -math.inf
    goal = TipTarget(target.position_m, target.rotation)
    turning = Turning(problem)
    turning.begin(q)
    turned = [arm.model.tip_pose(q)[0]]
    error_m = error_rad = math.inf
    place_m = arm.home_m
    for point in virtual_path(arm.home_m, target.position_m):
        turned = turning.step(turned, [place_m], [goal], PERIOD_S)
        place_m = point
        answer = inverse.track([TipTarget(point, turned[0])], q)
        q = answer.q_rad
        outside = max(outside, limits.violation(q))
    rotation, position_m = arm.model.tip_pose(q)
    error_rad = angle_between(rotation, target.rotation)
    error_m = float(np.linalg.norm(position_m - target.position_m))
    attainable = True
    if error_rad > ORIENTATION_RAD:
        best = inverse.solve([goal], arm.home_rad, budget=BUDGET, starts=STARTS)
        attainable = best.orientation_error_rad <= ORIENTATION_RAD
    return Reached(
        error_m=error_m, error_rad=error_rad, outside_rad=outside, is_attainable=attainable
    )


def virtual_path(start_m: Vector, target_m: Vector) -> list[Vector]:
    """The paper's point on its way, every 10 ms."""
    (sx, sy, sz), (tx, ty, tz) = start_m.tolist(), target_m.tolist()
    scene = scene_of((Target(position_m=(tx, ty, tz)),), (), PAPER)
    path = roll_out(PointState(position_m=(sx, sy, sz)), scene, STEPS)
    return list(path.positions_m[1:])


def _rows(what: str, found: list[Reached]) -> list[Row]:
    worst_mm = 1e3 * max(one.error_m for one in found)
    outside_deg = math.degrees(max(one.outside_rad for one in found))
    missed = [one for one in found if one.error_rad > ORIENTATION_RAD]
    return [
        at_most(f"{what}: position, largest error", worst_mm, "mm", POSITION_M * 1e3),
        at_most(f"{what}: orientation missed though attainable", _missed(found), "", 0.0),
        Row(f"{what}: orientation missed by more than a degree", float(len(missed)), ""),
        Row(f"{what}: orientation, median error", _middle_deg(found), "deg"),
        at_most(f"{what}: joint limit crossed by", max(0.0, outside_deg), "deg", 0.0),
    ]


def _missed(found: list[Reached]) -> float:
    return float(sum(one.is_missed for one in found))


def _middle_deg(found: list[Reached]) -> float:
    return math.degrees(float(np.median([one.error_rad for one in found])))
