"""The estimate without a compiler: pinocchio does the recursion, numpy the rest.

The model is put on a free joint, so that the base may move and its own wrench is a result. All
sensors and contacts go through each step together: a call of numpy costs more than its arithmetic.
"""

import math
from collections.abc import Callable
from functools import partial

import numpy as np
import pinocchio as pin
from numpy.lib.stride_tricks import as_strided

from dforc.arrays import Matrix, Vector
from dforc.estimation.path import DONE, NOT_FINITE, TOO_LARGE, WRONG_SHAPE, Prepared
from dforc.estimation.plain_contacts import solve_sub_model
from dforc.estimation.plan import MAINSTAY, SUB_MODEL_NUMBERS, WRENCH, Plan
from dforc.estimation.tree_model import TreeModel
from dforc.robot_model import ModelError

GRAVITY_M_S2 = 9.81
FREE = 6  # velocities of the free joint
LARGEST = 1.0e150  # its square is still a number


class PlainPath:
    """Runs plans on one model."""

    def __init__(self, model: TreeModel) -> None:
        self._tree = model
        self._model = _on_free_joint(model)
        self._data = self._model.createData()
        self._turns, self._origins, self._forces = _views(self._data, self._model.njoints)
        self._columns = model.columns + FREE
        self._q: Vector = pin.neutral(self._model)
        self._v: Vector = np.zeros(self._model.nv)
        self._a: Vector = np.zeros(self._model.nv)
        self._q_at = model.columns + FREE + 1  # after the free joint's quaternion

    def prepare(self, plan: Plan) -> Prepared:
        """Gather the sensors and contacts of a plan into arrays."""
        motion = np.zeros(9)
        return Prepared(plan, partial(self._run, _Gathered(plan), motion), plan.layout.size, motion)

    def place(self, q_rad: Vector, out: Vector) -> None:
        """Poses of all bodies, flat."""
        self._q[self._q_at] = q_rad
        pin.forwardKinematics(self._model, self._data, self._q)
        self._write_poses(out)

    def _write_poses(self, out: Vector) -> None:
        poses = out[: 12 * self._tree.bodies].reshape(-1, 12)
        poses[:, :9].reshape(-1, 3, 3)[...] = self._turns
        poses[:, 9:] = self._origins

    def _run(
        self,
        given: "_Gathered",
        motion: Vector,
        q: Vector,
        dq: Vector,
        ddq: Vector,
        wrenches: Matrix,
        out: Vector,
    ) -> int:
        status = _check(self._tree, given, (q, dq, ddq, motion), wrenches)
        if status != DONE:
            return status
        plan, layout = given.plan, given.plan.layout
        self._q[self._q_at], self._v[self._columns], self._a[self._columns] = q, dq, ddq
        self._move_base(plan, motion)
        tau = pin.rnea(self._model, self._data, self._q, self._v, self._a)[self._columns]
        J = pin.computeJointJacobians(self._model, self._data, self._q)  # and all placements
        self._write_poses(out)
        internal = -self._forces[given.sensor_body]
        out[layout.internal] = internal.ravel()
        beyond = np.empty((len(plan.tops), 6))
        beyond[0] = self._forces[0]
        if given.cut.size:
            body = given.cut_body
            excess = (wrenches[given.cut] - internal[given.cut]).reshape(-1, 2, 3)
            # Rows times the transpose: both halves of all wrenches into base axes.
            beyond[1:] = (excess @ self._turns[body].transpose(0, 2, 1)).reshape(-1, 6)
            beyond[1:, 3:] += _cross(self._origins[body], beyond[1:, :3])
        acting = self._solve(given, beyond, out)
        if acting.size:
            tau = tau - np.einsum("jr,rj->j", given.share @ acting, J[:, self._columns])
        out[layout.tau] = tau
        results = out[layout.tau.start :]
        return DONE if math.isfinite(results.dot(results)) else TOO_LARGE

    def _move_base(self, plan: Plan, motion: Vector) -> None:
        """Velocity and acceleration of the free joint: gravity, or what the source tells."""
        self._v[:FREE] = 0.0
        self._a[:FREE] = 0.0
        if plan.source_body < 0:
            self._a[2] = GRAVITY_M_S2
            return
        pin.forwardKinematics(self._model, self._data, self._q, self._v, self._a)
        joint = plan.source_body + 1
        turn, velocity, acceleration = (
            self._turns[plan.source_body],
            self._data.v[joint],
            self._data.a[joint],
        )
        v, w = velocity.linear, velocity.angular
        # All of the source seen from the base, in base axes: a point on the body, then its frame.
        p = plan.source_point
        w_rel, dw_rel = turn @ w, turn @ acceleration.angular
        v_rel = turn @ (v + np.cross(w, p))
        classical = acceleration.linear + np.cross(w, v)
        classical = classical + np.cross(acceleration.angular, p) + np.cross(w, np.cross(w, p))
        a_rel, lever = turn @ classical, self._origins[plan.source_body] + turn @ p
        R = turn @ plan.source_turn
        omega = R @ motion[:3] - w_rel
        domega = R @ motion[3:6] - np.cross(omega, w_rel) - dw_rel
        carried = np.cross(domega, lever) + np.cross(omega, np.cross(omega, lever))
        self._a[:3] = R @ motion[6:] - carried - 2.0 * np.cross(omega, v_rel) - a_rel
        self._a[3:FREE], self._v[3:FREE] = domega, omega

    def _solve(self, given: "_Gathered", beyond: Matrix, out: Vector) -> Matrix:
        """Wrenches about the origin that act on the robot: of cuts, contacts, known ones."""
        plan, layout = given.plan, given.plan.layout
        missing = given.between @ beyond
        known = np.zeros((len(plan.known), 6))
        for row, wrench in zip(known, plan.known, strict=True):
            turned = wrench.wrench.reshape(2, 3) @ self._turns[wrench.body].T
            row[:] = turned.ravel()
            row[3:] += np.cross(self._origins[wrench.body], turned[0])
            missing[wrench.sub_model] -= row
        numbers = np.zeros((plan.layout.sensors + 1, SUB_MODEL_NUMBERS))
        numbers[: len(plan.tops), 6] = given.ranks
        found = np.zeros((len(plan.contacts), 6))
        out[layout.base] = missing[0] if plan.methods[0] == MAINSTAY else 0.0
        acting = found
        if plan.contacts:
            turns, bodies = self._turns[given.contact_body], given.contact_body
            points = self._origins[bodies] + (turns @ given.contact_point)[:, :, 0]
            found[given.whole] = missing[given.whole_sub]
            acting = found.copy()
            found[:, 3:] -= _cross(points, found[:, :3])
            if given.others:
                directions = (turns @ given.contact_direction)[:, :, 0]
                self._solve_others(given, missing, (points, directions), found, numbers)
                acting = found.copy()
                acting[:, 3:] += _cross(points, found[:, :3])
            out[layout.points] = points.ravel()
            out[layout.wrenches] = found.ravel()
        elif given.others:
            empty = np.zeros((0, 3))
            self._solve_others(given, missing, (empty, empty), found, numbers)
        out[layout.subs] = numbers.ravel()
        return np.concatenate([beyond[1:], acting, known])

    def _solve_others(
        self,
        given: "_Gathered",
        missing: Matrix,
        places: tuple[Matrix, Matrix],
        found: Matrix,
        numbers: Matrix,
    ) -> None:
        """Sub-models that are not simply one whole wrench."""
        points, directions = places
        for sub, members, unknowns in given.others:
            reference = (
                points[members].mean(axis=0) if unknowns else self._origins[given.first[sub]]
            )
            part = np.zeros((len(unknowns), 6))
            residual, rank = solve_sub_model(
                missing[sub], reference, points[members], directions[members], unknowns, part
            )
            found[members] = part
            numbers[sub, :6], numbers[sub, 6] = residual, rank


