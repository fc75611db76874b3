"""The guard service: what it refuses, and that bad requests do not end it."""

import pytest

from hal.buses.memory import MemoryBus, MemoryNetwork
from services.core.clock import VirtualClock
from services.core.testing import Bench
from services.guard import GuardService
from services.messages import Reply
from services.robot_messages import RobotRequest, RobotStatus
from services.robotfile.robot_tables import RobotFile
from services.streams import GUARD_CALL, ROBOT_STATUS


@pytest.fixture
def bench(robot: RobotFile) -> Bench:
    clock = VirtualClock()
    network = MemoryNetwork(clock, 1_000_000)
    buses = {bus.number: MemoryBus(network, bus.channel) for bus in robot.buses.values()}
    return Bench(GuardService(robot, buses), clock)


def heartbeat(phase: str) -> RobotStatus:
    return RobotStatus(
        stamp_ns=0,
        phase=phase,
        calibrated=True,
        compliant=(),
        faults=(),
        fault_count=0,
        frames_received=0,
        frames_sent=0,
        frames_lost=0,
        frames_dropped=0,
    )


def ask(bench: Bench, request: RobotRequest) -> Reply:
    bench.request(GUARD_CALL, request)
    bench.advance(0.01)
    return bench.replies(GUARD_CALL)[-1][1]


def test_stop_of_an_unknown_joint_is_refused_by_name(bench: Bench) -> None:
    for q_rad in ((), (0.1,)):
        reply = ask(bench, RobotRequest(action="stop", joints=("tail",), q_rad=q_rad))
        assert not reply.ok
        assert "tail" in reply.reason


def test_other_actions_are_refused(bench: Bench) -> None:
    reply = ask(bench, RobotRequest(action="calibrate"))
    assert not reply.ok
    assert "calibrate" in reply.reason


@pytest.mark.parametrize(("phase", "acts"), [("ready", 1), ("idle", 0)])
def test_acts_once_per_silence_and_only_on_a_powered_robot(
    bench: Bench, caplog: pytest.LogCaptureFixture, phase: str, acts: int
) -> None:
    bench.put(ROBOT_STATUS, heartbeat(phase))
    bench.advance(0.05)
    assert caplog.text == ""
    bench.advance(1.0)
    assert caplog.text.count("joints made stiff") == acts
