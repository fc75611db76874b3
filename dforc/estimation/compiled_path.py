"""The estimate through numba: compiled once, from then on one call per tick."""

from functools import partial

import numpy as np

from dforc.arrays import Vector
from dforc.compiled import seal
from dforc.estimation.assumption import Assumption
from dforc.estimation.kernel_estimate import estimate, poses_of
from dforc.estimation.path import Prepared
from dforc.estimation.plan import Plan, make_plan
from dforc.estimation.tables import Tables, body_table
from dforc.estimation.tree_model import TreeModel


class CompiledPath:
    """Runs plans on one model. Compiles when it is made, so that no tick waits for it."""

    def __init__(self, model: TreeModel) -> None:
        self._bodies = body_table(model)
        nothing = make_plan(model, Assumption(), [False] * model.m)
        self._tables = Tables(nothing, self._bodies)
        still, out = np.zeros(model.n), np.zeros(nothing.layout.size)
        self.prepare(nothing).run(still, still, still, np.zeros((model.m, 6)), out)
        self.place(still, out)
        seal(estimate)
        seal(poses_of)

    def prepare(self, plan: Plan) -> Prepared:
        """Lay out the tables of a plan."""
        tables = Tables(plan, self._bodies)
        run = partial(estimate, tables.whole, tables.real)
        return Prepared(plan, run, plan.layout.size, plan.source_body >= 0, tables.motion)

    def place(self, q_rad: Vector, out: Vector) -> None:
        """Poses of all bodies, flat."""
        poses_of(q_rad, self._tables.whole, self._tables.real, out)