class _Gathered:
    """A plan's sensors and contacts as arrays for numpy."""

    def __init__(self, plan: Plan) -> None:
        model, contacts = plan.model, plan.contacts
        subs = range(len(plan.tops))
        self.plan = plan
        self.sensor_body = np.array(model.sensor_body, dtype=np.intp)
        self.cut = np.array(plan.tops[1:], dtype=np.intp)
        self.cut_body = self.sensor_body[self.cut]
        self.first = [0, *self.cut_body.tolist()]
        self.between = np.eye(len(plan.tops))
        for sub in subs[1:]:
            self.between[plan.above(sub), sub] = -1.0
        self.contact_body = np.array([c.body for c in contacts], dtype=np.intp)
        self.contact_point = np.array([c.point for c in contacts]).reshape(-1, 3, 1)
        self.contact_direction = np.array([c.direction for c in contacts]).reshape(-1, 3, 1)
        whole = [sub for sub in subs if plan.methods[sub] == WRENCH]
        self.whole = np.array([plan.members(sub)[0] for sub in whole], dtype=np.intp)
        self.whole_sub = np.array(whole, dtype=np.intp)
        self.ranks = [6.0 if plan.methods[sub] in (MAINSTAY, WRENCH) else 0.0 for sub in subs]
        self.others = [
            (sub, list(members), tuple(contacts[i].unknowns for i in members))
            for sub in subs
            if plan.methods[sub] not in (MAINSTAY, WRENCH)
            for members in [plan.members(sub)]
        ]
        self.share = self._share(plan)

    @staticmethod
    def _share(plan: Plan) -> Matrix:
        """(n, cuts + contacts + known): 1 where a wrench comes in between a joint and its cuts."""
        model = plan.model
        columns = []
        for sub in range(1, len(plan.tops)):
            body = model.sensor_body[plan.tops[sub]]
            columns.append(_carriers(plan, int(model.parent[body])))
        columns += [_carriers(plan, contact.body) for contact in plan.contacts]
        columns += [_carriers(plan, wrench.body) for wrench in plan.known]
        return np.array(columns).reshape(-1, model.n).T.copy()


