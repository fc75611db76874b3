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
from dforc.estimation.path import DONE, NOT_FINITE, WRONG_SHAPE, Prepared
from dforc.estimation.plain_contacts import solve_sub_model
from dforc.estimation.plain_plan import FREE, Gathered
from dforc.estimation.plan import GRAVITY_M_S2, MAINSTAY, Plan
from dforc.estimation.tree_model import TreeModel
from dforc.robot_model import ModelError

FREE_JOINT = "free joint under the base"  # no name that a URDF would have


class PlainPath:
    """Runs plans on one model."""

    def __init__(self, model: TreeModel) -> None:
        self._tree = model
        self._model = _on_free_joint(model)
        self._data = self._model.createData()
        joints = self._model.njoints
        # Live, of the bodies: three columns of the rotation and the origin; wrenches.
        self._poses = _in_one(lambda i: self._data.oMi[i].rotation, joints, (4, 3), (24, 8))
        self._forces = _in_one(lambda i: self._data.f[i].vector, joints, (6,), (8,))
        self._columns = model.columns + FREE
        self._q: Vector = pin.neutral(self._model)
        self._v: Vector = np.zeros(self._model.nv)
        self._a: Vector = np.zeros(self._model.nv)
        self._q_at = model.columns + FREE + 1  # after the free joint's quaternion

    def prepare(self, plan: Plan) -> Prepared:
        """Gather the sensors and contacts of a plan into arrays."""
        motion = np.zeros(9)
        run = partial(self._run, Gathered(plan, self._model.nv), motion)
        return Prepared(plan, run, plan.layout.size, plan.source_body >= 0, motion)

    def place(self, q_rad: Vector, out: Vector) -> None:
        """Poses of all bodies, flat."""
        self._q[self._q_at] = q_rad
        pin.forwardKinematics(self._model, self._data, self._q)
        out[: self._poses.size] = self._poses.ravel()

    @np.errstate(all="ignore")  # NaN and overflow go through to the results, where they are found
    def _run(
        self,
        given: Gathered,
        motion: Vector,
        q: Vector,
        dq: Vector,
        ddq: Vector,
        wrenches: Matrix,
        out: Vector,
    ) -> int:
        size = (self._tree.n,)
        if (q.shape, dq.shape, ddq.shape, wrenches.shape) != (size, size, size, given.readings):
            return WRONG_SHAPE
        self._q[self._q_at], self._v[self._columns], self._a[self._columns] = q, dq, ddq
        self._move_base(given.plan, motion)
        tau = pin.rnea(self._model, self._data, self._q, self._v, self._a)
        J = pin.computeJointJacobians(self._model, self._data, self._q)  # and all placements
        out[: self._poses.size] = self._poses.ravel()
        forces = self._forces[given.sensor_body]
        out[given.layout.internal] = -forces.ravel()
        excess = wrenches + forces
        acting = self._contacts(given, excess if given.all_valid else excess[given.cut], out)
        tau = tau - np.vecdot(acting, J.T)
        out[given.layout.tau] = tau[self._columns]
        # Every input that counts is in the results, so this finds its NaN too.
        results = out[given.layout.tau.start :]
        return DONE if math.isfinite(results.dot(results)) else NOT_FINITE

    def _contacts(self, given: Gathered, excess: Matrix, out: Vector) -> Matrix:
        """Contacts and residuals into `out`; what the world gives each joint, about the origin."""
        plan, layout, cuts = given.plan, given.layout, given.cuts
        poses = self._poses[given.bodies]  # of valid sensors, then of contacts
        points = np.vecmat(given.points, poses)
        beyond = np.empty((given.sub_models, 2, 3))
        beyond[0] = self._forces[0].reshape(2, 3)
        # Rows times the transposed rotation: both halves of all wrenches into base axes.
        beyond[1:] = excess.reshape(-1, 2, 3) @ poses[:cuts, :3]
        # All moments from one product: p x f of the sensors, P x F of the contacts.
        levers = _cross(points, given.forces @ beyond[:, 0])
        beyond[1:, 1] += levers[:cuts]
        wrenches = beyond.reshape(-1, 6)
        if given.simple:
            results = given.at_once @ wrenches  # of joints, contacts and the base
            found = results[self._model.nv : -1]
            found[:, 3:] -= levers[cuts:]
            out[layout.points], out[layout.wrenches] = points[cuts:].ravel(), found.ravel()
            out[layout.base], out[layout.subs] = results[-1], given.numbers
            of_joints: Matrix = results[: self._model.nv]
            return of_joints
        missing = given.between @ wrenches
        known = self._known(plan, missing)
        out[layout.base] = missing[0] if plan.methods[0] == MAINSTAY else 0.0
        acting = self._solve_others(given, missing, points[cuts:], out)
        given_to_joints: Matrix = given.share @ np.concatenate([wrenches[1:], acting, known])
        return given_to_joints

    def _solve_others(
        self, given: Gathered, missing: Matrix, points: Matrix, out: Vector
    ) -> Matrix:
        """Sub-models that are not simply one whole wrench. Returns wrenches about the origin."""
        layout = given.layout
        directions = np.vecmat(given.directions, self._poses[given.bodies[given.cuts :]])
        found = given.whole @ missing
        found[:, 3:] -= _cross(points, found[:, :3])
        numbers = given.numbers.reshape(layout.sensors + 1, -1).copy()
        for sub, members, unknowns in given.others:
            first = self._poses[given.first[sub], 3]
            reference = points[members].mean(axis=0) if members else first
            part = np.zeros((len(members), 6))
            numbers[sub, :6], numbers[sub, 6] = solve_sub_model(
                missing[sub], reference, points[members], directions[members], unknowns, part
            )
            found[members] = part
        out[layout.points], out[layout.wrenches] = points.ravel(), found.ravel()
        out[layout.subs] = numbers.ravel()
        acting = found.copy()
        acting[:, 3:] += _cross(points, found[:, :3])
        return acting

    def _known(self, plan: Plan, missing: Matrix) -> Matrix:
        """Known wrenches about the origin; they are no longer missing."""
        known = np.empty((len(plan.known), 6))
        for row, wrench in zip(known, plan.known, strict=True):
            pose = self._poses[wrench.body]
            row[:] = (wrench.wrench.reshape(2, 3) @ pose[:3]).ravel()
            row[3:] += np.cross(pose[3], row[:3])
            missing[wrench.sub_model] -= row
        return known

    def _move_base(self, plan: Plan, motion: Vector) -> None:
        """Velocity and acceleration of the free joint: gravity, or what the source tells."""
        if plan.source_body < 0:
            self._v[:FREE] = 0.0
            self._a[:FREE] = UPRIGHT
            return
        self._v[:FREE] = self._a[:FREE] = 0.0
        pin.forwardKinematics(self._model, self._data, self._q, self._v, self._a)
        pose, joint = self._poses[plan.source_body], plan.source_body + 1
        turn, p = pose[:3].T, plan.source_point
        velocity, acceleration = self._data.v[joint], self._data.a[joint]
        v, w = velocity.linear, velocity.angular
        # The source as the base sees it, in base axes; then the base as the source knows it.
        classical = acceleration.linear + np.cross(w, v) + np.cross(acceleration.angular, p)
        a_rel = turn @ (classical + np.cross(w, np.cross(w, p)))
        v_rel, lever = turn @ (v + np.cross(w, p)), pose[3] + turn @ p
        w_rel, dw_rel = turn @ w, turn @ acceleration.angular
        R = turn @ plan.source_turn
        omega = R @ motion[:3] - w_rel
        domega = R @ motion[3:6] - np.cross(omega, w_rel) - dw_rel
        carried = np.cross(domega, lever) + np.cross(omega, np.cross(omega, lever))
        self._a[:3] = R @ motion[6:] - carried - 2.0 * np.cross(omega, v_rel) - a_rel
        self._a[3:FREE], self._v[3:FREE] = domega, omega


