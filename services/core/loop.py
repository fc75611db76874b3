"""The live executor: steps one service by the host's clock, or by the messages that arrive."""

import contextlib
import queue
from collections.abc import Callable

import msgspec
import zenoh

from services.core.clock import NS_PER_S, Clock
from services.core.gathering import LONGEST_GATHER_NS, Gathering
from services.core.link import Link, publisher
from services.core.service import Inputs, Outputs, Period, Service, is_timed, triggers
from services.core.timing import Durations
from services.messages import ServiceStats
from services.streams import STATS

MOST_PERIODS_TO_CATCH_UP = 20
STATS_PERIOD_NS = NS_PER_S
LONGEST_WAIT_S = 0.2  # a stop signal and the statistics need no message to be seen

_encode = msgspec.msgpack.Encoder().encode


def alive_key(robot: str, process: str) -> str:
    """Key of the liveliness token that a process holds once it is at work."""
    return f"{robot}/@alive/{process}"


class LiveExecutor:
    """Steps one service until it is stopped. step() runs only in the thread that calls run()."""

    def __init__(
        self,
        name: str,
        service: Service,
        session: zenoh.Session,
        robot: str,
        clock: Clock,
        scheduler: str = "",
    ) -> None:
        self.tick_slips = 0
        self.lateness = Durations()  # from the deadline, or the arrival, to the start of the step
        self.step_times = Durations()
        self._name = name
        self._service = service
        self._clock = clock
        self._scheduler = scheduler
        self._stopping = False
        self._flag: queue.SimpleQueue[None] = queue.SimpleQueue()
        periodic = isinstance(service.trigger, Period)
        self._gathering = Gathering(triggers(name, service))
        self._link = Link(session, robot, service, clock, None if periodic else self._raise_flag)
        self._inputs = Inputs(name, service.reads, service.serves, service.calls)
        self._outputs = Outputs(name, self._link, service.writes, service.serves, service.calls)
        self._put_stats = publisher(session, robot, STATS[name])
        self._report_due_ns = clock.now_ns() + STATS_PERIOD_NS
        self._token = session.liveliness().declare_token(alive_key(robot, name))

    def stop(self) -> None:
        """End the loop soon; may be called from a signal handler or another thread."""
        self._stopping = True
        self._flag.put(None)

    def run(self, until: Callable[[], bool] | None = None) -> None:
        """Step the service until stop(), an error, or until the condition holds after a step.

        Whichever it is, the service's close() is called before this returns.
        """
        trigger = self._service.trigger
        try:
            if isinstance(trigger, Period):
                self._run_by_clock(round(trigger.seconds * NS_PER_S), until)
            else:
                self._run_by_messages(until)
        finally:
            self._service.close(self._clock.now_ns(), self._outputs)
            self._link.close()
            self._token.undeclare()  # type: ignore[no-untyped-call]  # so in zenoh's stubs

    def stats(self) -> ServiceStats:
        """How this process has kept its time since the start."""
        step_p50_ns, step_p99_ns = self.step_times.percentiles_ns(50, 99)
        late_p50_ns, late_p99_ns = self.lateness.percentiles_ns(50, 99)
        return ServiceStats(
            stamp_ns=self._clock.now_ns(),
            process=self._name,
            steps=self.step_times.count,
            step_ms_p50=step_p50_ns * 1e-6,
            step_ms_p99=step_p99_ns * 1e-6,
            late_us_p50=late_p50_ns * 1e-3,
            late_us_p99=late_p99_ns * 1e-3,
            tick_slips=self.tick_slips,
            scheduler=self._scheduler,
            errors=self._link.refusals.count,
        )

    def _run_by_clock(self, period_ns: int, until: Callable[[], bool] | None) -> None:
        clock, drain, inputs = self._clock, self._link.drain, self._inputs
        deadline_ns = clock.now_ns() + period_ns
        while not self._stopping:
            clock.sleep_until(deadline_ns)
            now_ns = clock.now_ns()
            late_ns = now_ns - deadline_ns
            self.lateness.add(late_ns)
            behind = late_ns // period_ns
            if behind > MOST_PERIODS_TO_CATCH_UP:
                self.tick_slips += behind - MOST_PERIODS_TO_CATCH_UP
                deadline_ns += (behind - MOST_PERIODS_TO_CATCH_UP) * period_ns
            drain(inputs)
            self._step(now_ns, late_ns)
            deadline_ns += period_ns
            if until is not None and until():
                return

    def _run_by_messages(self, until: Callable[[], bool] | None) -> None:
        clock, link, flag = self._clock, self._link, self._flag
        while not self._stopping:
            with contextlib.suppress(queue.Empty):
                flag.get(timeout=LONGEST_WAIT_S)
            if link.drain(self._inputs):
                oldest_ns = link.oldest_ns
                self._gather(oldest_ns + LONGEST_GATHER_NS)
                now_ns = clock.now_ns()
                self.lateness.add(now_ns - oldest_ns)
                self._step(now_ns, now_ns - oldest_ns)
                if until is not None and until():
                    return
            elif clock.now_ns() >= self._report_due_ns:
                self._report(clock.now_ns())

    def _gather(self, deadline_ns: int) -> None:
        """Let in the rest of what was sent together."""
        while not self._gathering.is_complete(self._inputs) and not self._stopping:
            left_ns = deadline_ns - self._clock.now_ns()
            if left_ns <= 0:
                break
            with contextlib.suppress(queue.Empty):
                self._flag.get(timeout=left_ns / NS_PER_S)
            self._link.drain(self._inputs)
        self._gathering.end(self._inputs)

    def _step(self, now_ns: int, late_ns: int) -> None:
        inputs = self._inputs
        inputs.begin(now_ns, late_ns)
        self._service.step(now_ns, inputs, self._outputs)
        if is_timed(self._service, inputs):
            self.step_times.add(self._clock.now_ns() - now_ns)
        inputs.end()
        if now_ns >= self._report_due_ns:
            self._report(now_ns)

    def _report(self, now_ns: int) -> None:
        """Once a second, in the slack behind a step."""
        self._report_due_ns = now_ns + STATS_PERIOD_NS
        self._link.forget_late_requests(now_ns)
        self._put_stats(_encode(self.stats()))

    def _raise_flag(self) -> None:
        """Runs in Zenoh's threads; one flag is enough for any number of arrivals."""
        if self._flag.empty():
            self._flag.put(None)
