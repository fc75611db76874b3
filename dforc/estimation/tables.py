"""The flat tables that the compiled pass reads: whole numbers, and real ones with room to work.

An array costs a tenth of a microsecond to hand over, so there are two, whatever they hold.
"""

import numpy as np

from dforc.arrays import Vector
from dforc.estimation.plan import Plan
from dforc.estimation.tree_model import Indices, TreeModel

# Turn at rest, by sine, by cosine (9 each), origin, axis, mass, centre, inertia (6): 43 constants;
# then room for what kernel.py works out.
BODY_NUMBERS = 64
SOURCE_NUMBERS, SOURCE_CONSTANTS = 21, 12
ROOM = 54


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
        sub_of_sensor = {sensor: sub for sub, sensor in enumerate(plan.tops)}
        cuts = [sub_of_sensor.get(sensor, -1) for sensor in range(model.m)]
        begins = np.full(model.bodies, -1)
        begins[[model.sensor_body[sensor] for sensor in plan.tops[1:]]] = range(1, subs)
        unknowns = max(plan.unknowns(sub) for sub in range(subs))
        header = [model.bodies, model.n, model.m, len(contacts), subs, len(plan.known)]
        listed = [i for m in members for i in m]
        parts = (
            [*header, plan.source_body, unknowns],
            np.column_stack([model.parent, model.joint, begins]),
            [*zip(model.sensor_body, cuts, strict=True)],
            [
                *zip(
                    [0, *(plan.above(sub) for sub in range(1, subs))],
                    [0, *(model.sensor_body[sensor] for sensor in plan.tops[1:])],
                    plan.methods,
                    np.cumsum([len(m) for m in members]).tolist(),
                    strict=True,
                )
            ],
            [(c.body, c.unknowns) for c in contacts],
            listed + [0] * (len(contacts) - len(listed)),
            [(k.body, k.sub_model) for k in plan.known],
        )
        self.whole: Indices = np.concatenate([np.array(p, dtype=np.int64).ravel() for p in parts])
        source = np.concatenate([plan.source_turn.T.ravel(), plan.source_point, np.zeros(9)])
        placed = [np.concatenate([c.point, c.direction, np.zeros(3)]) for c in contacts]
        given = [k.wrench for k in plan.known]
        room = np.zeros(12 * subs + 6 * unknowns + ROOM)
        self.real: Vector = np.concatenate([bodies, source, *placed, *given, room])
        end = bodies.size + SOURCE_NUMBERS
        self.motion = self.real[end - SOURCE_NUMBERS + SOURCE_CONSTANTS : end]
