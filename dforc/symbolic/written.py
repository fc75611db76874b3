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
Z, P, FACTOR, MULTIPLIERS = 0, 1, 4, 5  # its arguments
HESSIAN_ALONG = 8  # argument of its derivative: directions, side by side
JACOBIAN_ALONG = 4  # argument of the derivative of the program

Arguments = dict[int, ca.SX]


class WrittenFunction:
    """The function. CasADi's caches keep nothing alive: this does, until the solvers are made."""

    def __init__(self, program: Program) -> None:
        self._kept: list[ca.Function] = []
        cache = self._derivatives(program)
        self.function = _wrapped(_called(program, cache))

    def _derivatives(self, program: Program) -> dict[str, ca.Function]:
        """In the form, and of the names, that CasADi has for its own."""
        plain = _called(program, {})
        self._kept = _first_and_second(_wrapped(plain))
        own: dict[str, ca.Function] = plain.cache()
        at: Arguments = {Z: program.z, P: program.p}
        cache: dict[str, ca.Function] = {}
        for name in own.keys() - {REVERSE}:
            directions = _directions(own[name], JACOBIAN_ALONG)
            results = [program.gradient.T @ directions, program.jacobian @ directions]
            cache[name] = _like(own[name], at | {JACOBIAN_ALONG: directions}, results)
        if REVERSE in own:
            cache[REVERSE] = self._reverse(own[REVERSE], program, at)
        self._kept += cache.values()
        return cache

    def _reverse(self, own: ca.Function, program: Program, at: Arguments) -> ca.Function:
        at = at | {FACTOR: program.factor, MULTIPLIERS: program.multipliers}
        cache: dict[str, ca.Function] = {}
        for name, like in own.cache().items():
            directions = _directions(like, HESSIAN_ALONG)
            result = program.hessian @ directions
            cache[name] = _like(like, at | {HESSIAN_ALONG: directions}, [result])
        self._kept += cache.values()
        gradient = program.factor * program.gradient + program.jacobian.T @ program.multipliers
        return _like(own, at, [gradient], cache)


def _first_and_second(wrapped: ca.Function) -> list[ca.Function]:
    """The derivatives that a solver will ask for, as CasADi makes them."""
    hessian = wrapped.factory(
        "hessian",
        ["x", "p", "lam:f", "lam:g"],
        ["grad:gamma:x", "hess:gamma:x:x"],
        {"gamma": ["f", "g"]},
    )
    return [hessian, wrapped.factory("jacobian", ["x", "p"], ["g", "jac:g:x"])]


def _directions(model: ca.Function, argument: int) -> ca.SX:
    return ca.SX.sym("directions", *model.size_in(argument))


def _like(
    model: ca.Function,
    known: Arguments,
    results: list[ca.SX],
    cache: Mapping[str, ca.Function] | None = None,
) -> ca.Function:
    """A function of the model's form with other first results; the derivatives by p are zero.

    No solver needs these.
    """
    given = [ca.SX.sym(model.name_in(i), model.sparsity_in(i)) for i in range(model.n_in())]
    for argument, symbol in known.items():
        given[argument] = symbol
    found = [ca.densify(result) for result in results]
    found += [ca.SX.zeros(*model.size_out(i)) for i in range(len(found), model.n_out())]
    options: dict[str, Option] = {"never_inline": True, "cache": cache or {}}
    return ca.Function(model.name(), given, found, model.name_in(), model.name_out(), options)


def _called(program: Program, cache: Mapping[str, ca.Function]) -> ca.Function:
    options: dict[str, Option] = {"never_inline": True, "cache": cache}
    results = [program.f, program.g]
    return ca.Function(NAME, [program.z, program.p], results, ["x", "p"], ["f", "g"], options)


def _wrapped(function: ca.Function) -> ca.Function:
    """The function, called from another one, which is what makes CasADi look into the cache."""
    z, p = ca.MX.sym("x", function.size1_in(0)), ca.MX.sym("p", function.size1_in(1))
    f, g = function(z, p)
    return ca.Function("nlp", [z, p], [f, g], ["x", "p"], ["f", "g"])
