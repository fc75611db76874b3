"""The guard: own bus handles, silent until asked."""

import math

import pytest

from hal.guarding import Guard
from hal.tasks import Task
from tests.hal.arm import BUS, DESCRIPTION
from tests.hal.scripted import MS, ScriptedBus, frame, text


class Watch:
    """A guard, its bus and its time; stepped each 10 ms as the service does it."""

    def __init__(self) -> None:
        self.bus = ScriptedBus()
        self.guard = Guard(DESCRIPTION, {BUS: self.bus})
        self.bus.wrench = []

    @property
    def now_ns(self) -> int:
        return self.bus.ms * MS

    def tick(self, count: int = 1) -> list[str]:
        self.bus.sent.clear()
        for _ in range(count):
            self.bus.ms += 3
            self.guard.step(self.now_ns + MS)
        return [text(sent) for sent in self.bus.sent]

    def finish(self, task: Task) -> None:
        for _ in range(1000):
            if task.done:
                return
            self.tick()
        raise AssertionError(task.action)


@pytest.fixture
def watch() -> Watch:
    return Watch()


def test_lets_in_positions_states_and_replies_only(watch: Watch) -> None:
    assert watch.bus.filters == [
        {"can_id": 0x101, "can_mask": 0x70F},
        {"can_id": 0x103, "can_mask": 0x70F},
        {"can_id": 0x10C, "can_mask": 0x70F},
        {"can_id": 0x000, "can_mask": 0x70F},
    ]


def test_sends_nothing_until_asked(watch: Watch) -> None:
    assert watch.tick(300) == []


def test_makes_every_axis_stiff_that_could_be_compliant_at_once(watch: Watch) -> None:
    task = watch.guard.make_stiff(watch.now_ns)

    assert [text(sent) for sent in watch.bus.sent] == ["001 7400", "001 75", "001 F400", "001 F5"]
    watch.bus.inbox += [frame("010 750000"), frame("11C 00")]
    watch.tick()
    assert (task.done, task.ok) == (True, True)


def test_insists_until_the_board_confirms(watch: Watch) -> None:
    task = watch.guard.make_stiff(watch.now_ns)

    assert watch.tick(16).count("001 7400") == 3
    watch.finish(task)
    assert task.reason == "pitch did not become stiff; roll did not become stiff"


def test_does_not_rely_on_what_it_heard_before_it_was_asked(watch: Watch) -> None:
    watch.bus.inbox += [frame("11C 00")]
    watch.tick()
    task = watch.guard.make_stiff(watch.now_ns)
    watch.tick()

    assert not task.done


def test_stops_the_axes_that_are_powered(watch: Watch) -> None:
    answers = {
        "001 38": "010 38010801",  # calibrated, direct, compliant
        "001 75": "010 750000",
        "001 0901": "113 0001000000000000",
        "001 0909": "113 0000000000000000",
    }
    watch.bus.answers = {frame(question): frame(answer) for question, answer in answers.items()}
    watch.tick(2)
    task = watch.guard.stop(watch.now_ns, ["pitch"], [math.radians(-1.0)])
    sent: list[str] = []
    while not task.done:
        sent += watch.tick()

    assert task.ok
    assert [one for one in sent if one[4:6] in ("74", "09", "1B")] == [
        "001 7400",
        "001 0901",
        "001 1BD20700002400",  # to 2002
        "001 0909",
    ]


def test_switches_everything_off_at_once(watch: Watch) -> None:
    watch.guard.idle_all(watch.now_ns)

    assert [text(sent) for sent in watch.bus.sent][:4] == [
        "001 0909",
        "001 8909",
        "003 0909",
        "004 0909",
    ]


def test_ends_what_it_was_doing_when_asked_for_something_else(watch: Watch) -> None:
    task = watch.guard.make_stiff(watch.now_ns)
    watch.guard.idle_all(watch.now_ns)

    assert task.reason == "ended by idle"
