"""The boards process: faults on request."""

from collections.abc import Iterator

import msgspec
import pytest

from firmware_sim.rig import Rig
from hal.buses.memory import MemoryBus, MemoryNetwork
from services.boards import Boards
from services.config import load_robot
from services.core.clock import VirtualClock
from services.core.testing import Bench
from services.emulated.emulation import rig_spec
from services.emulated.messages import FaultRequest, PushRequest
from services.messages import Reply
from services.streams import FAULT_CALL, PUSH_CALL


@pytest.fixture(scope="module")
def bench() -> Iterator[Bench]:
    robot = load_robot("icub:torso")
    clock = VirtualClock()
    network = MemoryNetwork(clock)
    buses = {bus.number: MemoryBus(network, bus.channel) for bus in robot.buses.values()}
    yield Bench(Boards(Rig(rig_spec(robot, 0)), buses, 50), clock)
    for bus in buses.values():
        bus.shutdown()


def asked(bench: Bench, request: FaultRequest) -> Reply:
    token = bench.request(FAULT_CALL, request)
    bench.advance(0.002)
    return dict(bench.replies(FAULT_CALL))[token]


def test_switches_a_fault_on_and_off_and_says_so(bench: Bench) -> None:
    encoder = FaultRequest(kind="encoder", bus=0, address=6, axis=1)
    assert asked(bench, encoder) == Reply(
        ok=True, reason="encoder at bus 0 address 6 axis 1: absolute encoder unreadable"
    )
    off = FaultRequest(kind="encoder", bus=0, address=6, axis=1, on=False)
    assert asked(bench, off) == Reply(ok=True, reason="encoder off at bus 0 address 6 axis 1")
    assert asked(bench, off) == Reply(
        ok=False, reason="encoder is not on at bus 0 address 6 axis 1"
    )


@pytest.mark.parametrize(
    ("request_", "reason"),
    [
        (FaultRequest(kind="gremlins"), "unknown fault 'gremlins'; known: drop, corrupt, "),
        (FaultRequest(kind="encoder", bus=0, address=6), "encoder needs axis (bus, address, axis)"),
        (FaultRequest(kind="drop"), "drop needs bus, or board (bus and address)"),
        (FaultRequest(kind="drop", bus=7), "no emulated board on bus 7; buses: 0"),
        (FaultRequest(kind="no_power", bus=0, address=9), "no board at bus 0 address 9; boards: "),
        (FaultRequest(kind="freeze", bus=0, address=6), "freeze needs FT board (bus, address); "),
        (FaultRequest(kind="delay", bus=0), "delay needs milliseconds, at least 1"),
        (FaultRequest(kind="drop", bus=0, share=0.0), "a share is above 0 and at most 1; "),
        (FaultRequest(kind="encoder", bus=0, address=6, axis=2), "bus 0 address 6 axis 2: an "),
        (FaultRequest(kind="hall", bus=0, address=6, axis=0, value=8), "Hall code 8 is not one of"),
        (FaultRequest(kind="estop", value=1), "estop takes no value"),
    ],
)
def test_says_why_a_fault_cannot_be_switched(
    bench: Bench, request_: FaultRequest, reason: str
) -> None:
    reply = asked(bench, request_)
    assert not reply.ok
    assert reply.reason.startswith(reason)


def test_pushes_a_link_that_it_is_told_and_no_other(bench: Bench) -> None:
    push = PushRequest(force_n=(0.0, 30.0, 0.0), duration_s=0.1, frame="chest")
    token = bench.request(PUSH_CALL, push)
    bench.advance(0.002)
    assert dict(bench.replies(PUSH_CALL))[token] == Reply(ok=True)
    strange = msgspec.structs.replace(push, frame="tail")
    token = bench.request(PUSH_CALL, strange)
    bench.advance(0.002)
    refusal = dict(bench.replies(PUSH_CALL))[token]
    assert refusal == Reply(
        ok=False, reason="cannot push at 'tail': the model has no such link or joint"
    )
