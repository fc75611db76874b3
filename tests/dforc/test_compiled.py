"""Compiled functions: same numbers, and no compilation once sealed."""

import numpy as np
import pytest

from dforc.arrays import Vector
from dforc.compiled import HAS_COMPILER, compiled, seal


def total(values: Vector) -> float:
    """Sum, one by one."""
    found = 0.0
    for value in values:
        found += value
    return found


def test_compiled_function_gives_what_the_interpreted_one_gives() -> None:
    values = np.random.default_rng(1).normal(size=100)
    assert compiled(total)(values) == total(values)


@pytest.mark.skipif(not HAS_COMPILER, reason="numba is not installed")
def test_sealed_function_takes_no_other_types_instead_of_compiling_in_the_middle_of_a_tick() -> (
    None
):
    function = compiled(total)
    assert function(np.ones(3)) == 3.0
    seal(function)
    assert function(np.ones(5)) == 5.0
    with pytest.raises(TypeError):
        function(np.ones(3, dtype=np.float32))
