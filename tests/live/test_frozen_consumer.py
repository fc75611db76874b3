"""One process that stops reading must not hold up the others for longer than a loop can bear."""

import os
import signal
from itertools import pairwise

import pytest

from hal.buses.zenoh import ZenohBus
from services.core.clock import NS_PER_MS, NS_PER_S, RealClock
from services.processes import HUB, Process
from services.stack import Stack

pytestmark = pytest.mark.live

ROWS = (HUB, Process("echo", "tests.live.toy_echo"))  # it holds bus 2 open and never reads it
FRAMES = [(0x100 + i % 16, bytes(8)) for i in range(600)]  # fills the sockets' buffers in a second
LONGEST_GAP_NS = 150 * NS_PER_MS  # 50 ms are the hub's; the rest is the machine's


def test_a_frozen_consumer_is_cut_off_and_the_others_go_on() -> None:
    clock = RealClock()
    with Stack("icub", name="frozen", rows=ROWS) as stack:
        with (
            ZenohBus("icub/can2", endpoint=stack.endpoint, clock=clock) as sender,
            ZenohBus("icub/can2", endpoint=stack.endpoint, clock=clock) as receiver,
        ):
            pid = stack.pids["echo"]
            os.kill(pid, signal.SIGSTOP)
            try:
                arrivals_ns = exchange(sender, receiver, clock)
            finally:
                os.kill(pid, signal.SIGCONT)
        gaps_ns = [after - before for before, after in pairwise(arrivals_ns)]
        assert len(arrivals_ns) > 2000
        assert max(gaps_ns) < LONGEST_GAP_NS
        assert receiver.frames_lost == 0


def exchange(sender: ZenohBus, receiver: ZenohBus, clock: RealClock) -> list[int]:
    """Send one big batch a millisecond for three seconds; when each batch arrived."""
    arrivals_ns: list[int] = []
    deadline_ns = clock.now_ns()
    end_ns = deadline_ns + 3 * NS_PER_S
    while deadline_ns < end_ns:
        deadline_ns += NS_PER_MS
        clock.sleep_until(deadline_ns)
        sender.send_frames(FRAMES)
        arrivals_ns += [frame[2] for frame in receiver.receive_frames()[:: len(FRAMES)]]
    return arrivals_ns
