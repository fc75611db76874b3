from collections.abc import Callable

import msgspec
import pytest

from services.core.clock import NS_PER_MS, VirtualClock
from services.core.errors import ServiceError
from services.core.service import CallFailed, Inputs, Outputs, Period, Service
from services.core.stream import AnyCall, AnyStream, Call, Stream
from services.core.virtual import VirtualExecutor


class Value(msgspec.Struct, frozen=True):
    number: int


A = Stream("a", Value, rate_hz=1000)
B = Stream("b", Value, rate_hz=1000)
ASK = Call("ask", Value, Value, timeout_s=0.01)

Act = Callable[[int, Inputs, Outputs], None]


def nothing(now_ns: int, inputs: Inputs, outputs: Outputs) -> None:
    """A step that does nothing."""


class Toy(Service):
    def __init__(
        self,
        trigger: AnyStream | Period | tuple[AnyStream, ...],
        act: Act = nothing,
        *,
        reads: tuple[AnyStream, ...] = (),
        writes: tuple[AnyStream, ...] = (),
        serves: tuple[AnyCall, ...] = (),
        calls: tuple[AnyCall, ...] = (),
    ) -> None:
        self.trigger = trigger
        self.reads, self.writes, self.serves, self.calls = reads, writes, serves, calls
        self._act = act
        self.steps_ms: list[float] = []
        self.closed: list[str] = []

    def step(self, now_ns: int, inputs: Inputs, outputs: Outputs) -> None:
        self.steps_ms.append(now_ns / NS_PER_MS)
        self._act(now_ns, inputs, outputs)


