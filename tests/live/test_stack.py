"""The supervisor with a hub and toy processes: start, watch, stop, and every way to die."""

import os
import signal
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import pytest

from services.core.client import Client
from services.core.clock import NS_PER_S, RealClock
from services.core.errors import (
    AlreadyRunningError,
    CallFailedError,
    HubUnreachableError,
    NotRunningError,
    ProcessDiedError,
)
from services.core.rundir import read_record
from services.processes import HUB, Process
from services.stack import Stack
from services.streams import STATS
from tests.live.toy_streams import FAREWELL, ORDER, PING, PONG, SETTING, Done, Order, Ping

pytestmark = pytest.mark.live

ECHO = Process("echo", "tests.live.toy_echo")
ROBOT = Process("robot", "tests.live.toy_robot")
PATIENCE_S = 10.0


def wait_for(condition: Callable[[], object], seconds: float = PATIENCE_S) -> None:
    clock = RealClock()
    give_up_ns = clock.now_ns() + round(seconds * NS_PER_S)
    while not condition():
        assert clock.now_ns() < give_up_ns, "waited in vain"
        clock.sleep_until(clock.now_ns() + 5_000_000)


def is_running(pid: int) -> bool:
    """Whether a process is there and not just waiting to be buried."""
    try:
        state = Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[0]
    except FileNotFoundError:
        return False
    return state != "Z"


def stack_of(*rows: Process, report: Callable[[str], None] | None = None) -> Stack:
    return Stack("icub", name="toys", rows=(HUB, *rows), report=report)


def test_messages_calls_and_last_values_reach_a_process_and_come_back() -> None:
    with stack_of(ECHO) as stack:
        client = stack.client
        assert client.alive() == {"hub", "echo"}
        client.watch(PONG)
        assert client.call(ORDER, Order("hello")) == Done("hello, setting -1")
        pings = tuple(Ping(number, number) for number in range(50))
        for ping in pings:
            client.put(PING, ping)
        echoed: list[Ping] = []

        def all_back() -> bool:
            echoed.extend(client.new(PONG))
            return len(echoed) >= len(pings)

        wait_for(all_back)
        assert tuple(echoed) == pings


def test_a_late_joiner_is_given_the_last_occasional_value() -> None:
    with stack_of() as stack:
        stack.client.put(SETTING, Ping(0, 41))
        stack.client.put(SETTING, Ping(0, 42))
        with Client("icub", stack.endpoint, RealClock()) as late:
            wait_for(lambda: late.latest(SETTING) == Ping(0, 42))


def test_a_request_that_nobody_answers_fails_with_the_reason() -> None:
    with stack_of(ECHO) as stack:
        with pytest.raises(CallFailedError, match="toy/order: Timeout"):
            stack.client.call(ORDER, Order("ignore"), timeout_s=0.2)
        assert stack.client.call(ORDER, Order("hello")).text == "hello, setting -1"
    with stack_of() as stack, pytest.raises(CallFailedError, match="nobody answers toy/order"):
        stack.client.call(ORDER, Order("hello"))


def test_a_process_reports_how_it_keeps_its_time() -> None:
    with stack_of(ROBOT) as stack:
        stats = STATS["robot"]
        wait_for(lambda: stack.client.latest(stats))
        latest = stack.client.latest(stats)
        assert latest is not None
        assert latest.process == "robot"
        assert 80 <= latest.steps <= 120  # a second of 10 ms periods
        assert latest.step_ms_p99 >= latest.step_ms_p50 > 0
        assert latest.scheduler in ("SCHED_FIFO 50", "nice 0 (SCHED_FIFO not permitted)")


def test_stopping_closes_every_service_and_leaves_nothing_behind() -> None:
    stack = stack_of(ECHO, ROBOT)
    with stack:
        pids = stack.pids
        assert set(pids) == {"hub", "echo", "robot"}
        assert read_record("toys").endpoint == stack.endpoint
    assert not any(is_running(pid) for pid in pids.values())
    with pytest.raises(NotRunningError):
        read_record("toys")


def test_stopping_first_has_the_robot_bring_the_limbs_down(own_run_directory: Path) -> None:
    reports: list[str] = []
    with stack_of(ROBOT, report=reports.append):
        pass
    assert "bringing the limbs down; Ctrl-C again idles them at once" in reports
    assert "orders ['stop'], phase idle" in robot_log(own_run_directory)


