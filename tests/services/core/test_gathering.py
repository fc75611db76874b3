"""Messages that were sent together are one batch; a silent stream holds up one step only."""

import msgspec
import pytest

from services.core.gathering import Gathering
from services.core.service import Inputs
from services.core.stream import AnyStream, Call, Stream


class Value(msgspec.Struct, frozen=True):
    number: int


LEFT = Stream("left", Value, rate_hz=1000)
RIGHT = Stream("right", Value, rate_hz=1000)
SLOW = Stream("slow", Value, rate_hz=250)
ASK = Call("ask", Value, Value)


@pytest.fixture
def inputs() -> Inputs:
    return Inputs("reader", (LEFT, RIGHT, SLOW), (ASK,))


@pytest.fixture
def gathering() -> Gathering:
    return Gathering((LEFT, RIGHT, SLOW))


def batch(gathering: Gathering, inputs: Inputs, *streams: AnyStream) -> bool:
    """One batch of these streams; whether it was complete."""
    for stream in streams:
        inputs.deliver(stream, Value(1), 0)
    complete = gathering.is_complete(inputs)
    gathering.end(inputs)
    inputs.end()
    return complete


def test_at_first_nothing_is_waited_for(gathering: Gathering, inputs: Inputs) -> None:
    assert batch(gathering, inputs, LEFT)


def test_what_came_together_is_waited_for(gathering: Gathering, inputs: Inputs) -> None:
    batch(gathering, inputs, LEFT, RIGHT)
    inputs.deliver(LEFT, Value(1), 0)
    assert not gathering.is_complete(inputs)
    inputs.deliver(RIGHT, Value(1), 0)
    assert gathering.is_complete(inputs)


def test_a_silent_stream_holds_up_one_batch_only(gathering: Gathering, inputs: Inputs) -> None:
    batch(gathering, inputs, LEFT, RIGHT)
    assert not batch(gathering, inputs, LEFT)
    assert batch(gathering, inputs, LEFT)


def test_a_stream_that_is_back_is_waited_for_again(gathering: Gathering, inputs: Inputs) -> None:
    batch(gathering, inputs, LEFT)
    batch(gathering, inputs, LEFT, RIGHT)
    assert not batch(gathering, inputs, LEFT)


def test_a_slower_stream_is_not_waited_for_but_waits_itself(
    gathering: Gathering, inputs: Inputs
) -> None:
    batch(gathering, inputs, LEFT, RIGHT, SLOW)
    assert batch(gathering, inputs, LEFT, RIGHT)
    assert not batch(gathering, inputs, SLOW)


def test_a_request_alone_waits_for_nothing(gathering: Gathering, inputs: Inputs) -> None:
    batch(gathering, inputs, LEFT, RIGHT)
    inputs.deliver_request(ASK, 1, Value(1))
    assert gathering.is_complete(inputs)
    gathering.end(inputs)
    inputs.end()
    assert not batch(gathering, inputs, LEFT)
