"""A bench of emulated boards, fresh or calibrated."""

from collections.abc import Iterator

import pytest

from tests.hal.emulated import Bench


@pytest.fixture
def bench() -> Iterator[Bench]:
    bench = Bench()
    yield bench
    bench.close()


@pytest.fixture
def ready(bench: Bench) -> Bench:
    bench.calibrated()
    return bench
