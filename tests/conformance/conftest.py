"""Fixtures over everything that is registered."""

import pytest

from tests.firmware_sim.boards.bench import SPECS, VERSIONS, Bench

ONE_OF_EACH = ("bll 2.50", "bll_ie 2.51", "bll_ie 2.54", "bll_dc 1.62")
EXAMINED = (*ONE_OF_EACH, *(name for name in SPECS if name.startswith("dc4 ")))
"""The brushless boards share their code: types, and firmwares that differ without couplings."""


@pytest.fixture(params=EXAMINED)
def bench(request: pytest.FixtureRequest) -> Bench:
    """A bench with each motor board in turn, its axes uncoupled."""
    return Bench(request.param)


@pytest.fixture(params=[name for name in SPECS if " " in name])
def every(request: pytest.FixtureRequest) -> Bench:
    """The same with every firmware number of every type."""
    return Bench(request.param)


@pytest.fixture(params=sorted(VERSIONS))
def kind(request: pytest.FixtureRequest) -> str:
    """Each type of motor board."""
    name: str = request.param
    return name