def put_a(now_ns: int, inputs: Inputs, outputs: Outputs) -> None:  # noqa: ARG001
    outputs.put(A, Value(now_ns // NS_PER_MS))


def run(services: dict[str, Service], ticks: int, hop_ticks: int = 1) -> VirtualExecutor:
    executor = VirtualExecutor(VirtualClock(), services, hop_ticks)
    for _ in range(ticks):
        executor.tick()
    return executor


def test_a_period_starts_at_once_and_keeps_its_grid() -> None:
    fast, slow = Toy(Period(0.001)), Toy(Period(0.01))
    run({"fast": fast, "slow": slow}, ticks=25)
    assert fast.steps_ms == list(range(25))
    assert slow.steps_ms == [0, 10, 20]


@pytest.mark.parametrize("hop", [1, 2, 5])
def test_a_message_is_seen_one_hop_later(hop: int) -> None:
    seen: list[tuple[float, int]] = []

    def look(now_ns: int, inputs: Inputs, outputs: Outputs) -> None:  # noqa: ARG001
        message = inputs.new(A)
        if message is not None:
            seen.append((now_ns / NS_PER_MS, message.number))

    sender = Toy(Period(0.01), put_a, writes=(A,))
    run({"sender": sender, "reader": Toy(A, look, reads=(A,))}, 26, hop)
    assert seen == [(0 + hop, 0), (10 + hop, 10), (20 + hop, 20)]


def test_the_same_holds_for_a_reader_in_an_earlier_row() -> None:
    reader = Toy(A, reads=(A,))
    run({"reader": reader, "sender": Toy(Period(0.01), put_a, writes=(A,))}, 15)
    assert reader.steps_ms == [1, 11]


def test_a_chain_takes_one_hop_a_link() -> None:
    def forward(now_ns: int, inputs: Inputs, outputs: Outputs) -> None:  # noqa: ARG001
        for message in inputs.all_new(A):
            outputs.put(B, message)

    last = Toy(B, reads=(B,))
    services: dict[str, Service] = {
        "first": Toy(Period(0.02), put_a, writes=(A,)),
        "second": Toy(A, forward, reads=(A,), writes=(B,)),
        "third": last,
    }
    run(services, 15)
    assert last.steps_ms == [2]


def test_messages_are_handed_over_and_not_copied() -> None:
    message = Value(1)
    seen: list[Value | None] = []
    reader = Toy(A, lambda _now, inputs, _out: seen.append(inputs.latest(A)), reads=(A,))
    executor = VirtualExecutor(VirtualClock(), {"reader": reader})
    executor.put(A, message)
    executor.tick()
    executor.tick()
    assert seen[0] is message


def test_messages_of_one_instant_come_in_row_order_then_sequence() -> None:
    seen: list[int] = []

    def put_twice(first: int) -> Act:
        def act(now_ns: int, inputs: Inputs, outputs: Outputs) -> None:  # noqa: ARG001
            outputs.put(A, Value(first))
            outputs.put(A, Value(first + 1))

        return act

    def look(now_ns: int, inputs: Inputs, outputs: Outputs) -> None:  # noqa: ARG001
        seen.extend(message.number for message in inputs.all_new(A))

    services: dict[str, Service] = {
        "reader": Toy(A, look, reads=(A,)),
        "x": Toy(Period(1.0), put_twice(10), writes=(A,)),
        "y": Toy(Period(1.0), put_twice(20), writes=(A,)),
    }
    run(services, 3)
    assert seen == [10, 11, 20, 21]


def asker(answers: list[object]) -> Act:
    def act(now_ns: int, inputs: Inputs, outputs: Outputs) -> None:
        for token, reply in inputs.replies(ASK):
            answers.append((now_ns // NS_PER_MS, token, reply))
        if now_ns == 0:
            answers.append(outputs.call(ASK, Value(5)))

    return act


def test_a_request_is_answered_two_hops_later_under_its_token() -> None:
    def serve(now_ns: int, inputs: Inputs, outputs: Outputs) -> None:  # noqa: ARG001
        for token, request in inputs.requests(ASK):
            outputs.reply(ASK, token, Value(request.number * 2))

    answers: list[object] = []
    services: dict[str, Service] = {
        "server": Toy(A, serve, reads=(A,), serves=(ASK,)),
        "asker": Toy(Period(0.001), asker(answers), calls=(ASK,)),
    }
    run(services, 5)
    assert answers == [1, (2, 1, Value(10))]


def test_a_request_that_nobody_serves_fails() -> None:
    answers: list[object] = []
    run({"asker": Toy(Period(0.001), asker(answers), calls=(ASK,))}, 5)
    assert answers == [1, (1, 1, CallFailed("nobody serves ask"))]


def test_a_request_that_is_not_answered_fails_in_time() -> None:
    answers: list[object] = []
    services: dict[str, Service] = {
        "server": Toy(Period(0.001), serves=(ASK,)),
        "asker": Toy(Period(0.001), asker(answers), calls=(ASK,)),
    }
    run(services, 30)
    assert answers == [1, (11, 1, CallFailed("ask: no answer in 0.01 s"))]


def test_a_late_reply_is_dropped() -> None:
    def serve_late(now_ns: int, inputs: Inputs, outputs: Outputs) -> None:
        kept.extend(token for token, _ in inputs.requests(ASK))
        if now_ns == 20 * NS_PER_MS:
            outputs.reply(ASK, kept[0], Value(1))

    kept: list[int] = []
    answers: list[object] = []
    services: dict[str, Service] = {
        "server": Toy(Period(0.001), serve_late, serves=(ASK,)),
        "asker": Toy(Period(0.001), asker(answers), calls=(ASK,)),
    }
    run(services, 30)
    assert len(answers) == 2


def test_an_error_in_a_step_says_where_and_when() -> None:
    def fail(now_ns: int, inputs: Inputs, outputs: Outputs) -> None:  # noqa: ARG001
        if now_ns == 3 * NS_PER_MS:
            raise ValueError("broken")

    with pytest.raises(ValueError, match="broken") as caught:
        run({"faulty": Toy(Period(0.001), fail)}, 10)
    assert caught.value.__notes__ == ["in service 'faulty', at 3 ms"]


def test_close_goes_from_the_last_row_to_the_first() -> None:
    order: list[str] = []

    class Closing(Toy):
        def close(self, now_ns: int, outputs: Outputs) -> None:  # noqa: ARG002
            order.append(f"{self.reads[0].name} at {now_ns / NS_PER_MS:.0f}")

    executor = run({"x": Closing(A, reads=(A,)), "y": Closing(B, reads=(B,))}, 4)
    executor.close()
    assert order == ["b at 4", "a at 4"]


def test_run_stops_when_the_condition_holds() -> None:
    toy = Toy(Period(0.001))
    executor = VirtualExecutor(VirtualClock(), {"toy": toy})
    assert executor.run(1.0, until=lambda: len(toy.steps_ms) == 7)
    assert executor.ticks == 7
    assert not executor.run(0.01)
    assert executor.ticks == 17


def test_counts_steps_and_their_duration() -> None:
    executor = run({"toy": Toy(Period(0.001))}, 10)
    assert executor.step_times("toy").count == 10
    with pytest.raises(ServiceError, match=r"no service 'ghost'; there are: \['toy'\]"):
        executor.step_times("ghost")


def test_counts_only_the_steps_that_do_the_work_where_a_service_says_which() -> None:
    def now_and_then(now_ns: int, inputs: Inputs, outputs: Outputs) -> None:  # noqa: ARG001
        outputs.put(B, Value(0))
        if now_ns % (5 * NS_PER_MS) == 0:
            outputs.put(A, Value(0))

    sender = Toy(Period(0.001), now_and_then, writes=(A, B))
    both = Toy((A, B), reads=(A, B))
    both.timed = A
    executor = run({"sender": sender, "both": both}, 21)
    assert len(both.steps_ms) == 20
    assert executor.step_times("both").count == 4


@pytest.mark.parametrize("seconds", [0.0, 0.0004, 0.0015])
def test_a_period_must_be_whole_ticks(seconds: float) -> None:
    with pytest.raises(ServiceError, match="whole ticks"):
        run({"toy": Toy(Period(seconds))}, 1)


def test_several_triggers_start_one_step_a_tick_and_a_silent_one_stops_nothing() -> None:
    def put_b_for_three_ticks(now_ns: int, inputs: Inputs, outputs: Outputs) -> None:  # noqa: ARG001
        if now_ns < 3 * NS_PER_MS:
            outputs.put(B, Value(0))

    reader = Toy((A, B), reads=(A, B))
    services: dict[str, Service] = {
        "a": Toy(Period(0.002), put_a, writes=(A,)),
        "b": Toy(Period(0.001), put_b_for_three_ticks, writes=(B,)),
        "reader": reader,
    }
    run(services, 8)
    assert reader.steps_ms == [1, 2, 3, 5, 7]


def test_each_of_several_triggers_must_be_read() -> None:
    with pytest.raises(ServiceError, match=r"'b'.*does not read"):
        VirtualExecutor(VirtualClock(), {"toy": Toy((A, B), reads=(A,))})


def test_an_empty_trigger_is_refused() -> None:
    with pytest.raises(ServiceError, match="nothing would ever start a step"):
        VirtualExecutor(VirtualClock(), {"toy": Toy(())})


def test_a_trigger_must_be_read() -> None:
    with pytest.raises(ServiceError, match="does not read"):
        run({"toy": Toy(A)}, 1)


def test_a_call_has_one_server() -> None:
    services: dict[str, Service] = {
        "x": Toy(Period(0.001), serves=(ASK,)),
        "y": Toy(Period(0.001), serves=(ASK,)),
    }
    with pytest.raises(ServiceError, match="ask is served by x and y"):
        run(services, 1)


def test_a_hop_takes_time() -> None:
    with pytest.raises(ServiceError, match="at least one tick"):
        VirtualExecutor(VirtualClock(), {}, hop_ticks=0)
