"""The same problem as anybody would write it: CasADi with its own derivatives, and a stock solver.

It certifies what is reachable and what is not, and is the reference that times are compared with.
"""

from enum import StrEnum

import casadi as ca
import numpy as np

from services.experiments.ik.arm import BETA, TOLERANCE_M, Arm, Array

UNIT = 1e-30  # keeps derivatives of the square root finite where an angle is zero


class Form(StrEnum):
    """How the position is asked for."""

    SQUARED = "eq.11"  # |x|^2 <= eps
    EXACT = "x = 0"  # three equations
    NEAREST = "nearest"  # min |x|^2, whatever the orientation


Option = str | float | bool
IPOPT: dict[str, Option] = {
    "print_level": 0,
    "sb": "yes",
    "tol": 1e-6,
    "mu_strategy": "adaptive",
    "max_iter": 200,
}
FATROP: dict[str, Option] = {"print_level": 0, "tol": 1e-6, "max_iter": 200}


class PlainNlp:
    """One form of the problem for one tip of an arm, by one of CasADi's solvers."""

    def __init__(self, arm: Arm, form: Form, plugin: str = "ipopt", tip: int = 0) -> None:
        """Build it: seconds the first time, because of exact second derivatives."""
        n = arm.n
        q, p = ca.SX.sym("q", n), ca.SX.sym("p", 12)
        R, position = _forward(arm, q, tip)
        x = position - p[:3]
        away = q - ca.DM(arm.rest)
        posture = ca.dot(ca.DM(arm.weights), away * away)
        cost = _squared_angle(R @ ca.reshape(p[3:], 3, 3).T) + BETA * posture
        rows = ca.DM(arm.A) @ q
        self._lower, self._upper = arm.lower, arm.upper
        g, low, high = rows, arm.row_lower, arm.row_upper
        equality = [False] * len(low)
        if form is Form.SQUARED:
            g = ca.vertcat(ca.sumsqr(x), rows)
            low, high = np.append(-np.inf, low), np.append(TOLERANCE_M**2, high)
            equality = [False, *equality]
        elif form is Form.EXACT:
            g = ca.vertcat(x, rows)
            low, high = np.append(np.zeros(3), low), np.append(np.zeros(3), high)
            equality = [True] * 3 + equality
        else:
            cost = 1e4 * ca.sumsqr(x) + 1e-4 * posture  # the last term picks one of many
        self._g_lower, self._g_upper = low, high
        options: dict[str, Option | dict[str, Option] | list[bool]] = {
            "print_time": False,
            "error_on_fail": False,
        }
        if plugin == "ipopt":
            options["ipopt"] = IPOPT
        else:
            options |= {"fatrop": FATROP, "structure_detection": "none", "equality": equality}
        self._call = ca.nlpsol("plain", plugin, {"x": q, "p": p, "f": cost, "g": g}, options)

    def solve(self, position: Array, rotation: Array, q0: Array) -> Array:
        """Where the solver stops (n,), good or not."""
        found = self._call(
            x0=q0,
            p=np.concatenate([position, rotation.flatten("F")]),
            lbx=self._lower,
            ubx=self._upper,
            lbg=self._g_lower,
            ubg=self._g_upper,
        )
        q: Array = np.asarray(found["x"]).ravel()
        return q


def _forward(arm: Arm, q: ca.SX, tip: int) -> tuple[ca.SX, ca.SX]:
    R, p = ca.SX.eye(3), ca.SX.zeros(3, 1)
    for link in arm.chain(tip):
        p = p + R @ ca.DM(link.p)
        R = R @ ca.DM(link.R)
        if link.joint >= 0:
            R = R @ _turn(ca.DM(link.axis), q[link.joint])
    return R, p


def _turn(axis: ca.DM, angle: ca.SX) -> ca.SX:
    K = ca.skew(axis)
    return ca.SX.eye(3) + ca.sin(angle) * K + (1 - ca.cos(angle)) * (K @ K)


def _squared_angle(M: ca.SX) -> ca.SX:
    v = 0.5 * ca.vertcat(M[2, 1] - M[1, 2], M[0, 2] - M[2, 0], M[1, 0] - M[0, 1])
    return ca.atan2(ca.sqrt(ca.sumsqr(v) + UNIT), 0.5 * (ca.trace(M) - 1)) ** 2
