"""Two trees of postures that grow towards each other (RRT-Connect), for numba.

Kuffner and LaValle 2000: the tree whose turn it is grows one step towards a random posture, then
the other tree runs for the new node as far as it can. Here both steps end where something stops
them, and every call ends when it has looked at enough postures; the next one goes on.
"""

import math
from typing import NamedTuple

import numpy as np

from dforc.arrays import Matrix, Vector
from dforc.compiled import compiled
from dforc.ik.kernel_chain import Indices
from dforc.virtual_arm.kernel_edge import Scene, march
from dforc.virtual_arm.kernel_random import EVERYWHERE, Room, draw, uniform

SEARCHING, MET, USED_UP = 0, 1, 2
# What stands where in Trees.state: two words of the random generator, then
ACTIVE, FROM, TARGET, GOAL, GOALS, LOOKED, MET_START, MET_GOAL = 2, 3, 4, 5, 6, 7, 8, 9
STATE_WORDS = 10
NOWHERE = -1

STEP_M = 0.25  # of a tree, in the metric of postures
SHORTEST_M = 0.01  # a step that is stopped earlier leaves no node
BESIDE = 0.5  # share of the random postures that are drawn beside a straight way to a goal
BESIDE_SPREAD = 0.5  # and from how much of the joints' ranges
NODES_PER_LOOK = 256  # distances of nodes that take as long as looking at one posture


class Trees(NamedTuple):
    """The tree from the start (0) and the one from the goals (1)."""

    nodes: Matrix  # (2, M, n)
    parents: Indices  # (2, M), -1 of a root
    counts: Indices  # (2,)
    state: Indices  # (STATE_WORDS,)
    drawn: Vector  # (n,)
    tried: Vector  # (n,)


def trees_of(n: int, most_nodes: int) -> Trees:
    """Room for trees of so many nodes each."""
    return Trees(
        np.zeros((2, most_nodes, n)),
        np.full((2, most_nodes), NOWHERE, dtype=np.int64),
        np.zeros(2, dtype=np.int64),
        np.zeros(STATE_WORDS, dtype=np.int64),
        np.zeros(n),
        np.zeros(n),
    )


@compiled
def distance(metric: Vector, a: Vector, b: Vector) -> float:
    """Weighted distance of two postures."""
    square = 0.0
    for j in range(len(metric)):
        part = metric[j] * (a[j] - b[j])
        square += part * part
    return math.sqrt(square)


@compiled
def nearest_node(nodes: Matrix, count: int, metric: Vector, q: Vector) -> int:
    """Which of the first `count` nodes is nearest."""
    nearest, least = 0, math.inf
    for k in range(count):
        square = 0.0
        for j in range(len(metric)):
            part = metric[j] * (nodes[k, j] - q[j])
            square += part * part
            if square >= least:
                break
        if square < least:
            nearest, least = k, square
    return nearest


@compiled
def step_towards(scene: Scene, trees: Trees, tree: int, node: int, q: Vector) -> tuple[int, bool]:
    """Grow a tree by a step from a node towards q: the new node, or -1, and whether it is at q."""
    a, b = trees.nodes[tree, node], trees.tried
    away = distance(scene.moving.metric, a, q)
    share = 1.0 if away <= STEP_M else STEP_M / away
    for j in range(len(b)):
        b[j] = a[j] + share * (q[j] - a[j])
    free, _, looks = march(scene, a, b)
    trees.state[LOOKED] += looks
    if free < 1.0 and free * share * away < SHORTEST_M:
        return NOWHERE, False
    new = trees.counts[tree]
    for j in range(len(b)):
        trees.nodes[tree, new, j] = b[j] if free >= 1.0 else a[j] + free * (b[j] - a[j])
    trees.parents[tree, new] = node
    trees.counts[tree] = new + 1
    return new, free >= 1.0 and share >= 1.0


@compiled
def aim_at_random(room: Room, trees: Trees) -> None:
    """A posture to grow towards: every other one near a straight way from the start to a goal."""
    state, start, middle = trees.state, trees.nodes[0, 0], trees.tried
    if uniform(state) < BESIDE:
        goal = trees.nodes[1, int(uniform(state) * state[GOALS])]
        share = uniform(state)
        for j in range(len(middle)):
            middle[j] = start[j] + share * (goal[j] - start[j])
        draw(state, room, middle, BESIDE_SPREAD, trees.drawn)
    else:
        draw(state, room, start, EVERYWHERE, trees.drawn)


@compiled
def next_goal(room: Room, metric: Vector, trees: Trees) -> int:
    """From which node of the active tree to grow towards `drawn`; the next goal or at random."""
    state, goal = trees.state, trees.state[GOAL]
    if goal < state[GOALS]:  # they are the first nodes of their tree
        state[ACTIVE], state[TARGET], state[GOAL] = 0, goal, goal + 1
        trees.drawn[:] = trees.nodes[1, goal]
        return 0
    state[TARGET] = NOWHERE
    aim_at_random(room, trees)
    active = state[ACTIVE]
    state[LOOKED] += (trees.counts[0] + trees.counts[1]) // NODES_PER_LOOK
    return nearest_node(trees.nodes[active], trees.counts[active], metric, trees.drawn)


@compiled
def after_step(metric: Vector, trees: Trees, new: int, arrived: bool) -> bool:
    """Decide who grows next, and from where; whether the trees have met."""
    state, active = trees.state, trees.state[ACTIVE]
    target, other = state[TARGET], 1 - active
    if target >= 0:  # the active tree runs for the target until something stops it
        state[FROM] = new
        if arrived:
            state[MET_START] = new if active == 0 else target
            state[MET_GOAL] = target if active == 0 else new
        return arrived
    state[ACTIVE], state[FROM] = other, NOWHERE
    if new >= 0:
        trees.drawn[:] = trees.nodes[active, new]
        state[TARGET] = new
        state[FROM] = nearest_node(trees.nodes[other], trees.counts[other], metric, trees.drawn)
    return False


@compiled
def grow(scene: Scene, room: Room, trees: Trees, looks: int, most_looks: int) -> int:
    """Go on until so many more postures have been looked at, or the trees meet.

    First the start runs for one goal after the other. USED_UP when the trees are full or have
    taken `most_looks` in all.
    """
    state, metric = trees.state, scene.moving.metric
    until = min(state[LOOKED] + looks, most_looks)
    full = trees.nodes.shape[1] - 1
    while state[LOOKED] < until:
        if max(trees.counts[0], trees.counts[1]) >= full:
            return USED_UP
        if state[FROM] < 0:
            state[FROM] = next_goal(room, metric, trees)
        new, arrived = step_towards(scene, trees, state[ACTIVE], state[FROM], trees.drawn)
        if after_step(metric, trees, new, arrived):
            return MET
    return USED_UP if state[LOOKED] >= most_looks else SEARCHING


@compiled
def trace(trees: Trees, path: Matrix) -> int:
    """The way from the start to a goal through the place where the trees met; its postures."""
    n, count = path.shape[1], 0
    node = trees.state[MET_START]
    while node >= 0:
        count += 1
        node = trees.parents[0, node]
    node = trees.state[MET_START]
    for k in range(count - 1, -1, -1):
        for j in range(n):
            path[k, j] = trees.nodes[0, node, j]
        node = trees.parents[0, node]
    node = trees.parents[1, trees.state[MET_GOAL]]  # the node where they met is in both
    while node >= 0:
        for j in range(n):
            path[count, j] = trees.nodes[1, node, j]
        count += 1
        node = trees.parents[1, node]
    return count
