"""The compiled estimate: reads the tables, runs the passes, writes one flat vector of results.

The order of the tables is that of tables.py, the order of the results that of plan.Layout.
"""

from dforc.arrays import Matrix, Vector
from dforc.compiled import compiled
from dforc.estimation.kernel import base_motion, move, need, place, turned, turned_back
from dforc.estimation.kernel_contacts import solve_sub_model
from dforc.estimation.kernel_views import (
    contacts_of,
    cuts_of,
    given_of,
    results_of,
    room_of,
    sub_models_of,
    tree_of,
)
from dforc.estimation.tree_model import Indices

LARGEST = 1.0e300
DONE, NOT_FINITE, WRONG_SHAPE, TOO_LARGE = 0, 1, 2, 3
MAINSTAY = 1
BODIES, JOINTS, SENSORS, SOURCE = 0, 1, 2, 6


@compiled
def is_strange(values: Vector) -> bool:
    """Whether one of the values is no number, infinite, or absurdly large."""
    strange = 0
    for i in range(values.shape[0]):
        strange |= not abs(values[i]) < LARGEST
    return strange != 0


@compiled
def is_finite(
    q: Vector, dq: Vector, ddq: Vector, wrenches: Matrix, cuts: Indices, motion: Vector
) -> bool:
    """Whether everything that will be read is a number; sensors that are not valid are not."""
    if is_strange(q) or is_strange(dq) or is_strange(ddq) or is_strange(motion):
        return False
    strange = 0
    for s in range(wrenches.shape[0]):
        if cuts[s] >= 0:
            strange |= is_strange(wrenches[s])
    return strange == 0


@compiled
def at_sensors(
    wrenches: Matrix,
    sensor_body: Indices,
    cuts: Indices,
    poses: Matrix,
    G: Matrix,
    beyond: Matrix,
    internal: Matrix,
) -> None:
    """Each sensor's reading without contacts, and what the world exerts beyond a valid one."""
    for s in range(sensor_body.shape[0]):
        body = sensor_body[s]
        pose, need, inside = poses[body], G[body], internal[s]
        px, py, pz = pose[9], pose[10], pose[11]
        fx, fy, fz = need[0], need[1], need[2]
        mx, my, mz = (
            need[3] - (py * fz - pz * fy),
            need[4] - (pz * fx - px * fz),
            need[5] - (px * fy - py * fx),
        )
        lx, ly, lz = turned_back(pose, fx, fy, fz)
        inside[0], inside[1], inside[2] = -lx, -ly, -lz
        lx, ly, lz = turned_back(pose, mx, my, mz)
        inside[3], inside[4], inside[5] = -lx, -ly, -lz
        if cuts[s] < 0:
            continue
        w, more = wrenches[s], beyond[cuts[s]]
        fx, fy, fz = turned(pose, w[0] - inside[0], w[1] - inside[1], w[2] - inside[2])
        mx, my, mz = turned(pose, w[3] - inside[3], w[4] - inside[4], w[5] - inside[5])
        more[0], more[1], more[2] = fx, fy, fz
        more[3], more[4], more[5] = (
            mx + py * fz - pz * fy,
            my + pz * fx - px * fz,
            mz + px * fy - py * fx,
        )


@compiled
def place_contacts(
    body: Indices, table: Matrix, poses: Matrix, points: Matrix, directions: Matrix
) -> None:
    """Points and directions of the contacts in the base."""
    for i in range(body.shape[0]):
        pose, given = poses[body[i]], table[i]
        x, y, z = turned(pose, given[0], given[1], given[2])
        points[i, 0], points[i, 1], points[i, 2] = pose[9] + x, pose[10] + y, pose[11] + z
        x, y, z = turned(pose, given[3], given[4], given[5])
        directions[i, 0], directions[i, 1], directions[i, 2] = x, y, z


@compiled
def add_known(
    body: Indices, sub_model: Indices, table: Matrix, poses: Matrix, E: Matrix, missing: Matrix
) -> None:
    """Known wrenches: on their bodies, and no longer missing in their sub-models."""
    for i in range(body.shape[0]):
        pose, given = poses[body[i]], table[i]
        fx, fy, fz = turned(pose, given[0], given[1], given[2])
        mx, my, mz = turned(pose, given[3], given[4], given[5])
        px, py, pz = pose[9], pose[10], pose[11]
        mx, my, mz = mx + py * fz - pz * fy, my + pz * fx - px * fz, mz + px * fy - py * fx
        row, rest = E[body[i]], missing[sub_model[i]]
        row[0], row[1], row[2] = row[0] + fx, row[1] + fy, row[2] + fz
        row[3], row[4], row[5] = row[3] + mx, row[4] + my, row[5] + mz
        rest[0], rest[1], rest[2] = rest[0] - fx, rest[1] - fy, rest[2] - fz
        rest[3], rest[4], rest[5] = rest[3] - mx, rest[4] - my, rest[5] - mz


