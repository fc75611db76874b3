"""A program solved by an interior-point method that comes with CasADi: built once, then numbers."""

from dataclasses import dataclass
from enum import StrEnum

import casadi as ca

from dforc.arrays import Vector
from dforc.symbolic.buffered import BufferedFunction
from dforc.symbolic.program import Program
from dforc.symbolic.written import Option, WrittenFunction


class Method(StrEnum):
    """Which of them; the names are CasADi's."""

    IPOPT = "ipopt"
    FATROP = "fatrop"


class Start(StrEnum):
    """What is known of the point where a run starts."""

    ANYWHERE = "anywhere"
    NEAR = "near"  # the answer to nearly the same problem
    AT_AN_ANSWER = "at"  # the answer, but for a little


SETTINGS: dict[Method, dict[str, Option]] = {
    Method.IPOPT: {
        "print_level": 0,
        "sb": "yes",
        "tol": 1e-6,
        "constr_viol_tol": 1e-9,
        "bound_relax_factor": 0.0,
        "nlp_scaling_method": "none",
        "fast_step_computation": "yes",
        "max_soc": 0,
        "alpha_for_y": "bound-mult",
    },
    # Of 3600 searches 11 stall at 1e-6, 4 at 3e-6; looser ones leave idle joints beside rest.
    Method.FATROP: {"print_level": 0, "tolerance": 3e-6},
}
# How far the barrier is taken back at the start, and the start itself from limits.
MU = {Start.ANYWHERE: 1.0, Start.NEAR: 1e-2, Start.AT_AN_ANSWER: 1e-6}
PUSH = {Start.ANYWHERE: 1e-2, Start.NEAR: 1e-3, Start.AT_AN_ANSWER: 1e-6}
# fatrop's plug-in forgets its settings as soon as other variables are fixed than at first: there
# they keep this much room to either side.
HAIR = {Method.IPOPT: 0.0, Method.FATROP: 1e-9}
SOLVED = frozenset({"Solve_Succeeded", "Solved_To_Acceptable_Level", "0"})


@dataclass(frozen=True, slots=True, eq=False)
class Region:
    """Ranges of the variables and of the constraints."""

    lower: Vector
    upper: Vector
    g_lower: Vector
    g_upper: Vector


@dataclass(frozen=True, slots=True, eq=False)
class Ending:
    """Where a run stopped."""

    z: Vector
    solved: bool
    iterations: int


class Prepared:
    """A program in the form that a method takes, from which its solvers are built."""

    def __init__(self, program: Program, method: Method) -> None:
        """Write out the derivatives (0.1 s)."""
        self.method = method
        self.options: dict[str, Option] = {
            "print_time": False,
            "record_time": False,
            "calc_lam_p": False,
            "error_on_fail": False,
        }
        self._program = program
        self._written: WrittenFunction | None = None
        if method is Method.IPOPT:
            self.options |= {"calc_f": False, "calc_g": False, "no_nlp_grad": True}
            self.options |= _derivatives(program)
        else:
            self.options |= {"structure_detection": "none"}
            self._written = WrittenFunction(program)

    def solver(self, settings: dict[str, Option]) -> ca.Function:
        """Build one (5 to 10 ms)."""
        name, method = "reaching", self.method.value
        options: dict[str, Option] = {**self.options, method: settings}
        if self._written is not None:
            return ca.nlpsol(name, method, self._written.function, options)
        one = self._program
        nlp = {"x": one.z, "p": one.p, "f": one.f, "g": one.g}
        return ca.nlpsol(name, method, nlp, options)


class NonlinearSolver:
    """One program, one method, one cap of iterations."""

    def __init__(self, prepared: Prepared, cap: int, start: Start) -> None:
        push = PUSH[start]
        settings: dict[str, Option] = {
            **SETTINGS[prepared.method],
            "max_iter": cap,
            "mu_init": MU[start],
            "bound_push": push,
            "bound_frac": push,
        }
        self._call = BufferedFunction(prepared.solver(settings))
        self._hair = HAIR[prepared.method]

    def run(self, start: Vector, parameters: Vector, region: Region) -> Ending:
        """From a point inside the region."""
        given = self._call.inputs
        given["x0"][:] = start
        given["p"][:] = parameters
        fixed = self._hair * (region.lower == region.upper)
        given["lbx"][:] = region.lower - fixed
        given["ubx"][:] = region.upper + fixed
        given["lbg"][:] = region.g_lower
        given["ubg"][:] = region.g_upper
        self._call.run()
        statistics = self._call.statistics()
        return Ending(
            z=self._call.outputs["x"].copy(),
            solved=str(statistics["return_status"]) in SOLVED,
            iterations=int(str(statistics["iter_count"])),
        )


def _derivatives(program: Program) -> dict[str, Option]:
    """As IPOPT's plug-in takes them."""
    z, p = program.z, program.p
    return {
        "grad_f": ca.Function(
            "grad_f", [z, p], [program.f, program.gradient], ["x", "p"], ["f", "grad_f_x"]
        ),
        "jac_g": ca.Function(
            "jac_g", [z, p], [program.g, program.jacobian], ["x", "p"], ["g", "jac_g_x"]
        ),
        "hess_lag": ca.Function(
            "hess_lag",
            [z, p, program.factor, program.multipliers],
            [ca.triu(program.hessian)],
            ["x", "p", "lam_f", "lam_g"],
            ["triu_hess_gamma_x_x"],
        ),
    }
