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

_marks: dict[int, tuple[object, str]] = {}  # of what was compiled, by the identity of the result


def compiled(function: Callable[Parameters, Result]) -> Callable[Parameters, Result]:
    """Compile a function of arrays and numbers at its first call, or leave it as it is."""
    if not HAS_COMPILER or not isinstance(function, FunctionType):
        return function
    mark = _mark(function)
    marked = _with_mark(function, mark)
    try:
        made = numba.njit(cache=True, nogil=True, error_model="numpy")(marked)
    except RuntimeError:  # no folder to keep it in
        made = numba.njit(nogil=True, error_model="numpy")(marked)
    _marks[id(made)] = made, mark
    return cast("Callable[Parameters, Result]", made)


def seal(function: Callable[Parameters, Result]) -> None:
    """Compile a function for no further types of arguments: others raise TypeError from now on."""
    disable = getattr(function, "disable_compile", None)
    if disable is not None:
        disable()


def _mark(function: FunctionType) -> str:
    """A text that changes with a function, with its constants, and with what it calls.

    Numba's cache looks at a function's own file and byte code and at its free variables, not at
    the constants and functions of other files. So the mark becomes a free variable: see below.
    """
    code, names = function.__code__, function.__globals__
    used = [_text(code)]
    for name in code.co_names:
        value = names.get(name)
        if isinstance(value, int | float):
            used.append(f"{name} {value!r}")
        elif id(value) in _marks:
            used.append(_marks[id(value)][1])
    return hashlib.sha256("\n".join(used).encode()).hexdigest()


def _text(code: CodeType) -> str:
    constants = [_text(c) if isinstance(c, CodeType) else repr(c) for c in code.co_consts]
    return f"{code.co_code!r} {constants}"


def _with_mark(function: FunctionType, mark: str) -> FunctionType:
    """The same function with a free variable that it does not use."""
    code = function.__code__
    named = code.replace(co_freevars=(*code.co_freevars, "mark"))
    cells = (*(function.__closure__ or ()), CellType(mark))
    name, defaults = function.__name__, function.__defaults__
    made = FunctionType(named, function.__globals__, name, defaults, cells)
    made.__qualname__ = function.__qualname__
    made.__doc__ = function.__doc__
    return made
