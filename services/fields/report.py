"""The field's status: state, reason, and every field that acts or could."""

import math

import msgspec
import numpy as np

from dforc import rotation
from services.fields.clearances import surface_distances
from services.fields.driver import PointDriver
from services.fields.gains import as_pairs
from services.fields.goals import ActiveGoal
from services.fields.limbs import FieldLimb
from services.fields.messages import FieldState, FieldStatus
from services.fields.mode import Goals, HandPoint, Motion, Surroundings
from services.fields.preview import goal_distance_m
from services.fields.seen import SeenObject
from services.fields.sources import find_object
from services.messages import NAN3, Vector3
from services.reaching.tip_poses import vector3

GOAL = "goal"
LIMITS = "limits"


def field_status(
    now_ns: int,
    driver: PointDriver,
    hands: tuple[HandPoint, ...],
    around: Surroundings,
    seen: tuple[SeenObject, ...],
    limb: FieldLimb,
) -> FieldStatus:
    """All but the counts, and the state as far as the points know it.

    `hands` are the points, or the hands where none moves.
    """
    motion, goals, goal = driver.motion, driver.asked, driver.goal
    clearance_m, nearest = math.nan, ("", "")
    if motion is not None:
        clearance_m, nearest = motion.clearance_m, motion.nearest
    return FieldStatus(
        stamp_ns=now_ns,
        mode=driver.mode,
        gains=as_pairs(driver.gains[driver.mode]),
        limb=limb.name,
        state="idle" if motion is None else motion.state,
        reason="" if motion is None else motion.reason,
        goal=0 if goal is None else goal.number,
        goal_position_m=goal_place(goal, goals),
        goal_distance_m=math.nan
        if motion is None or goals is None
        else goal_distance_m(motion, goals),
        goal_angle_rad=_goal_angle_rad(motion, goals),
        point_position_m=NAN3 if motion is None else vector3(motion.hands[0].position_m),
        point_velocity_m_s=NAN3 if motion is None else vector3(motion.hands[0].velocity_m_s),
        lag_m=driver.lag_m,
        fields=field_states(driver, hands, around, seen, limb),
        clearance_m=clearance_m,
        nearest=nearest,
        iterations=0 if motion is None else motion.iterations,
        budget=0 if driver.law is None else driver.law.budget,
        held=driver.held,
        nodes=0 if motion is None else motion.nodes,
    )


def field_states(
    driver: PointDriver,
    hands: tuple[HandPoint, ...],
    around: Surroundings,
    seen: tuple[SeenObject, ...],
    limb: FieldLimb,
) -> tuple[FieldState, ...]:
    """Goal, objects, limits."""
    forces = {}
    if driver.law is not None:
        forces = driver.law.forces(driver.asked, around)
    followed = None
    if driver.goal is not None and driver.goal.message.follow:
        followed = find_object(seen, driver.goal.message.follow)
    states = []
    if driver.asked is not None and hands:
        states.append(_goal_state(driver, hands, followed, forces.get(GOAL, math.nan)))
    distances = surface_distances(hands, around) if hands else []
    acting = {
        (one.source, one.name): distance
        for one, distance in zip(around.obstacles, distances, strict=False)
    }
    states += [
        _object_state(one, hands, acting.get((one.source, one.name)), forces)
        for one in seen
        if one is not followed or driver.asked is None
    ]
    if driver.motion is not None and driver.motion.q_rad is not None:
        states.append(_limit_state(limb, driver.motion))
    return tuple(states)


def goal_place(goal: ActiveGoal | None, goals: Goals | None) -> Vector3:
    """Where the goal is now; of an object that is followed and not seen, nowhere."""
    if goals is not None and goals[0] is not None:
        return vector3(goals[0].position_m)
    if goal is None or goal.message.follow:
        return NAN3
    return goal.message.position_m


def _goal_state(
    driver: PointDriver, hands: tuple[HandPoint, ...], followed: SeenObject | None, force_n: float
) -> FieldState:
    goal = driver.asked[0] if driver.asked else None
    if goal is None:
        return FieldState(name=GOAL, kind="target", on=False, distance_m=math.nan, force_n=math.nan)
    plain = FieldState(
        name=GOAL,
        kind="target",
        on=True,
        distance_m=math.dist(goal.position_m, hands[0].position_m),
        force_n=force_n,
        position_m=vector3(goal.position_m),
        velocity_m_s=vector3(goal.velocity_m_s),
    )
    if followed is None:
        return plain
    return msgspec.structs.replace(
        plain,
        name=followed.name,
        sigma_m=followed.sigma_m,
        age_s=followed.age_s,
        source=followed.source,
        note="followed",
    )


def _object_state(
    one: SeenObject,
    hands: tuple[HandPoint, ...],
    distance_m: float | None,
    forces: dict[str, float],
) -> FieldState:
    away_m, note = distance_m, one.lost
    if away_m is None:
        away_m = min((math.dist(one.place_m, h.position_m) for h in hands), default=math.nan)
    elif away_m < 0.0 and not note:
        note = f"the hand is {-1e3 * away_m:.0f} mm inside"
    return FieldState(
        name=one.name,
        kind=one.role,
        on=distance_m is not None,
        distance_m=away_m,
        force_n=forces.get(one.name, math.nan),
        position_m=one.place_m,
        velocity_m_s=one.velocity_m_s,
        sigma_m=one.sigma_m,
        age_s=one.age_s,
        source=one.source,
        note=note,
    )


def _limit_state(limb: FieldLimb, motion: Motion) -> FieldState:
    """The joint that is nearest to its limit."""
    limits, q_rad = limb.problem.limits, motion.q_rad
    assert q_rad is not None
    left = np.minimum(q_rad - limits.lower_rad, limits.upper_rad - q_rad)
    left = np.where(limb.problem.free, left, np.inf)
    nearest = int(np.argmin(left))
    return FieldState(
        name=LIMITS,
        kind="limits",
        on=True,
        distance_m=math.nan,
        force_n=math.nan,
        note=f"{limb.shape.joints[nearest]} {math.degrees(left[nearest]):.1f} deg from its limit",
    )


def _goal_angle_rad(motion: Motion | None, goals: Goals | None) -> float:
    if motion is None or goals is None:
        return math.nan
    angles = [
        rotation.angle_between(hand.rotation, goal.rotation)
        for hand, goal in zip(motion.hands, goals, strict=True)
        if goal is not None and goal.rotation is not None
    ]
    return max(angles, default=math.nan)
