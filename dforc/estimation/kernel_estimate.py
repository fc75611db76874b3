"""The compiled estimate: reads the tables, runs the passes, writes one flat vector of results."""

from dforc.arrays import Matrix, Vector
from dforc.compiled import compiled
from dforc.estimation.kernel import (
    GIVEN,
    NEED,
    base_motion,
    move,
    need,
    place,
    turned,
    turned_back,
)
from dforc.estimation.kernel_contacts import shift, solve_sub_model
from dforc.estimation.kernel_views import (
    BODIES,
    JOINTS,
    SENSORS,
    SOURCE,
    plan_of,
    results_of,
    room_of,
    scratch_of,
    tree_of,
)
from dforc.estimation.path import DONE, NOT_FINITE, WRONG_SHAPE
from dforc.estimation.plan import MAINSTAY, WRENCH
from dforc.estimation.tables import BODY_NUMBERS as END
from dforc.estimation.tree_model import Indices, Places

LARGEST = 1.0e300


@compiled
def is_strange(values: Vector) -> bool:
    """Whether one of the values is no number, infinite, or absurdly large."""
    strange = 0
    for i in range(values.shape[0]):
        strange |= not abs(values[i]) < LARGEST
    return strange != 0


@compiled
def is_finite(
    q: Vector, dq: Vector, ddq: Vector, wrenches: Matrix, sensors: Places, source: Vector
) -> bool:
    """Whether everything that will be read is a number; sensors that are not valid are not."""
    if is_strange(q) or is_strange(dq) or is_strange(ddq) or is_strange(source):
        return False
    strange = 0
    for s in range(wrenches.shape[0]):
        if sensors[s, 1] >= 0:
            strange |= is_strange(wrenches[s])
    return strange == 0


@compiled
def at_sensors(
    wrenches: Matrix,
    sensors: Places,
    bodies: Matrix,
    poses: Matrix,
    sub_models: Matrix,
    internal: Matrix,
) -> None:
    """Each sensor's reading without contacts, and what the world exerts beyond a valid one."""
    for s in range(sensors.shape[0]):
        body, cut = sensors[s, 0], sensors[s, 1]
        pose, needed, inside = poses[body], bodies[body, NEED:GIVEN], internal[s]
        px, py, pz = pose[9], pose[10], pose[11]
        fx, fy, fz = needed[0], needed[1], needed[2]
        mx = needed[3] - (py * fz - pz * fy)
        my = needed[4] - (pz * fx - px * fz)
        mz = needed[5] - (px * fy - py * fx)
        lx, ly, lz = turned_back(pose, fx, fy, fz)
        inside[0], inside[1], inside[2] = -lx, -ly, -lz
        lx, ly, lz = turned_back(pose, mx, my, mz)
        inside[3], inside[4], inside[5] = -lx, -ly, -lz
        if cut < 0:
            continue
        w, more = wrenches[s], sub_models[cut]
        fx, fy, fz = turned(pose, w[0] - inside[0], w[1] - inside[1], w[2] - inside[2])
        mx, my, mz = turned(pose, w[3] - inside[3], w[4] - inside[4], w[5] - inside[5])
        more[0], more[1], more[2] = fx, fy, fz
        more[3] = mx + py * fz - pz * fy
        more[4] = my + pz * fx - px * fz
        more[5] = mz + px * fy - py * fx


@compiled
def place_contacts(contacts: Places, table: Matrix, poses: Matrix, points: Matrix) -> None:
    """Points and directions of the contacts in the base."""
    for i in range(contacts.shape[0]):
        pose, given = poses[contacts[i, 0]], table[i]
        x, y, z = turned(pose, given[0], given[1], given[2])
        points[i, 0], points[i, 1], points[i, 2] = pose[9] + x, pose[10] + y, pose[11] + z
        given[6], given[7], given[8] = turned(pose, given[3], given[4], given[5])


@compiled
def add_known(
    known: Places, table: Matrix, poses: Matrix, bodies: Matrix, sub_models: Matrix
) -> None:
    """Known wrenches: on their bodies, and no longer missing in their sub-models."""
    for i in range(known.shape[0]):
        pose, given = poses[known[i, 0]], table[i]
        fx, fy, fz = turned(pose, given[0], given[1], given[2])
        mx, my, mz = turned(pose, given[3], given[4], given[5])
        mx += pose[10] * fz - pose[11] * fy
        my += pose[11] * fx - pose[9] * fz
        mz += pose[9] * fy - pose[10] * fx
        row, rest = bodies[known[i, 0], GIVEN:END], sub_models[known[i, 1], 6:12]
        row[0], row[1], row[2] = row[0] + fx, row[1] + fy, row[2] + fz
        row[3], row[4], row[5] = row[3] + mx, row[4] + my, row[5] + mz
        rest[0], rest[1], rest[2] = rest[0] - fx, rest[1] - fy, rest[2] - fz
        rest[3], rest[4], rest[5] = rest[3] - mx, rest[4] - my, rest[5] - mz


