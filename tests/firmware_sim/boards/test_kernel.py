"""The compiled millisecond: the same numbers as an interpreter without limits gives."""

import json
import subprocess
import sys

import numpy as np
import pytest

from dforc import compiled
from firmware_sim.boards import fields as f
from firmware_sim.boards import modes
from firmware_sim.boards.kernel import control, finish, has_law, rebase, supervise
from firmware_sim.boards.kernel_law import step_limited
from firmware_sim.boards.kernel_modes import fault, idle, switch_off
from firmware_sim.boards.kernel_reference import advance
from firmware_sim.boards.warm import warm
from tests.firmware_sim.boards.hostile import TICKS, Hostile, outcome

SEEDS = (1, 2, 3, 4)
INTERPRETED = """
import sys
sys.modules["numba"] = None
from tests.firmware_sim.boards.hostile import print_outcomes
print_outcomes()
"""

Outcome = list[list[int]]


@pytest.fixture(scope="module")
def interpreted() -> dict[int, list[Outcome]]:
    """Outcomes where numba cannot be imported: on integers of any size, and on 64-bit words."""
    command = [sys.executable, "-W", "error", "-c", INTERPRETED, *map(str, SEEDS)]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    return dict(zip(SEEDS, json.loads(done.stdout), strict=True))


def test_a_compiler_is_there() -> None:
    assert compiled.HAS_COMPILER


@pytest.mark.parametrize("seed", SEEDS)
def test_no_gain_and_no_reference_leaves_64_bits(
    seed: int, interpreted: dict[int, list[Outcome]]
) -> None:
    exact, _ = interpreted[seed]
    assert outcome(seed, exact=False) == exact


@pytest.mark.parametrize("seed", SEEDS)
def test_without_a_compiler_the_numbers_are_the_same(
    seed: int, interpreted: dict[int, list[Outcome]]
) -> None:
    _, words = interpreted[seed]
    assert outcome(seed, exact=False) == words


def test_whatever_the_gains_the_bridge_stays_inside_its_limit() -> None:
    hostile = Hostile(5, exact=False)
    rows = hostile.bank.rows
    driven, saturated = 0, 0
    for now_ms in range(1, TICKS + 1):
        hostile.tick(now_ms)
        assert (np.abs(rows[:, f.PWM]) <= rows[:, f.DUTY_LIMIT]).all()
        assert (np.abs(rows[:, f.PORT_PWM]) <= 1333).all()
        assert (rows[rows[:, f.ENABLED] == 0, f.PORT_ENABLED] == 0).all()
        driven += int(np.count_nonzero(rows[:, f.PORT_PWM]))
        errors = np.abs(rows[:, f.POSITION_PID + f.ERROR])
        saturated += int(np.count_nonzero(errors >= 0x7FFF))
    assert driven > TICKS
    assert saturated > TICKS


def test_warming_up_compiles_everything_that_python_calls() -> None:
    warm()
    doors = (control, finish, supervise, rebase, advance, step_limited, idle, fault, switch_off)
    assert [door for door in doors if not getattr(door, "signatures", ())] == []


def test_compiled_modes_are_those_that_a_host_may_ask_for_and_the_move_of_calibration_4() -> None:
    assert {mode for mode in range(256) if has_law(mode)} == modes.COMPILED
