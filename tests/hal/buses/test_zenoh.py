"""What only the Zenoh bus has: batches with an index, a hub that may go away, a plug-in name."""

from collections.abc import Callable, Iterator
from importlib.metadata import entry_points

import can
import msgspec
import pytest
import zenoh

from hal.buses.zenoh import ZenohBus, close_session, open_client
from hal.errors import BusError
from services.core.clock import RealClock
from services.core.session import Hub, open_hub

pytestmark = pytest.mark.live

PATIENCE_NS = 5_000_000_000
KEY = "icub/can/can2"


@pytest.fixture
def hub() -> Iterator[Hub]:
    with open_hub() as opened:
        yield opened


@pytest.fixture
def bus(hub: Hub) -> Iterator[ZenohBus]:
    with ZenohBus("icub/can2", endpoint=hub.endpoint) as opened:
        yield opened


@pytest.fixture
def foreign(hub: Hub) -> Iterator[zenoh.Session]:
    """A session of somebody who puts what he likes."""
    session = open_client(hub.endpoint)
    yield session
    close_session(session)


def wait_for(condition: Callable[[], bool]) -> None:
    clock = RealClock()
    give_up_ns = clock.now_ns() + PATIENCE_NS
    while not condition():
        assert clock.now_ns() < give_up_ns, "waited in vain"
        clock.sleep_until(clock.now_ns() + 1_000_000)


def put(session: zenoh.Session, payload: object) -> None:
    session.put(KEY, msgspec.msgpack.encode(payload))


def received(bus: ZenohBus, count: int) -> list[int]:
    frames: list[int] = []

    def enough() -> bool:
        frames.extend(can_id for can_id, _, _ in bus.receive_frames())
        return len(frames) >= count

    wait_for(enough)
    return frames


def test_a_gap_in_the_index_is_a_loss(bus: ZenohBus, foreign: zenoh.Session) -> None:
    put(foreign, (1, 100, [(0x100, b""), (0x101, b"")]))
    put(foreign, (1, 102, [(0x102, b"")]))
    assert received(bus, 3) == [0x100, 0x101, 0x102]
    assert bus.frames_lost == 0  # whoever comes late has not lost what was before
    put(foreign, (1, 110, [(0x103, b"")]))
    put(foreign, (2, 0, [(0x104, b"")]))
    assert received(bus, 2) == [0x103, 0x104]
    assert bus.frames_lost == 7


def test_bytes_that_are_no_batch_are_counted_and_do_no_harm(
    bus: ZenohBus, foreign: zenoh.Session
) -> None:
    foreign.put(KEY, b"")
    foreign.put(KEY, b"\xff\xff")
    put(foreign, {"a": 1})
    put(foreign, (1, 0, [(0x100, b"\x01")]))
    assert received(bus, 1) == [0x100]
    assert bus.unreadable == 3


def test_the_bus_is_off_while_the_hub_is_away_and_comes_back() -> None:
    hub = open_hub()
    endpoint = hub.endpoint
    with ZenohBus("icub/can2", endpoint=endpoint) as bus:
        bus.send_frames([(0x100, b"")])
        hub.close()
        wait_for(bus.is_off)
        assert bus.state is can.BusState.ERROR
        bus.send_frames([(0x100, b""), (0x101, b"")])
        assert bus.frames_lost == 2
        with open_hub(endpoint):
            wait_for(lambda: not bus.is_off())
            assert not bus.is_off()
            with ZenohBus("icub/can2", endpoint=endpoint) as other:
                wait_for(lambda: _sends(bus, other))
                assert bus.frames_lost == 2


def _sends(sender: ZenohBus, receiver: ZenohBus) -> bool:
    sender.send_frames([(0x105, b"")])
    return bool(receiver.receive_frames())


@pytest.mark.skipif(
    not entry_points(group="can.interface", name="ulna_zenoh"),
    reason="ulna is not installed here, so python-can cannot find its plug-in",
)
def test_python_can_opens_it_by_name(hub: Hub) -> None:
    with can.Bus(interface="ulna_zenoh", channel="icub/can2", endpoint=hub.endpoint) as bus:
        assert isinstance(bus, ZenohBus)
        assert bus.recv(0.01) is None


def test_a_missing_hub_is_told_with_the_remedy() -> None:
    with pytest.raises(
        BusError, match=r"no Zenoh hub answers at tcp/127\.0\.0\.1:9 .*start the stack"
    ):
        open_client("tcp/127.0.0.1:9", timeout_s=0.2)


def test_a_channel_names_robot_and_bus() -> None:
    with pytest.raises(BusError, match="must read <robot>/<bus>"):
        ZenohBus("can2")