def _carriers(plan: Plan, body: int) -> Vector:
    """(n,): 1 for the joints from a body inwards to the next cut."""
    model, carriers = plan.model, np.zeros(plan.model.n)
    inside = [
        plan.sub_model_of_body[b] == plan.sub_model_of_body[body] for b in model.body_of_joint
    ]
    carriers[inside] = model.carries[inside, body]
    return carriers


def _check(tree: TreeModel, given: _Gathered, numbers: tuple[Vector, ...], wrenches: Matrix) -> int:
    if any(vector.shape != (tree.n,) for vector in numbers[:3]) or wrenches.shape != (tree.m, 6):
        return WRONG_SHAPE
    read = wrenches.ravel() if len(given.cut) == tree.m else wrenches[given.cut].ravel()
    size = read.dot(read) + sum(vector.dot(vector) for vector in numbers)
    return DONE if size < LARGEST * LARGEST else NOT_FINITE


def _cross(a: Matrix, b: Matrix) -> Matrix:
    """Row by row; numpy's own takes ten times as long for so few."""
    crossed: Matrix = (b[:, None, :] @ (a @ CROSS).reshape(-1, 3, 3))[:, 0, :]
    return crossed


def _cross_table() -> Matrix:
    """(a x b)_j = sum of a_k b_i table[k, i, j], as (3, 9)."""
    table = np.zeros((3, 3, 3))
    for k, i, j in ((0, 1, 2), (1, 2, 0), (2, 0, 1)):
        table[k, i, j], table[i, k, j] = 1.0, -1.0
    return table.reshape(3, 9)


CROSS = _cross_table()


def _on_free_joint(tree: TreeModel) -> "pin.Model":
    """The model with its base on a free joint and without gravity: the base's motion brings it."""
    free = pin.Model()
    free.addJoint(0, pin.JointModelFreeFlyer(), pin.SE3.Identity(), "base")
    frame = pin.Frame("base", 1, 0, pin.SE3.Identity(), pin.FrameType.BODY)
    model = pin.appendModel(free, tree.pin_model, free.addFrame(frame), pin.SE3.Identity())
    model.gravity.setZero()
    return model


def _views(data: "pin.Data", joints: int) -> tuple[Matrix, Matrix, Matrix]:
    """Rotations, origins and wrenches of all bodies: live, as pinocchio keeps them in one piece."""
    return (
        _in_one(lambda i: data.oMi[i].rotation, joints),
        _in_one(lambda i: data.oMi[i].translation, joints),
        _in_one(lambda i: data.f[i].vector, joints),
    )


def _in_one(element: Callable[[int], Matrix], joints: int) -> Matrix:
    """Views of the joints 1, 2, ... as one array.

    Raises:
        ModelError: pinocchio does not keep them at equal distances.
    """
    parts = [element(i) for i in range(1, joints)]
    starts = [part.__array_interface__["data"][0] for part in parts]
    step = starts[1] - starts[0] if len(starts) > 1 else 0
    if starts != list(range(starts[0], starts[0] + step * len(starts), step or 1))[: len(starts)]:
        raise ModelError("this pinocchio does not keep its results in one piece")
    strides = (step, *parts[0].strides)
    return as_strided(parts[0], (len(parts), *parts[0].shape), strides)
