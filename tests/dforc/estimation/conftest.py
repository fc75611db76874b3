"""Robots of icub-models, loaded once, and estimators of both paths."""

from collections.abc import Callable
from functools import cache

import pytest

from benchmarks.dynamics_scenes import LIMBS, Robot, robot
from dforc.compiled import HAS_COMPILER
from dforc.estimation.assumption import Assumption
from dforc.estimation.estimator import WholeBodyEstimator

Make = Callable[[Assumption], WholeBodyEstimator]


@cache
def loaded(urdf: str, sensors: tuple[str, ...]) -> Robot:
    return robot(urdf, sensors)


@pytest.fixture(scope="session")
def load() -> Callable[[str, tuple[str, ...]], Robot]:
    return loaded


@pytest.fixture(scope="session")
def icub() -> Robot:
    """The paper's robot: two arms and two legs with a sensor each."""
    return loaded("iCubLisboa01", LIMBS)


@pytest.fixture(params=["compiled", "plain"])
def compiled(request: pytest.FixtureRequest) -> bool:
    """Every test that asks for this runs both ways."""
    if request.param == "compiled" and not HAS_COMPILER:
        pytest.skip("numba is not installed")
    return bool(request.param == "compiled")


@pytest.fixture
def make(icub: Robot, compiled: bool) -> Make:
    return lambda assumption: WholeBodyEstimator(icub.tree, assumption, compiled=compiled)
