"""Without a compiler everything works, and gives the same numbers."""

import json
import subprocess
import sys

import pytest

from dforc.compiled import HAS_COMPILER
from tests.dforc.collision.outcomes import Numbers, numbers

INTERPRETED = """
import sys
sys.modules["numba"] = None
from tests.dforc.collision.outcomes import print_numbers
print_numbers()
"""


@pytest.mark.skipif(not HAS_COMPILER, reason="numba is not installed")
def test_numbers_are_the_same_without_a_compiler() -> None:
    command = [sys.executable, "-W", "error", "-c", INTERPRETED]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    interpreted: Numbers = json.loads(done.stdout)
    here = numbers()
    assert len(here) > 30
    assert len(interpreted) == len(here)
    for one, other in zip(interpreted, here, strict=True):
        assert one == other