@compiled
def begin(bodies: Matrix, plan: Places, sub_models: Matrix, found: Matrix, base: Vector) -> None:
    """Nothing given yet; missing in each sub-model: what is beyond its cut, less the next ones."""
    for i in range(bodies.shape[0]):
        for c in range(GIVEN, END):
            bodies[i, c] = 0.0
    for i in range(found.shape[0]):
        for c in range(6):
            found[i, c] = 0.0
    for c in range(6):
        base[c] = 0.0
        sub_models[0, c] = bodies[0, NEED + c]
    for s in range(plan.shape[0]):
        for c in range(6):
            sub_models[s, 6 + c] = sub_models[s, c]
    for s in range(1, plan.shape[0]):
        for c in range(6):
            sub_models[plan[s, 0], 6 + c] -= sub_models[s, c]


@compiled
def solve(
    whole: Indices,
    given: tuple[Places, Places, Indices],
    tables: tuple[Matrix, Matrix, Vector],
    poses: Matrix,
    results: tuple[Matrix, Matrix, Vector, Matrix],
) -> None:
    """Every sub-model's contacts, residual and rank."""
    plan, contacts, members = given
    table, sub_models, room = tables
    found, points, base, numbers = results
    for s in range(numbers.shape[0]):
        for c in range(7):
            numbers[s, c] = 0.0
    start = 0
    for s in range(plan.shape[0]):
        method, end, missing = plan[s, 2], plan[s, 3], sub_models[s, 6:12]
        if method == MAINSTAY:
            for c in range(6):
                base[c] = missing[c]
            numbers[s, 6] = 6.0
        elif method == WRENCH:
            shift(missing, points[members[start]], found[members[start]])
            numbers[s, 6] = 6.0
        else:
            mine = members[start:end]
            set_reference(poses[plan[s, 1]], mine, points, numbers[s])
            scratch = scratch_of(whole, room)
            solve_sub_model(
                method, mine, contacts, (points, table), missing, scratch, found, numbers[s]
            )
        start = end


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
def give(contacts: Places, points: Matrix, found: Matrix, bodies: Matrix) -> None:
    """Every contact's wrench to its body, about the origin."""
    for i in range(contacts.shape[0]):
        w, p, row = found[i], points[i], bodies[contacts[i, 0], GIVEN:END]
        row[0], row[1], row[2] = row[0] + w[0], row[1] + w[1], row[2] + w[2]
        row[3] += w[3] + p[1] * w[2] - p[2] * w[1]
        row[4] += w[4] + p[2] * w[0] - p[0] * w[2]
        row[5] += w[5] + p[0] * w[1] - p[1] * w[0]


@compiled
def torques(tree: tuple[Places, Matrix, Matrix], sub_models: Matrix, tau: Vector) -> None:
    """From the tips inwards: what each sub-tree needs less what the world gives it (eq. 10)."""
    links, bodies, poses = tree
    for i in range(bodies.shape[0] - 1, 0, -1):
        row, j, cut = bodies[i], links[i, 1], links[i, 2]
        needed, mine, above = row[NEED:GIVEN], row[GIVEN:END], bodies[links[i, 0], GIVEN:END]
        if cut > 0:  # a valid sensor knows better than the sum of what was found beyond it
            for k in range(6):
                mine[k] = sub_models[cut, k]
        for k in range(6):
            above[k] += mine[k]
        if j >= 0:
            pose = poses[i]
            nx, ny, nz = turned(pose, row[30], row[31], row[32])
            px, py, pz = pose[9], pose[10], pose[11]
            fx, fy, fz = needed[0] - mine[0], needed[1] - mine[1], needed[2] - mine[2]
            mx = needed[3] - mine[3] - (py * fz - pz * fy)
            my = needed[4] - mine[4] - (pz * fx - px * fz)
            mz = needed[5] - mine[5] - (px * fy - py * fx)
            tau[j] = nx * mx + ny * my + nz * mz


@compiled
def poses_of(q: Vector, whole: Indices, real: Vector, out: Vector) -> None:
    """Poses of all bodies into the front of `out`."""
    links, bodies, poses = tree_of(whole, real, out)
    place(q, links, bodies, poses)


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
    sensors, plan, contacts, members, known = plan_of(whole)
    source, table, given, sub_models, room = room_of(whole, real)
    if not is_finite(q, dq, ddq, wrenches, sensors, source):
        return NOT_FINITE
    tree = tree_of(whole, real, out)
    links, bodies, poses = tree
    tau, found, points, base, internal, numbers = results_of(whole, out)
    place(q, links, bodies, poses)
    base_motion(source, whole[SOURCE], (dq, ddq), tree)
    move(dq, ddq, tree)
    need(links, bodies, poses)
    at_sensors(wrenches, sensors, bodies, poses, sub_models, internal)
    begin(bodies, plan, sub_models, found, base)
    place_contacts(contacts, table, poses, points)
    add_known(known, given, poses, bodies, sub_models)
    tables, results = (table, sub_models, room), (found, points, base, numbers)
    solve(whole, (plan, contacts, members), tables, poses, results)
    give(contacts, points, found, bodies)
    torques(tree, sub_models, tau)
    return NOT_FINITE if is_strange(out[12 * whole[BODIES] :]) else DONE
