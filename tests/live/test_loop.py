"""The live executor on a clock that the test moves: deadlines, catching up, slipping, closing."""

from collections.abc import Callable, Iterator

import pytest
import zenoh

from services.core.clock import NS_PER_MS, RealClock, VirtualClock
from services.core.errors import ServiceError
from services.core.loop import LiveExecutor
from services.core.service import CallFailed, Inputs, Outputs, Period, Service
from services.core.session import connect, disconnect, open_hub
from services.core.stream import AnyStream
from tests.live.toy_streams import ORDER, PING, PONG, Done, Order

pytestmark = pytest.mark.live


@pytest.fixture
def session() -> Iterator[zenoh.Session]:
    with open_hub() as hub:
        opened = connect(hub.endpoint)
        yield opened
        disconnect(opened)


class Ticker(Service):
    """Notes when it is stepped, and stalls once."""

    trigger: AnyStream | Period = Period(0.001)

    def __init__(self, clock: VirtualClock, stall_at_step: int, stall_ms: int) -> None:
        self.steps_ms: list[int] = []
        self.late_ms: list[int] = []
        self.closed = 0
        self._clock = clock
        self._stall = (stall_at_step, stall_ms * NS_PER_MS)

    def step(self, now_ns: int, inputs: Inputs, outputs: Outputs) -> None:  # noqa: ARG002
        self.steps_ms.append(now_ns // NS_PER_MS)
        self.late_ms.append(inputs.late_ns // NS_PER_MS)
        if len(self.steps_ms) == self._stall[0]:
            self._clock.advance_ns(self._stall[1])

    def close(self, now_ns: int, outputs: Outputs) -> None:  # noqa: ARG002
        self.closed += 1


def run(
    session: zenoh.Session, service: Ticker, clock: VirtualClock, until: Callable[[], bool]
) -> LiveExecutor:
    executor = LiveExecutor("ticker", service, session, "icub", clock)
    executor.run(until)
    return executor


def test_deadlines_are_absolute(session: zenoh.Session) -> None:
    clock = VirtualClock()
    ticker = Ticker(clock, stall_at_step=0, stall_ms=0)
    executor = run(session, ticker, clock, lambda: len(ticker.steps_ms) == 30)
    assert ticker.steps_ms == list(range(1, 31))
    assert executor.tick_slips == 0
    assert ticker.closed == 1


def test_a_short_stall_is_caught_up_without_a_slip(session: zenoh.Session) -> None:
    clock = VirtualClock()
    ticker = Ticker(clock, stall_at_step=5, stall_ms=20)
    executor = run(session, ticker, clock, lambda: len(ticker.steps_ms) == 40)
    assert ticker.steps_ms[4:6] == [5, 25]
    assert ticker.steps_ms[25:27] == [26, 27]  # in step with the clock again: nothing was left out
    assert ticker.steps_ms[-1] == 40
    assert ticker.late_ms[4:7] == [0, 19, 18]  # due at 6 and 7, begun at 25
    assert ticker.late_ms[24:26] == [0, 0]
    assert executor.tick_slips == 0


def test_beyond_twenty_ticks_time_slips_and_is_counted(session: zenoh.Session) -> None:
    clock = VirtualClock()
    ticker = Ticker(clock, stall_at_step=5, stall_ms=120)
    executor = run(session, ticker, clock, lambda: len(ticker.steps_ms) == 40)
    assert executor.tick_slips == 99  # 119 behind, 20 caught up
    assert ticker.steps_ms[5:26] == [125] * 21
    assert ticker.steps_ms[26] == 126
    assert executor.stats().tick_slips == 99


class Failing(Ticker):
    def step(self, now_ns: int, inputs: Inputs, outputs: Outputs) -> None:
        super().step(now_ns, inputs, outputs)
        raise ValueError("broken")


def test_an_error_closes_the_service_and_passes_on(session: zenoh.Session) -> None:
    clock = VirtualClock()
    failing = Failing(clock, 0, 0)
    with pytest.raises(ValueError, match="broken"):
        run(session, failing, clock, lambda: False)
    assert failing.closed == 1


class Caller(Service):
    """Sends a ping and an order when it hears anything, and keeps the answers."""

    reads = (PING,)
    writes = (PING, PONG)
    calls = (ORDER,)
    trigger = PING

    def __init__(self) -> None:
        self.answers: list[Done | CallFailed] = []

    def step(self, now_ns: int, inputs: Inputs, outputs: Outputs) -> None:  # noqa: ARG002
        self.answers += [answer for _, answer in inputs.replies(ORDER)]
        if inputs.new(PING) is not None:
            outputs.call(ORDER, Order("hello"))


def test_an_answer_starts_a_step_of_a_service_without_a_period(session: zenoh.Session) -> None:
    caller = Caller()
    clock = RealClock()
    executor = LiveExecutor("caller", caller, session, "icub", clock)
    session.put(PING.key("icub"), b"\x92\x00\x01", encoding="application/msgpack;schema=Ping")
    executor.run(until=lambda: bool(caller.answers))
    assert caller.answers == [CallFailed("nobody answers toy/order")]
    assert executor.step_times.count == 2


def test_samples_of_another_type_are_refused_and_counted(session: zenoh.Session) -> None:
    caller = Caller()
    executor = LiveExecutor("caller", caller, session, "icub", RealClock())
    key = PING.key("icub")
    session.put(key, b"\x92\x00\x01", encoding="application/msgpack;schema=Goal")
    session.put(key, b"\x93", encoding="application/msgpack;schema=Ping")
    session.put(key, b"\x92\x00\x01", encoding="application/msgpack;schema=Ping")
    executor.run(until=lambda: True)
    assert executor.stats().errors == 2
    assert executor.step_times.count == 1


class TwoSided(Service):
    """Notes how many messages of each stream its steps see."""

    reads = (PING, PONG)
    trigger = (PING, PONG)

    def __init__(self) -> None:
        self.seen: list[tuple[int, int]] = []

    def step(self, now_ns: int, inputs: Inputs, outputs: Outputs) -> None:  # noqa: ARG002
        self.seen.append((len(inputs.all_new(PING)), len(inputs.all_new(PONG))))


def test_what_is_sent_together_is_one_step(session: zenoh.Session) -> None:
    service = TwoSided()
    executor = LiveExecutor("reader", service, session, "icub", RealClock())

    def put_pair() -> None:
        for stream in (PING, PONG):
            encoding = "application/msgpack;schema=Ping"
            session.put(stream.key("icub"), b"\x92\x00\x01", encoding=encoding)

    def another_until_all_came() -> bool:
        pings, pongs = map(sum, zip(*service.seen, strict=True))
        if pings == pongs:
            put_pair()
        return pings == pongs == 30

    put_pair()
    executor.run(until=another_until_all_came)
    assert service.seen[-20:] == [(1, 1)] * 20


def test_a_trigger_must_be_read(session: zenoh.Session) -> None:
    service = Ticker(VirtualClock(), 0, 0)
    service.trigger = PONG
    with pytest.raises(ServiceError, match="does not read"):
        LiveExecutor("ticker", service, session, "icub", VirtualClock())
