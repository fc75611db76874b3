"""Numba where it is installed; the same functions interpreted where it is not.

Both ways give the same numbers: no fast mathematics, no parallel loops, integers that stay inside
64 bits. Compiled code is kept on disk, beside its source or in the user's cache.
"""

import hashlib
from collections.abc import Callable
from types import CellType, CodeType, FunctionType
from typing import ParamSpec, TypeVar, cast

try:
    import numba
except ImportError:
    HAS_COMPILER = False
else:
    HAS_COMPILER = True

Parameters = ParamSpec("Parameters")
Result = TypeVar("Result")

_stamp = hashlib.sha256()  # over every function compiled so far


def compiled(function: Callable[Parameters, Result]) -> Callable[Parameters, Result]:
    """Compile a function of arrays and numbers at its first call, or leave it as it is."""
    if not HAS_COMPILER or not isinstance(function, FunctionType):
        return function
    marked = _marked(function)
    try:
        made = numba.njit(cache=True, nogil=True, error_model="numpy")(marked)
    except RuntimeError:  # no folder to keep it in
        made = numba.njit(nogil=True, error_model="numpy")(marked)
    return cast("Callable[Parameters, Result]", made)


def _marked(function: FunctionType) -> FunctionType:
    """The function with a mark that changes with it and with what was compiled before.

    Numba's cache looks at a function's own file and byte code and at its free variables, not at
    the functions and constants that it uses. They are compiled before it, so a free variable that
    holds the mark makes the cache forget what is out of date.
    """
    code = function.__code__
    _stamp.update(_text(code, function.__globals__).encode())
    named = code.replace(co_freevars=(*code.co_freevars, "mark"))
    cells = (*(function.__closure__ or ()), CellType(_stamp.hexdigest()))
    name, defaults = function.__name__, function.__defaults__
    made = FunctionType(named, function.__globals__, name, defaults, cells)
    made.__qualname__ = function.__qualname__
    made.__doc__ = function.__doc__
    return made


def _text(code: CodeType, names: dict[str, object]) -> str:
    used = [names.get(name) for name in code.co_names]
    numbers = [value for value in used if isinstance(value, int | float | frozenset)]
    return f"{code.co_code!r} {code.co_consts!r} {numbers!r}"
