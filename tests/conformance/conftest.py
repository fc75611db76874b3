"""Fixtures over everything that is registered."""

import pytest

from firmware_sim import registry
from tests.firmware_sim.boards.bench import Bench


@pytest.fixture(params=sorted(registry.MOTOR_BOARDS))
def bench(request: pytest.FixtureRequest) -> Bench:
    """A bench with each motor board in turn."""
    return Bench(request.param)