def _cross(a: Matrix, b: Matrix) -> Matrix:
    """Row by row; numpy's own takes ten times as long for so few."""
    crossed: Matrix = np.vecmat(b, (a @ CROSS).reshape(-1, 3, 3))
    return crossed


def _cross_table() -> Matrix:
    """(a x b)_j = sum of a_k b_i table[k, i, j], as (3, 9)."""
    table = np.zeros((3, 3, 3))
    for k, i, j in ((0, 1, 2), (1, 2, 0), (2, 0, 1)):
        table[k, i, j], table[i, k, j] = 1.0, -1.0
    return table.reshape(3, 9)


CROSS = _cross_table()
UPRIGHT = np.array([0.0, 0.0, GRAVITY_M_S2, 0.0, 0.0, 0.0])


def _on_free_joint(tree: TreeModel) -> "pin.Model":
    """The model with its base on a free joint and without gravity: the base's motion brings it."""
    free = pin.Model()
    free.addJoint(0, pin.JointModelFreeFlyer(), pin.SE3.Identity(), FREE_JOINT)
    frame = pin.Frame(FREE_JOINT, 1, 0, pin.SE3.Identity(), pin.FrameType.BODY)
    model = pin.appendModel(free, tree.pin_model, free.addFrame(frame), pin.SE3.Identity())
    model.gravity.setZero()
    return model


def _in_one(
    element: Callable[[int], Matrix], joints: int, shape: tuple[int, ...], inner: tuple[int, ...]
) -> Matrix:
    """What pinocchio keeps for the joints 1, 2, ... as one array, without copying.

    Raises:
        ModelError: this pinocchio keeps it in another way.
    """
    starts = [element(i).__array_interface__["data"][0] for i in range(1, joints)]
    step = 8 * math.prod(shape)
    if starts != [starts[0] + step * i for i in range(joints - 1)]:
        raise ModelError("this pinocchio does not keep its results in one piece")
    return as_strided(element(1).reshape(-1, order="A"), (joints - 1, *shape), (step, *inner))
