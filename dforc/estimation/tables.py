"""The flat tables that the compiled pass reads: whole numbers, and real ones with room to work.

An array costs a tenth of a microsecond to hand over, so there are two, whatever they hold.
"""

import numpy as np

from dforc.arrays import Vector
from dforc.estimation.plan import Plan
from dforc.estimation.tree_model import Indices, TreeModel

BODY_NUMBERS = 43  # turn at rest, by sine, by cosine (9 each), origin, axis, mass, centre, inertia


def body_table(model: TreeModel) -> Vector:
    """Every body's constants, flat.

    A body's rotation in the one before it is E exp(angle [axis]x) = B0 + sin B1 + cos B2.
    """
    rows = np.zeros((model.bodies, BODY_NUMBERS))
    for body, row in enumerate(rows):
        E, (x, y, z) = model.R[body], model.axis[body]
        K = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
        row[0:9] = (E + E @ K @ K).ravel()
        row[9:18] = (E @ K).ravel()
        row[18:27] = (-E @ K @ K).ravel()
        row[27:30], row[30:33] = model.p[body], model.axis[body]
        row[33], row[34:37] = model.mass[body], model.centre[body]
        I = model.inertia[body]  # noqa: E741
        row[37:43] = I[0, 0], I[0, 1], I[0, 2], I[1, 1], I[1, 2], I[2, 2]
    return rows.ravel()


class Tables:
    """Both arrays of one plan, and the place for the motion of the kinematic source."""

    def __init__(self, plan: Plan, bodies: Vector) -> None:
        model, subs, contacts = plan.model, len(plan.tops), plan.contacts
        members = [plan.members(sub) for sub in range(subs)]
        ends = np.cumsum([len(m) for m in members])
        sub_of_sensor = {sensor: sub for sub, sensor in enumerate(plan.tops)}
        top_of_body = np.full(model.bodies, -1)
        for sub in range(1, subs):
            top_of_body[model.sensor_body[plan.tops[sub]]] = sub
        unknowns = max((plan.unknowns(sub) for sub in range(subs)), default=0)
        header = [model.bodies, model.n, model.m, len(contacts), subs, len(plan.known)]
        header += [plan.source_body, unknowns]
        self.whole: Indices = np.concatenate(
            [
                np.array(part, dtype=np.int64)
                for part in (
                    header,
                    model.parent,
                    model.joint,
                    top_of_body,
                    model.sensor_body,
                    [sub_of_sensor.get(sensor, -1) for sensor in range(model.m)],
                    [0, *(plan.above(sub) for sub in range(1, subs))],
                    [0, *(model.sensor_body[sensor] for sensor in plan.tops[1:])],
                    plan.methods,
                    ends,
                    [c.body for c in contacts],
                    [c.unknowns for c in contacts],
                    [i for m in members for i in m],
                    [0] * (len(contacts) - sum(len(m) for m in members)),
                    [k.body for k in plan.known],
                    [k.sub_model for k in plan.known],
                )
            ]
        )
        placed = [np.concatenate([c.point, c.direction]) for c in contacts]
        given = [k.wrench for k in plan.known]
        source = [plan.source_turn.ravel(), plan.source_point]
        constants = np.concatenate([bodies, *placed, *given, *source])
        work = 21 * model.bodies + 12 * subs + 3 * len(contacts) + 6 * unknowns + 54
        self.real: Vector = np.concatenate([constants, np.zeros(9 + work)])
        self.motion = self.real[constants.size : constants.size + 9]
