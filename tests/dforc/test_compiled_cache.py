"""Functions compiled by numba: what the cache on disk knows, and what happens without a cache."""

import os
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import cast

import pytest

from dforc.compiled import compiled

PROGRAM = """
{before}
from door import doubled
print(doubled(5), sum(doubled.stats.cache_hits.values()))
"""
HELPER = """
from dforc.compiled import compiled

FACTOR = {factor}

@compiled
def scaled(value: int) -> int:
    return value * FACTOR
"""
DOOR = """
from helper import scaled
from dforc.compiled import compiled

@compiled
def doubled(value: int) -> int:
    return 2 * scaled(value)
"""


def run(folder: Path, factor: int, before: str = "") -> list[int]:
    """What the program prints when the helper's constant has this value, and the cache's hits."""
    (folder / "helper.py").write_text(HELPER.format(factor=factor))
    (folder / "door.py").write_text(DOOR)
    os.utime(folder / "door.py", (1, 1))  # numba looks at the file that it compiled, at no other
    roots = os.pathsep.join((str(folder), str(Path(__file__).parents[2])))
    done = subprocess.run(
        [sys.executable, "-B", "-c", PROGRAM.format(before=before)],
        env=os.environ | {"NUMBA_CACHE_DIR": str(folder / "cache"), "PYTHONPATH": roots},
        capture_output=True,
        text=True,
        check=True,
    )
    return [int(word) for word in done.stdout.split()]


@pytest.mark.slow
def test_the_cache_forgets_what_uses_a_changed_constant(tmp_path: Path) -> None:
    assert run(tmp_path, 3) == [30, 0]
    assert run(tmp_path, 3) == [30, 1]
    assert run(tmp_path, 4) == [40, 0]


@pytest.mark.slow
def test_the_cache_does_not_care_what_else_was_compiled_before(tmp_path: Path) -> None:
    assert run(tmp_path, 3) == [30, 0]
    assert run(tmp_path, 3, before="import firmware_sim.boards.kernel") == [30, 1]


def test_code_that_cannot_be_kept_on_disk_is_compiled_all_the_same() -> None:
    names: dict[str, object] = {}
    exec("def tripled(value):\n    return 3 * value\n", names)  # numba finds no file to cache by
    made = compiled(cast("Callable[[int], int]", names["tripled"]))
    assert made is not names["tripled"]
    assert made(7) == 21
