"""A search with constraints that are plugged in: kernel_search's, with h(q) >= 0 beside the rest.

They enter as max(0, lambda - rho h)^2 / (2 rho), as the conditions of a pose do. Their derivative
is the plug-in's own, their curvature comes by differences of it. The steps are still compiled; the
loop is not, because a plug-in is any Python object.
"""

from dataclasses import dataclass, field

import numpy as np

from dforc.arrays import Vector
from dforc.ik.kernel_cost import Chains, Geometry, Goal, Multipliers, cost, expand
from dforc.ik.kernel_search import (
    KEPT_SHARE,
    NOISE_RAD,
    SETTLED_RAD,
    SHORT_RAD,
    STUCK_SHARE,
    begin,
    missed,
    press,
)
from dforc.ik.kernel_step import (
    ARMIJO,
    HALVINGS,
    ROUNDING,
    SHIFT_GROWTH,
    Limits,
    Room,
    confine,
    finite_length,
    newton_step,
)
from dforc.ik.problem import ExtraConstraints

RHO = 1e5
INSIDE = 1e-7  # h is kept this far above zero, for rounding
KEPT = 5e-7
DIFFERENCE_RAD = 1e-6


@dataclass(slots=True)
class PluggedSearch:
    """One search."""

    chains: Chains
    goal: Goal
    limits: Limits
    multipliers: Multipliers
    geometry: Geometry
    room: Room
    extra: ExtraConstraints
    pressures: Vector = field(init=False)  # lambda (m,)

    def run(self, q: Vector, budget: int) -> tuple[bool, int]:
        """From q to the answer, in place. Whether it is one, and after how many iterations."""
        begin(self.limits, self.multipliers, self.room)
        self.pressures = np.zeros(self.extra.size)
        f, room = len(self.limits.free), self.room
        before, stuck, failed, shift = np.inf, 0, 0, 0.0
        short, settled, gauss, met = False, f == 0, True, False
        for iteration in range(1, budget + 1):
            value = self._expand(q)
            off = missed(self.goal, self.geometry)
            h = self.extra.evaluate(q)[0] - INSIDE
            pressures = np.maximum(0.0, self.pressures - RHO * h)
            # Kept, and pressed on by nothing where there is room.
            kept = bool((np.abs(pressures - self.pressures) <= RHO * KEPT).all())
            met = met or (kept and off <= KEPT_SHARE)
            if settled and kept and (off <= KEPT_SHARE or f == 0):
                return True, iteration
            if f == 0:
                return False, iteration
            if (short or settled) and not (off <= KEPT_SHARE and kept):
                short, settled = False, False
                self.pressures = pressures
                if off > KEPT_SHARE:
                    stuck = stuck + 1 if off > STUCK_SHARE * before else 0
                    before = off
                    press(self.goal, self.multipliers, self.geometry, stuck, met)
                continue
            confine(q, self.limits, room)
            shift = newton_step(room, f, gauss, shift / (SHIFT_GROWTH * SHIFT_GROWTH))
            if shift == np.inf:
                return False, iteration
            longest = finite_length(room.dq, f)
            settled = longest <= SETTLED_RAD
            share = self._walk(q, value)
            gauss = gauss if share == 1.0 else not gauss
            failed = failed + 1 if share == 0.0 else 0
            if failed > 0 and longest <= NOISE_RAD:
                settled = True
            elif failed > 1:
                return False, iteration
            short = longest <= SHORT_RAD
        return False, budget

    def _expand(self, q: Vector) -> float:
        """Cost, gradient and Hessian with the plugged-in constraints."""
        free, room = self.limits.free, self.room
        value = expand(
            q,
            self.chains,
            self.goal,
            self.multipliers,
            self.geometry,
            free,
            self.limits.slots,
            room.g,
            room.H,
            room.B,
        )
        h, J = self.extra.evaluate(q)
        push = np.maximum(0.0, self.pressures - RHO * (h - INSIDE))
        pressed = push > 0.0
        if pressed.any():
            N = J[pressed][:, free]
            room.g[:] -= push[pressed] @ N
            room.H[:] += np.tril(RHO * (N.T @ N))
            curved = np.empty((len(free), len(free)))
            for row, joint in enumerate(free):
                ahead = q.copy()
                ahead[joint] += DIFFERENCE_RAD
                change = (J - self.extra.evaluate(ahead)[1])[pressed][:, free]
                curved[row] = push[pressed] @ change / DIFFERENCE_RAD
            room.B[:] += np.tril(0.5 * (curved + curved.T))
        return value + float(push @ push) / (2.0 * RHO)

    def _cost(self, q: Vector) -> float:
        push = np.maximum(0.0, self.pressures - RHO * (self.extra.evaluate(q)[0] - INSIDE))
        value = cost(q, self.chains, self.goal, self.multipliers, self.geometry)
        return value + float(push @ push) / (2.0 * RHO)

    def _walk(self, q: Vector, value: float) -> float:
        """Go along the step as far as the cost falls. The share that was gone."""
        limits, room = self.limits, self.room
        slope = float(room.g @ room.dq)
        share = 1.0
        for _ in range(HALVINGS):
            there = q.copy()
            there[limits.free] += share * room.dq
            n = len(q)
            there = np.minimum(np.maximum(there, limits.lower[:n]), limits.upper[:n])
            slack = ROUNDING * (1.0 + abs(value))
            if self._cost(there) <= value + ARMIJO * share * slope + slack:
                q[:] = there
                return share
            share *= 0.5
        return 0.0
