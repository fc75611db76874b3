"""One search for a posture, for numba: Newton steps on an augmented Lagrangian, inside all limits.

The multipliers of the conditions are updated as soon as the steps (kernel_step.py) are short. Where
a condition does not give way the search changes over to the nearest posture: its part of the pose
then becomes a stiff cost.
"""

import math

from dforc.arrays import Vector
from dforc.compiled import compiled
from dforc.ik.kernel_cost import CONDITION, COST, Chains, Geometry, Goal, Multipliers, expand
from dforc.ik.kernel_step import (
    SHIFT_GROWTH,
    Limits,
    Room,
    confine,
    finite_length,
    newton_step,
    walk,
)

REACHED, NEAREST, STOPPED = 0, 1, 2  # how a search ended

SHORT_RAD = 0.02  # steps this short update the multipliers
NOISE_RAD = 1e-3  # a step this short that lowers no cost is at the limit of the arithmetic
SETTLED_RAD = 1e-5  # the error left after a Newton step is its square
KEPT_SHARE = 5e-4  # of the radius that a condition may be missed by
STUCK_SHARE = 0.3  # a condition that an update does not bring below this share gives no way
STIFFER = 10.0
FIRST_RHO = (1e3, 1e2)
WORTH = 1e-4  # rad^2 of cost
PATIENCE = 2  # updates without headway before a search turns to the nearest posture


@compiled
def missed(goal: Goal, geometry: Geometry) -> float:
    """By how much the conditions are missed, in their radii; negative where all are kept."""
    worst = -1.0
    for t in range(len(goal.roles)):
        for part in range(2):
            if goal.roles[t, part] == CONDITION:
                r = geometry.residuals[t, part]
                length = math.sqrt(r[0] * r[0] + r[1] * r[1] + r[2] * r[2])
                worst = max(worst, length / goal.radii[part] - 1.0)
    return worst


@compiled
def update(goal: Goal, multipliers: Multipliers, geometry: Geometry) -> None:
    """Y = rho (s - its projection into the ball), s = r + y / rho."""
    for t in range(len(goal.roles)):
        for part in range(2):
            if goal.roles[t, part] != CONDITION:
                continue
            r, y, rho = geometry.residuals[t, part], multipliers.y[t, part], multipliers.rho[part]
            square = 0.0
            for i in range(3):
                y[i] = rho * r[i] + y[i]
                square += y[i] * y[i]
            length = math.sqrt(square)
            share = 1.0
            if multipliers.radii[part] > 0.0:
                share = max(0.0, 1.0 - rho * multipliers.radii[part] / max(length, 1e-300))
            for i in range(3):
                y[i] *= share


@compiled
def widen(goal: Goal, multipliers: Multipliers) -> bool:
    """Let conditions use their radius where that is worth it; whether it is for any.

    They press as softly as it takes for the multiplier to stand for one radius beyond the edge:
    stiffer ones make an edge that Newton steps cross to and fro.
    """
    any_wider = False
    for part in range(2):
        gain = 0.0
        for t in range(len(goal.roles)):
            if goal.roles[t, part] == CONDITION:
                y = multipliers.y[t, part]
                gain += math.sqrt(y[0] * y[0] + y[1] * y[1] + y[2] * y[2]) * goal.radii[part]
        if gain > WORTH and multipliers.radii[part] == 0.0:
            multipliers.radii[part] = goal.radii[part]
            softer = gain / (goal.radii[part] * goal.radii[part])
            multipliers.rho[part] = min(multipliers.rho[part], softer)
            any_wider = True
    return any_wider


@compiled
def relax(goal: Goal) -> None:
    """Make every condition a stiff cost."""
    for t in range(len(goal.roles)):
        for part in range(2):
            if goal.roles[t, part] == CONDITION:
                goal.roles[t, part] = COST
                goal.weights[part] = goal.nearest[part]


@compiled
def begin(limits: Limits, multipliers: Multipliers, room: Room) -> None:
    """Columns of the free joints; no multipliers yet."""
    f, n = len(limits.free), limits.C.shape[1]
    for i in range(f):
        for j in range(f):
            room.C[i, j] = 1.0 if i == j else 0.0
        for row in range(limits.C.shape[0] - n):
            room.C[f + row, i] = limits.C[n + row, limits.free[i]]
    room.held[0] = 0
    multipliers.y[:] = 0.0
    for part in range(2):
        multipliers.rho[part] = FIRST_RHO[part]
        multipliers.radii[part] = 0.0


@compiled
def stiffen(multipliers: Multipliers) -> None:
    """Weigh conditions more."""
    for part in range(2):
        multipliers.rho[part] *= STIFFER


@compiled
def press(goal: Goal, multipliers: Multipliers, geometry: Geometry, stuck: int, met: bool) -> bool:
    """Press on the conditions that are missed, or give them up; whether they are given up.

    Conditions that some posture of this search `met` can be kept and are never given up: a stream
    would go to and fro between that posture and the nearest one.
    """
    if stuck > PATIENCE and not met:
        relax(goal)
        return True
    update(goal, multipliers, geometry)
    if stuck > 0:
        stiffen(multipliers)
    return False


@compiled
def search(
    q: Vector,
    chains: Chains,
    goal: Goal,
    limits: Limits,
    multipliers: Multipliers,
    geometry: Geometry,
    room: Room,
    budget: int,
    use_radius: bool,
) -> tuple[int, int]:
    """From q to the answer, in place. How it ended, and after how many iterations.

    REACHED: optimal, all conditions kept. NEAREST: optimal, some condition cannot be kept near
    here. STOPPED: the budget is used up. q is inside the limits in any case. The goal's conditions
    are costs afterwards where the search ended at the nearest posture. It aims at the middle of
    every condition; with `use_radius` it then goes to its edge where that lowers the cost by more
    than WORTH.
    """
    begin(limits, multipliers, room)
    f = len(limits.free)
    if f == 0:
        return NEAREST, 0
    before, stuck, failed, shift = math.inf, 0, 0, 0.0
    ended, short, settled, gauss, wider = REACHED, False, False, True, False
    met = False
    iteration = -1
    for iteration in range(budget):
        value = expand(
            q,
            chains,
            goal,
            multipliers,
            geometry,
            limits.free,
            limits.slots,
            room.g,
            room.H,
            room.B,
        )
        off = missed(goal, geometry)
        kept = off <= KEPT_SHARE
        met = met or kept
        if settled and kept:
            if not (use_radius and widen(goal, multipliers)):
                return ended, iteration + 1
            settled, before, stuck, wider = False, math.inf, 0, True
            room.middle[:] = q
            continue
        if (short or settled) and not kept:
            short, settled = False, False
            stuck = stuck + 1 if off > STUCK_SHARE * before else 0
            before = off
            if press(goal, multipliers, geometry, stuck, met):
                ended = NEAREST
            continue
        confine(q, limits, room)
        shift = newton_step(room, f, gauss, shift / (SHIFT_GROWTH * SHIFT_GROWTH))
        if shift == math.inf:
            break
        longest = finite_length(room.dq, f)
        settled = longest <= SETTLED_RAD
        share = walk(q, value, chains, goal, multipliers, geometry, limits, room)
        gauss = gauss == (share == 1.0)
        failed = failed + 1 if share == 0.0 else 0
        settled = settled or (failed > 0 and longest <= NOISE_RAD)
        if failed > 1 and not settled:  # the cost falls along neither step
            break
        short = longest <= SHORT_RAD
    if wider:  # the answer in the middle is one
        q[:] = room.middle
        return REACHED, iteration + 1
    return STOPPED, iteration + 1
