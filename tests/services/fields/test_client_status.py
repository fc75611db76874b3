"""The field's status as a client hears it: waiting, giving up, and a field that falls silent."""

import asyncio
import threading

import pytest

from services.core.clock import NS_PER_S, Clock, RealClock, VirtualClock
from services.core.errors import ServiceError
from services.fields.client_status import StatusWatch, Wanted
from services.fields.messages import FieldStatus
from services.reaching.client_types import WaitTimeoutError

LONG_S = 20.0


def status(clock: Clock, state: str, last_goal: int = 1) -> FieldStatus:
    return FieldStatus(
        stamp_ns=clock.now_ns(),
        mode="ulna",
        gains=(),
        limb="right_arm",
        state=state,
        last_goal=last_goal,
    )


@pytest.fixture
def clock() -> VirtualClock:
    return VirtualClock(5 * NS_PER_S)


@pytest.fixture
def watch(clock: VirtualClock) -> StatusWatch:
    return StatusWatch("icub", clock)


def wait(watch: StatusWatch, *states: str, goal: int = 0, timeout_s: float = 0.0) -> FieldStatus:
    return watch.wait(Wanted.checked(states, goal), timeout_s)


def test_a_state_counts_once_its_goal_has_been_taken_up(
    watch: StatusWatch, clock: VirtualClock
) -> None:
    watch.hear(status(clock, "arrived", last_goal=1))
    assert wait(watch, goal=1).state == "arrived"
    with pytest.raises(WaitTimeoutError, match=r"after 0 s the field is arrived"):
        wait(watch, goal=2)


def test_a_status_that_comes_meanwhile_ends_the_wait(
    watch: StatusWatch, clock: VirtualClock
) -> None:
    comes = threading.Thread(target=watch.hear, args=(status(clock, "arrived"),))
    comes.start()
    assert wait(watch, timeout_s=LONG_S).state == "arrived"
    comes.join()


def test_a_field_that_falls_silent_during_a_wait_is_said_to_be_silent(
    watch: StatusWatch, clock: VirtualClock
) -> None:
    watch.hear(status(clock, "reaching"))
    silence = threading.Thread(target=clock.advance_ns, args=(3 * NS_PER_S,))
    silence.start()
    with pytest.raises(ServiceError, match="no field process in stack 'icub'"):
        wait(watch, timeout_s=0.5)
    silence.join()


def test_the_last_word_of_a_field_that_is_silent_is_not_its_state(
    watch: StatusWatch, clock: VirtualClock
) -> None:
    watch.hear(status(clock, "arrived"))
    clock.advance_ns(NS_PER_S)
    assert watch.newest().state == "arrived"
    clock.advance_ns(1)
    with pytest.raises(ServiceError, match="no field process"):
        wait(watch)


def test_no_such_state_is_refused_with_those_there_are() -> None:
    with pytest.raises(ServiceError, match="no state 'there'; there are idle, reaching"):
        Wanted.checked(("there",), 0)


def test_an_awaited_wait_ends_as_a_blocking_one() -> None:
    clock = RealClock()
    watch = StatusWatch("icub", clock)
    watch.hear(status(clock, "reaching"))
    found = asyncio.run(watch.wait_awaited(Wanted.checked(("reaching",), 0), 0.0))
    assert found.state == "reaching"
    with pytest.raises(WaitTimeoutError, match=r"after 0\.2 s the field is reaching"):
        asyncio.run(watch.wait_awaited(Wanted.checked((), 0), 0.2))


def test_a_wait_that_is_given_up_keeps_no_thread_waiting() -> None:
    clock = RealClock()
    watch = StatusWatch("icub", clock)

    async def give_up() -> None:
        with pytest.raises(TimeoutError):
            await asyncio.wait_for(watch.wait_awaited(Wanted.checked((), 0), LONG_S), 0.05)

    begun_ns = clock.now_ns()
    asyncio.run(give_up())  # ends with its threads
    assert clock.now_ns() - begun_ns < 0.25 * LONG_S * NS_PER_S
