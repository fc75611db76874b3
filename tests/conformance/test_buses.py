"""One suite over every CAN bus: what a board or the HAL may rely on, whoever carries its frames."""

from collections.abc import Callable, Iterator
from contextlib import ExitStack

import can
import pytest

from hal.buses.bus import TupleBus
from hal.buses.memory import MemoryBus, MemoryNetwork
from hal.buses.socketcan import SocketCanBus, interfaces_up
from hal.buses.zenoh import ZenohBus
from hal.wire.can import Frame, Received
from services.core.clock import RealClock, VirtualClock
from services.core.session import open_hub

DELAY_NS = 1_000_000
PATIENCE_S = 2.0
CHANNELS = {"memory": "can2", "zenoh": "icub/can2", "socketcan": "vcan9"}

Opener = Callable[[], TupleBus]


@pytest.fixture(scope="module")
def hub_endpoint() -> Iterator[str]:
    with open_hub("tcp/127.0.0.1:0") as hub:
        yield hub.endpoint


@pytest.fixture(
    params=[
        "memory",
        pytest.param("zenoh", marks=pytest.mark.live),
        pytest.param("socketcan", marks=pytest.mark.live),
    ]
)
def open_bus(request: pytest.FixtureRequest) -> Iterator[Opener]:
    """Opens another bus object of one and the same channel."""
    kind: str = request.param
    channel = CHANNELS[kind]
    with ExitStack() as stack:
        opener: Opener
        if kind == "memory":
            network = MemoryNetwork(VirtualClock(), delay_ns=0)
            opener = lambda: MemoryBus(network, channel)  # noqa: E731
        elif kind == "zenoh":
            endpoint: str = request.getfixturevalue("hub_endpoint")
            opener = lambda: ZenohBus(channel, endpoint=endpoint)  # noqa: E731
        elif interfaces_up([channel]):
            opener = lambda: SocketCanBus(channel, RealClock())  # noqa: E731
        else:
            pytest.skip(f"this kernel has no SocketCAN interface {channel} that is up")
        yield lambda: stack.enter_context(opener())


def receive(bus: TupleBus, count: int) -> list[Received]:
    """The next `count` frames, or fewer when they do not come."""
    frames = bus.receive_frames()
    clock = RealClock()
    give_up_ns = clock.now_ns() + round(PATIENCE_S * 1e9)
    while len(frames) < count and clock.now_ns() < give_up_ns:
        clock.sleep_until(clock.now_ns() + 200_000)
        frames += bus.receive_frames()
        if isinstance(bus, MemoryBus):
            break
    return frames


def bare(frames: list[Received]) -> list[Frame]:
    return [(can_id, data) for can_id, data, _ in frames]


def settle(sender: TupleBus, *others: TupleBus) -> None:
    """Return when each of the others hears the sender: Zenoh spreads subscriptions by and by."""
    for other in others:
        for attempt in range(1000):
            sender.send_frames([(0x7FF, bytes([attempt % 256]))])
            if other.recv(0.01) is not None:
                break
    sender.send_frames([(0x7FE, b"")])
    for other in others:
        while (message := other.recv(PATIENCE_S)) is not None and message.arbitration_id != 0x7FE:
            pass


def test_carries_frames_in_order_to_every_other_node(open_bus: Opener) -> None:
    board, host, guard = open_bus(), open_bus(), open_bus()
    settle(board, host, guard)
    frames = [(0x300 + i % 16, bytes([i % 256] * (i % 9))) for i in range(100)]
    for start in range(0, 100, 10):
        board.send_frames(frames[start : start + 10])
    assert bare(receive(host, 100)) == frames
    assert bare(receive(guard, 100)) == frames


def test_does_not_hear_itself(open_bus: Opener) -> None:
    board, host = open_bus(), open_bus()
    settle(board, host)
    board.send_frames([(0x101, b"\x01")])
    assert bare(receive(host, 1)) == [(0x101, b"\x01")]
    assert board.receive_frames() == []


def test_speaks_both_ways(open_bus: Opener) -> None:
    board, host = open_bus(), open_bus()
    settle(board, host)
    settle(host, board)
    host.send_frames([(0x005, b"\x08")])
    assert bare(receive(board, 1)) == [(0x005, b"\x08")]
    board.send_frames([(0x050, b"\x08\x01")])
    assert bare(receive(host, 1)) == [(0x050, b"\x08\x01")]


def test_returns_nothing_at_once_when_nothing_came(open_bus: Opener) -> None:
    bus = open_bus()
    assert bus.receive_frames() == []
    assert bus.recv(0) is None


def test_python_can_messages_and_tuples_are_the_same_frames(open_bus: Opener) -> None:
    board, host = open_bus(), open_bus()
    settle(board, host)
    message = can.Message(arbitration_id=0x3DA, data=b"\x01\x02", is_extended_id=False)
    board.send(message)
    assert bare(receive(host, 1)) == [(0x3DA, b"\x01\x02")]
    board.send_frames([(0x3DB, b"\x03")])
    received = host.recv(PATIENCE_S)
    assert received is not None
    assert (received.arbitration_id, bytes(received.data)) == (0x3DB, b"\x03")
    assert not received.is_extended_id


def test_filters_pass_only_what_matches(open_bus: Opener) -> None:
    board, host = open_bus(), open_bus()
    settle(board, host)
    host.set_filters([{"can_id": 0x300, "can_mask": 0x700}])
    board.send_frames([(0x100, b""), (0x3DA, b"\x01"), (0x200, b""), (0x30B, b"\x02")])
    assert bare(receive(host, 2)) == [(0x3DA, b"\x01"), (0x30B, b"\x02")]
    host.set_filters(None)
    board.send_frames([(0x100, b"\x05")])
    assert bare(receive(host, 1)) == [(0x100, b"\x05")]


def test_loses_nothing_in_a_burst(open_bus: Opener) -> None:
    board, host = open_bus(), open_bus()
    settle(board, host)
    for start in range(0, 4000, 40):
        board.send_frames([(0x300, (start + i).to_bytes(4, "big")) for i in range(40)])
    received = receive(host, 4000)
    assert [int.from_bytes(data, "big") for _, data, _ in received] == list(range(4000))
    assert host.frames_lost == 0
    assert board.frames_lost == 0


def test_stamps_do_not_go_back_and_are_not_in_the_future(open_bus: Opener) -> None:
    board, host = open_bus(), open_bus()
    settle(board, host)
    clock = VirtualClock() if isinstance(host, MemoryBus) else RealClock()
    before_ns = clock.now_ns()
    board.send_frames([(0x300, b"\x01")])
    board.send_frames([(0x300, b"\x02")])
    first, second = receive(host, 2)
    assert before_ns <= first[2] <= second[2] <= clock.now_ns()


@pytest.mark.parametrize(
    "message",
    [
        can.Message(arbitration_id=0x12345, is_extended_id=True),
        can.Message(arbitration_id=0x100, is_extended_id=False, is_remote_frame=True),
        can.Message(arbitration_id=0x100, is_extended_id=False, is_fd=True, data=bytes(12)),
    ],
    ids=["extended", "remote", "fd"],
)
def test_refuses_frames_that_the_protocol_has_not(open_bus: Opener, message: can.Message) -> None:
    bus = open_bus()
    with pytest.raises(can.CanOperationError, match="only 11-bit data frames"):
        bus.send(message)


def test_is_active_while_it_works(open_bus: Opener) -> None:
    assert open_bus().state is can.BusState.ACTIVE


def test_may_be_shut_down_twice(open_bus: Opener) -> None:
    bus = open_bus()
    bus.shutdown()
    bus.shutdown()
