"""A plan's sensors and contacts as arrays for numpy."""

import numpy as np

from dforc.arrays import Matrix, Vector
from dforc.estimation.plan import MAINSTAY, SUB_MODEL_NUMBERS, WRENCH, Plan

FREE = 6  # velocities of the free joint


class Gathered:
    """What the plain path multiplies with in every tick."""

    def __init__(self, plan: Plan, velocities: int) -> None:
        """Lay out a plan; pinocchio's joint vector has as many velocities."""
        model, contacts = plan.model, plan.contacts
        subs = range(len(plan.tops))
        self.plan, self.layout = plan, plan.layout
        self.sub_models, self.cuts = len(subs), len(subs) - 1
        self.readings = (model.m, 6)
        self.all_valid = all(plan.valid)
        self.cut = np.array(plan.tops[1:], dtype=np.intp)
        self.sensor_body = np.array(model.sensor_body, dtype=np.intp)
        cut_body = self.sensor_body[self.cut].tolist()
        self.first = [0, *cut_body]
        self.bodies = np.array([*cut_body, *(c.body for c in contacts)], dtype=np.intp)
        # A pose has four rows: three columns of the rotation and the origin.
        origins = [(0.0, 0.0, 0.0, 1.0)] * self.cuts
        points = [*origins, *((*c.point, 1.0) for c in contacts)]
        self.points = np.array(points).reshape(-1, 4)
        self.directions = np.array([[*c.direction, 0.0] for c in contacts]).reshape(-1, 4)
        self.between = np.eye(len(subs))  # from beyond each cut to what is missing in between
        for sub in subs[1:]:
            self.between[plan.above(sub), sub] = -1.0
        self.whole = np.zeros((len(contacts), len(subs)))  # the single whole wrenches
        numbers = np.zeros((model.m + 1, SUB_MODEL_NUMBERS))
        self.others: list[tuple[int, list[int], tuple[int, ...]]] = []
        for sub in subs:
            members = list(plan.members(sub))
            if plan.methods[sub] in (MAINSTAY, WRENCH):
                numbers[sub, 6] = 6.0
                if plan.methods[sub] == WRENCH:
                    self.whole[members[0], sub] = 1.0
            else:
                unknowns = tuple(contacts[i].unknowns for i in members)
                self.others.append((sub, members, unknowns))
        # From the forces beyond each cut to those of the cuts and the single whole wrenches.
        self.forces = np.vstack([np.eye(len(subs))[1:], self.whole @ self.between])
        self.numbers: Vector = numbers.ravel()
        self.share = _share(plan, velocities)
        # Without least squares and known wrenches everything is one product.
        self.simple = not self.others and not plan.known
        cuts, found = self.share[:, : self.cuts], self.share[:, self.cuts :][:, : len(contacts)]
        found_from = self.whole @ self.between
        of_joints = np.hstack([np.zeros((velocities, 1)), cuts]) + found @ found_from
        held = plan.methods[0] == MAINSTAY
        self.at_once = np.vstack([of_joints, found_from, self.between[:1] * held])


def _share(plan: Plan, velocities: int) -> Matrix:
    """1 where a wrench of a cut, a contact or a known one comes between a joint and its cuts."""
    model = plan.model
    bodies = [int(model.parent[model.sensor_body[sensor]]) for sensor in plan.tops[1:]]
    bodies += [c.body for c in plan.contacts] + [k.body for k in plan.known]
    share = np.zeros((velocities, len(bodies)))
    for column, body in enumerate(bodies):
        share[model.columns + FREE, column] = _carriers(plan, body)
    return share


def _carriers(plan: Plan, body: int) -> Vector:
    """(n,): 1 for the joints from a body inwards to the next cut."""
    model, own = plan.model, plan.sub_model_of_body[body]
    inside = np.array([plan.sub_model_of_body[b] == own for b in model.body_of_joint])
    carriers: Vector = np.where(inside, model.carries[:, body], 0.0)
    return carriers
