"""IPOPT on a reaching problem: built once, called with numbers."""

from dataclasses import dataclass

import casadi as ca

from dforc.arrays import Vector
from dforc.symbolic.buffered import BufferedFunction
from dforc.symbolic.reaching import Problem

Option = bool | float | str

# Measured on 300 random reachable poses from the rest posture: adaptive mu halves the iterations
# of the monotone rule on the squared position constraint (22 against 46); no second-order
# correction shortens the tail, and the multiplier rule that of unreachable poses; skipping the
# residual check of each small linear solve saves a tenth.
IPOPT_OPTIONS: dict[str, Option] = {
    "print_level": 0,
    "sb": "yes",
    "tol": 1e-6,
    "constr_viol_tol": 1e-9,
    "bound_relax_factor": 0.0,
    "nlp_scaling_method": "none",
    "fast_step_computation": "yes",
    "mu_strategy": "adaptive",
    "max_soc": 0,
    "alpha_for_y": "bound-mult",
}
SOLVED = frozenset({"Solve_Succeeded", "Solved_To_Acceptable_Level"})
CAPPED = "Maximum_Iterations_Exceeded"


@dataclass(frozen=True, slots=True, eq=False)
class Bounds:
    """Ranges of the variables (n,) and of the constraints (m,)."""

    lower: Vector
    upper: Vector
    g_lower: Vector
    g_upper: Vector


@dataclass(frozen=True, slots=True, eq=False)
class IpoptAnswer:
    """Where IPOPT stopped. Multipliers are positive at upper bounds and negative at lower ones."""

    q: Vector  # (n,)
    bound_multipliers: Vector  # (n,)
    row_multipliers: Vector  # (m,)
    solved: bool
    capped: bool
    iterations: int


class IpoptSolver:
    """One problem."""

    def __init__(self, name: str, problem: Problem, iteration_cap: int) -> None:
        options: dict[str, Option | dict[str, Option] | ca.Function] = {
            "print_time": False,
            "record_time": False,
            "calc_lam_p": False,
            "calc_f": False,
            "calc_g": False,
            "no_nlp_grad": True,
            "error_on_fail": False,
            "ipopt": {**IPOPT_OPTIONS, "max_iter": iteration_cap},
            **problem.options,
        }
        self._call = BufferedFunction(ca.nlpsol(name, "ipopt", problem.nlp, options))

    def solve(self, q_start: Vector, parameters: Vector, bounds: Bounds) -> IpoptAnswer:
        """Run from q_start (n,) with the parameter vector of dforc.symbolic.reaching."""
        given = self._call.inputs
        given["x0"][:] = q_start
        given["p"][:] = parameters
        given["lbx"][:] = bounds.lower
        given["ubx"][:] = bounds.upper
        given["lbg"][:] = bounds.g_lower
        given["ubg"][:] = bounds.g_upper
        self._call.run()
        found = self._call.outputs
        statistics = self._call.statistics()
        status = str(statistics["return_status"])
        return IpoptAnswer(
            q=found["x"].copy(),
            bound_multipliers=found["lam_x"].copy(),
            row_multipliers=found["lam_g"].copy(),
            solved=status in SOLVED,
            capped=status == CAPPED,
            iterations=int(str(statistics["iter_count"])),
        )
