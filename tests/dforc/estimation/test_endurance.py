"""Thousands of random ticks with a faulty sensor; a million by benchmarks/dynamics.py."""

import pytest

from benchmarks.dynamics_endurance import Endurance


def test_faults_in_one_limb_never_bring_a_nan_out_nor_reach_the_other_limbs(
    compiled: bool,
) -> None:
    endurance = Endurance(compiled=compiled)
    endurance.run(1500)
    assert endurance.seen["ticks"] == 1500
    assert endurance.seen["NaN out"] == 0
    assert endurance.seen["other limbs changed"] == 0
    assert endurance.seen["refused"] == endurance.seen["not finite"] > 300


@pytest.mark.slow
def test_more_faults_do_not_either() -> None:
    endurance = Endurance()
    endurance.run(50_000)
    assert endurance.seen["NaN out"] == endurance.seen["other limbs changed"] == 0
    assert endurance.seen["refused"] == endurance.seen["not finite"]
