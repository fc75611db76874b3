from collections.abc import Callable, Iterator

import pytest

from tests.services.cli.can_bench import Wires


@pytest.fixture
def make_wires() -> Iterator[Callable[..., Wires]]:
    made: list[Wires] = []

    def make(*buses: str) -> Wires:
        made.append(Wires(*buses))
        return made[-1]

    yield make
    for wires in made:
        wires.close()