def test_ctrl_c_stops_and_a_second_one_idles_at_once(own_run_directory: Path) -> None:
    supervisor, pids = start_supervisor()
    supervisor.send_signal(signal.SIGINT)
    wait_for(lambda: "order stop" in robot_log(own_run_directory))
    supervisor.send_signal(signal.SIGINT)
    output, _ = supervisor.communicate(timeout=PATIENCE_S)
    assert supervisor.returncode == 0
    assert "idle at once" in output
    assert "orders ['stop', 'idle'], phase idle" in robot_log(own_run_directory)
    assert not any(is_running(pid) for pid in pids)


def test_nothing_outlives_a_supervisor_that_is_killed() -> None:
    supervisor, pids = start_supervisor()
    assert all(is_running(pid) for pid in pids)
    supervisor.kill()
    supervisor.communicate(timeout=PATIENCE_S)
    wait_for(lambda: not any(is_running(pid) for pid in pids))
    with stack_of():  # and the name is free again
        pass


def test_a_second_stack_of_the_name_is_refused_with_the_pid_of_the_first() -> None:
    with stack_of() as first:
        with pytest.raises(
            AlreadyRunningError, match=f"'toys' is already running .pid {os.getpid()}"
        ):
            stack_of().start()
        assert first.client.alive() == {"hub"}


@pytest.mark.parametrize("victim", ["hub", "echo", "robot"])
def test_a_process_that_dies_is_named_with_its_status(victim: str) -> None:
    reports: list[str] = []
    with stack_of(ECHO, ROBOT, report=reports.append) as stack:
        pids = stack.pids
        os.kill(pids[victim], signal.SIGKILL)
        with pytest.raises(ProcessDiedError, match=f"'{victim}' ended with signal SIGKILL"):
            stack.wait()
    assert not any(is_running(pid) for pid in pids.values())
    text = "\n".join(reports)
    assert ("the hub is gone" in text) == (victim == "hub")
    assert ("the robot process is gone" in text) == (victim == "robot")
    assert ("bringing the limbs down" in text) == (victim == "echo")


def test_an_error_in_a_step_closes_the_service_and_ends_the_process() -> None:
    with stack_of(ECHO) as stack:
        client = stack.client
        client.watch(FAREWELL)
        with pytest.raises(CallFailedError):
            client.call(ORDER, Order("fail"), timeout_s=2.0)
        with pytest.raises(ProcessDiedError, match="'echo' ended with exit status 1") as caught:
            stack.wait()
        assert "ValueError: told to fail" in caught.value.log_tail
        assert client.latest(FAREWELL) is not None


def test_a_process_that_cannot_start_fails_the_start_and_leaves_nothing() -> None:
    stack = stack_of(ECHO, Process("broken", "tests.live.no_such_module"))
    with pytest.raises(ProcessDiedError, match="'broken' ended with exit status 1") as caught:
        stack.start()
    assert "No module named" in caught.value.log_tail
    assert stack.pids == {}
    with stack_of():
        pass


def test_a_process_that_does_not_listen_is_ended_by_force(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("services.stack.FORCE_AFTER_S", 0.5)
    reports: list[str] = []
    with stack_of(ECHO, report=reports.append) as stack:
        pids = stack.pids
        stack.client.call(ORDER, Order("deaf"))
    assert "echo did not stop well: signal SIGKILL" in reports
    assert not any(is_running(pid) for pid in pids.values())


def test_a_client_without_a_hub_is_told_so() -> None:
    with pytest.raises(HubUnreachableError, match="no Zenoh hub answers"):
        Client("icub", "tcp/127.0.0.1:9", RealClock(), timeout_s=0.2)


def robot_log(directory: Path) -> str:
    return (directory / "toys" / "robot.log").read_text()


def start_supervisor() -> tuple[subprocess.Popen[str], list[int]]:
    """A supervisor of its own process, once its stack is up."""
    supervisor = subprocess.Popen(
        [sys.executable, "-m", "tests.live.toy_supervisor"], stdout=subprocess.PIPE, text=True
    )
    assert supervisor.stdout is not None
    return supervisor, [int(word) for word in supervisor.stdout.readline().split()]