@compiled
def torques(
    tree: tuple[Indices, Indices, Matrix, Matrix],
    top: Indices,
    beyond: Matrix,
    G: Matrix,
    E: Matrix,
    tau: Vector,
) -> None:
    """From the tips inwards: what each sub-tree needs less what the world gives it (eq. 10)."""
    parent, joint, bodies, poses = tree
    for i in range(bodies.shape[0] - 1, 0, -1):
        mine, need = E[i], G[i]
        if top[i] > 0:  # a valid sensor knows better than the sum of what was found beyond it
            for k in range(6):
                mine[k] = beyond[top[i], k]
        for k in range(6):
            E[parent[i], k] += mine[k]
        j = joint[i]
        if j >= 0:
            row, pose = bodies[i], poses[i]
            nx, ny, nz = turned(pose, row[30], row[31], row[32])
            px, py, pz = pose[9], pose[10], pose[11]
            fx, fy, fz = need[0] - mine[0], need[1] - mine[1], need[2] - mine[2]
            mx = need[3] - mine[3] - (py * fz - pz * fy)
            my = need[4] - mine[4] - (pz * fx - px * fz)
            mz = need[5] - mine[5] - (px * fy - py * fx)
            tau[j] = nx * mx + ny * my + nz * mz


@compiled
def missing_in(above: Indices, beyond: Matrix, missing: Matrix) -> None:
    """What the world exerts on each sub-model: beyond its own cut, but not beyond the next ones."""
    for s in range(beyond.shape[0]):
        for c in range(6):
            missing[s, c] = beyond[s, c]
    for s in range(1, beyond.shape[0]):
        for c in range(6):
            missing[above[s], c] -= beyond[s, c]


@compiled
def give(body: Indices, points: Matrix, found: Matrix, E: Matrix) -> None:
    """Every contact's wrench to its body, about the origin."""
    for i in range(body.shape[0]):
        w, p, row = found[i], points[i], E[body[i]]
        row[0], row[1], row[2] = row[0] + w[0], row[1] + w[1], row[2] + w[2]
        row[3] += w[3] + p[1] * w[2] - p[2] * w[1]
        row[4] += w[4] + p[2] * w[0] - p[0] * w[2]
        row[5] += w[5] + p[0] * w[1] - p[1] * w[0]


@compiled
def set_reference(pose: Vector, members: Indices, points: Matrix, numbers: Vector) -> None:
    """Where a sub-model's moments are taken: the middle of its contacts, else where it begins."""
    count = members.shape[0]
    for c in range(3):
        middle = 0.0
        for i in members:
            middle += points[i, c] / count
        numbers[3 + c] = middle if count > 0 else pose[9 + c]


@compiled
def poses_of(q: Vector, whole: Indices, real: Vector, out: Vector) -> None:
    """Poses of all bodies into the front of `out`."""
    parent, joint, bodies, poses = tree_of(whole, real, out)
    place(q, parent, joint, bodies, poses)


@compiled
def estimate(
    whole: Indices,
    real: Vector,
    q: Vector,
    dq: Vector,
    ddq: Vector,
    wrenches: Matrix,
    out: Vector,
) -> int:
    """One estimate into `out`; nothing in it is valid when the answer is not DONE."""
    n, m = whole[JOINTS], whole[SENSORS]
    if q.shape[0] != n or dq.shape[0] != n or ddq.shape[0] != n:
        return WRONG_SHAPE
    if wrenches.shape[0] != m or wrenches.shape[1] != 6:
        return WRONG_SHAPE
    top, sensor_body, cuts = cuts_of(whole)
    contact_table, known_table, source, motion = given_of(whole, real)
    if not is_finite(q, dq, ddq, wrenches, cuts, motion):
        return NOT_FINITE
    tree = tree_of(whole, real, out)
    parent, joint, bodies, poses = tree
    above, first, methods, ends = sub_models_of(whole)
    contact_body, unknowns, members, known_body, known_sub = contacts_of(whole)
    moves, G, E, beyond, missing, directions, W, V = room_of(whole, real)
    tau, found, points, base, internal, numbers = results_of(whole, out)
    place(q, parent, joint, bodies, poses)
    base_motion(source, motion, whole[SOURCE], (dq, ddq), tree, moves)
    move(dq, ddq, tree, moves)
    need(bodies, poses, moves, parent, G)
    at_sensors(wrenches, sensor_body, cuts, poses, G, beyond, internal)
    beyond[0, :] = G[0]
    E[:, :] = 0.0
    found[:, :] = 0.0
    base[:] = 0.0
    numbers[:, :] = 0.0
    place_contacts(contact_body, contact_table, poses, points, directions)
    missing_in(above, beyond, missing)
    add_known(known_body, known_sub, known_table, poses, E, missing)
    if methods[0] == MAINSTAY:
        base[:] = missing[0]
    begin = 0
    for s in range(above.shape[0]):
        mine = members[begin : ends[s]]
        begin = ends[s]
        if methods[s] == MAINSTAY:
            numbers[s, :6], numbers[s, 6] = 0.0, 6.0
        else:
            set_reference(poses[first[s]], mine, points, numbers[s])
            places, scratch = (points, directions), (W, V)
            solve_sub_model(
                methods[s], mine, unknowns, places, missing[s], scratch, found, numbers[s]
            )
    give(contact_body, points, found, E)
    torques(tree, top, beyond, G, E, tau)
    return TOO_LARGE if is_strange(out[12 * whole[BODIES] :]) else DONE
