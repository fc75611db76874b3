import msgspec

from services.core.service import CallFailed, Inputs, Outputs, Period, Service
from services.core.stream import Call, Stream
from services.core.testing import Bench


class Value(msgspec.Struct, frozen=True):
    number: int


IN = Stream("in", Value, rate_hz=100)
AGAIN = Stream("again", Value, rate_hz=100)
OUT = Stream("out", Value, rate_hz=100)
ASK = Call("ask", Value, Value)
FURTHER = Call("further", Value, Value)


class Doubler(Service):
    reads, writes, serves, calls = (IN,), (OUT,), (ASK,), (FURTHER,)
    trigger = IN

    def step(self, now_ns: int, inputs: Inputs, outputs: Outputs) -> None:  # noqa: ARG002
        for message in inputs.all_new(IN):
            outputs.put(OUT, Value(2 * message.number))
        for token, request in inputs.requests(ASK):
            outputs.call(FURTHER, request)
            outputs.reply(ASK, token, Value(token))
        for _, reply in inputs.replies(FURTHER):
            outputs.put(OUT, Value(-1) if isinstance(reply, CallFailed) else reply)


class Ticker(Service):
    writes = (OUT,)
    trigger = Period(0.01)

    def step(self, now_ns: int, inputs: Inputs, outputs: Outputs) -> None:  # noqa: ARG002
        outputs.put(OUT, Value(now_ns))

    def close(self, now_ns: int, outputs: Outputs) -> None:  # noqa: ARG002
        outputs.put(OUT, Value(-1))


def test_a_message_on_the_trigger_steps_at_once() -> None:
    bench = Bench(Doubler())
    bench.put(IN, Value(21))
    assert bench.last(OUT) == Value(42)
    assert bench.steps == 1


def test_requests_and_replies_go_both_ways() -> None:
    bench = Bench(Doubler())
    token = bench.request(ASK, Value(3))
    assert bench.replies(ASK) == [(token, Value(token))]
    ((further, request),) = bench.requests(FURTHER)
    assert request == Value(3)
    bench.answer(FURTHER, further, Value(9))
    bench.answer(FURTHER, further, CallFailed("late"))
    assert bench.sent(OUT) == [Value(9), Value(-1)]


def test_time_steps_a_periodic_service_at_every_due_instant() -> None:
    bench = Bench(Ticker())
    bench.advance(0.025)
    assert [message.number for message in bench.sent(OUT)] == [0, 10_000_000, 20_000_000]
    assert bench.clock.now_ns() == 25_000_000
    bench.close()
    assert bench.last(OUT) == Value(-1)


class TwoSided(Service):
    reads = trigger = (IN, AGAIN)

    def step(self, now_ns: int, inputs: Inputs, outputs: Outputs) -> None:
        """Nothing."""


def test_messages_that_come_together_start_one_step() -> None:
    bench = Bench(TwoSided())
    bench.put_together({IN: Value(1), AGAIN: Value(2)})
    assert bench.steps == 1
    bench.put(AGAIN, Value(3))
    assert bench.steps == 2
