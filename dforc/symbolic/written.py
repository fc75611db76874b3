"""A program as a CasADi function that differentiates to the written-out gradient and Hessian.

Solvers other than IPOPT take no derivatives: they have CasADi make them, and it makes a Hessian
three times as long. CasADi first looks for the derivatives of a called function in that function's
cache; the ones of this program are put there. Should a version of CasADi ask for others, it makes
its own, and only time is lost.
"""

from collections.abc import Mapping
from typing import TypeAlias

import casadi as ca

from dforc.symbolic.program import Program

Option: TypeAlias = "bool | int | float | str | ca.Function | Mapping[str, Option]"

NAME = "program"
REVERSE = f"adj1_{NAME}"  # CasADi's name for the gradient of a weighted sum of the results
Z, P, FACTOR, MULTIPLIERS, DIRECTIONS = 0, 1, 4, 5, 8  # arguments of it, and of its derivative


class WrittenFunction:
    """The function. CasADi's caches keep nothing alive: this does, until the solvers are made."""

    def __init__(self, program: Program) -> None:
        self._kept: list[ca.Function] = []
        cache = self._derivatives(program)
        self.function = _wrapped(_called(program, cache))

    def _derivatives(self, program: Program) -> dict[str, ca.Function]:
        """Gradient and Hessian in the form, and of the names, that CasADi has for its own."""
        plain = _called(program, {})
        hessian = _wrapped(plain).factory(
            "hessian",
            ["x", "p", "lam:f", "lam:g"],
            ["grad:gamma:x", "hess:gamma:x:x"],
            {"gamma": ["f", "g"]},
        )
        own = plain.cache().get(REVERSE)
        if own is None:
            return {}
        along: dict[str, ca.Function] = {}
        for name, like in own.cache().items():
            directions = ca.SX.sym("directions", *like.size_in(DIRECTIONS))
            along[name] = _like(like, program, program.hessian @ directions, directions)
        gradient = program.factor * program.gradient + program.jacobian.T @ program.multipliers
        reverse = _like(own, program, gradient, None, along)
        self._kept = [hessian, *along.values(), reverse]
        return {REVERSE: reverse}


def _like(
    model: ca.Function,
    program: Program,
    result: ca.SX,
    directions: ca.SX | None,
    cache: Mapping[str, ca.Function] | None = None,
) -> ca.Function:
    """A function of the model's form with another first result, the derivative by z.

    That by p, which no solver needs, is zero.
    """
    arguments = [ca.SX.sym(model.name_in(i), model.sparsity_in(i)) for i in range(model.n_in())]
    arguments[Z], arguments[P] = program.z, program.p
    arguments[FACTOR], arguments[MULTIPLIERS] = program.factor, program.multipliers
    if directions is not None:
        arguments[DIRECTIONS] = directions
    results = [ca.densify(result), ca.SX.zeros(*model.size_out(1))]
    options: dict[str, Option] = {"never_inline": True, "cache": cache or {}}
    names = model.name_in(), model.name_out()
    return ca.Function(model.name(), arguments, results, *names, options)


def _called(program: Program, cache: Mapping[str, ca.Function]) -> ca.Function:
    options: dict[str, Option] = {"never_inline": True, "cache": cache}
    results = [program.f, program.g]
    return ca.Function(NAME, [program.z, program.p], results, ["x", "p"], ["f", "g"], options)


def _wrapped(function: ca.Function) -> ca.Function:
    """The function, called from another one, which is what makes CasADi look into the cache."""
    z, p = ca.MX.sym("x", function.size1_in(0)), ca.MX.sym("p", function.size1_in(1))
    f, g = function(z, p)
    return ca.Function("nlp", [z, p], [f, g], ["x", "p"], ["f", "g"])
