import math

import msgspec
import pytest

from services.core.errors import UndeclaredUseError
from services.core.service import CallFailed, Inputs, Outputs
from services.core.stream import AnyCall, AnyStream, Call, PlacedStream, Stream


class Value(msgspec.Struct, frozen=True):
    number: int


class Ask(msgspec.Struct, frozen=True):
    text: str


VALUE = Stream("place/value", Value, rate_hz=100)
OTHER = Stream("place/other", Value, rate_hz=100)
ASK = Call("place/ask", Ask, Value)
ELSEWHERE = Call("place/elsewhere", Ask, Value)


class Kept:
    """A carrier that keeps what it is given."""

    def __init__(self) -> None:
        self.sent: list[tuple[object, ...]] = []

    def send(self, stream: AnyStream, message: msgspec.Struct) -> None:
        self.sent.append((stream, message))

    def send_reply(self, call: AnyCall, token: int, reply: msgspec.Struct) -> None:
        self.sent.append((call, token, reply))

    def send_request(self, call: AnyCall, token: int, request: msgspec.Struct) -> None:
        self.sent.append((call, token, request))


@pytest.fixture
def inputs() -> Inputs:
    return Inputs("toy", reads=(VALUE,), serves=(ASK,), calls=(ELSEWHERE,))


def test_before_the_first_message_there_is_nothing(inputs: Inputs) -> None:
    assert inputs.latest(VALUE) is None
    assert inputs.fresh(VALUE, max_age_s=1e9) is None
    assert inputs.new(VALUE) is None
    assert inputs.all_new(VALUE) == ()
    assert inputs.age_s(VALUE) == math.inf


def test_age_counts_from_the_arrival_here(inputs: Inputs) -> None:
    inputs.deliver(VALUE, Value(1), arrival_ns=1_000_000_000)
    inputs.begin(1_250_000_000)
    assert inputs.age_s(VALUE) == pytest.approx(0.25)
    assert inputs.fresh(VALUE, max_age_s=0.25) == Value(1)
    assert inputs.fresh(VALUE, max_age_s=0.249) is None
    assert inputs.latest(VALUE) == Value(1)


def test_messages_are_new_for_one_step_only(inputs: Inputs) -> None:
    inputs.deliver(VALUE, Value(1), 0)
    inputs.deliver(VALUE, Value(2), 0)
    inputs.begin(0)
    assert inputs.new(VALUE) == Value(2)
    assert inputs.all_new(VALUE) == (Value(1), Value(2))
    inputs.end()
    inputs.begin(1)
    assert inputs.new(VALUE) is None
    assert inputs.all_new(VALUE) == ()
    assert inputs.latest(VALUE) == Value(2)
    inputs.deliver(VALUE, Value(3), 1)
    assert inputs.all_new(VALUE) == (Value(3),)


def test_requests_and_replies_are_seen_once(inputs: Inputs) -> None:
    inputs.deliver_request(ASK, 7, Ask("a"))
    inputs.deliver_reply(ELSEWHERE, 1, Value(5))
    inputs.deliver_reply(ELSEWHERE, 2, CallFailed("late"))
    assert inputs.requests(ASK) == ((7, Ask("a")),)
    assert inputs.replies(ELSEWHERE) == ((1, Value(5)), (2, CallFailed("late")))
    inputs.end()
    assert inputs.requests(ASK) == ()
    assert inputs.replies(ELSEWHERE) == ()


def test_undeclared_inputs_are_refused_naming_both(inputs: Inputs) -> None:
    with pytest.raises(UndeclaredUseError, match=r"toy .* read Stream\('place/other'.*place/value"):
        inputs.latest(OTHER)
    with pytest.raises(UndeclaredUseError, match=r"serve Call\('place/elsewhere'\).*place/ask"):
        inputs.requests(ELSEWHERE)
    with pytest.raises(UndeclaredUseError, match=r"call Call\('place/ask'\).*place/elsewhere"):
        inputs.replies(ASK)


def test_outputs_go_to_the_carrier_as_they_are() -> None:
    carrier = Kept()
    outputs = Outputs("toy", carrier, writes=(VALUE,), serves=(ASK,), calls=(ELSEWHERE,))
    message = Value(3)
    outputs.put(VALUE, message)
    outputs.reply(ASK, 9, Value(4))
    first, second = outputs.call(ELSEWHERE, Ask("x")), outputs.call(ELSEWHERE, Ask("y"))
    assert carrier.sent[0][1] is message
    assert carrier.sent[1] == (ASK, 9, Value(4))
    assert first != second
    assert [entry[1] for entry in carrier.sent[2:]] == [first, second]


def test_undeclared_outputs_are_refused() -> None:
    outputs = Outputs("toy", Kept(), writes=(VALUE,))
    with pytest.raises(UndeclaredUseError, match=r"write Stream\('place/other'"):
        outputs.put(OTHER, Value(1))
    with pytest.raises(UndeclaredUseError, match="it declares nothing"):
        outputs.reply(ASK, 1, Value(1))
    with pytest.raises(UndeclaredUseError, match="may call"):
        outputs.call(ASK, Ask("x"))


def test_a_placed_stream_gives_the_same_stream_for_the_same_place() -> None:
    placed = PlacedStream("joint_state", Value, rate_hz=500)
    arm = placed["right_arm"]
    assert arm is placed["right_arm"]
    assert arm is not placed["torso"]
    assert arm.name == "right_arm/joint_state"
    assert arm.rate_hz == 500
    assert arm.key("icub") == "icub/right_arm/joint_state"
