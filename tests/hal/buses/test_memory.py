from collections.abc import Iterator

import can
import pytest

from hal.buses.memory import Faults, MemoryBus, MemoryNetwork
from services.core.clock import NS_PER_MS, VirtualClock


class Wire:
    """Two nodes of one channel and the time."""

    def __init__(self) -> None:
        self.clock = VirtualClock()
        self.network = MemoryNetwork(self.clock)
        self.board = MemoryBus(self.network, "can2")
        self.host = MemoryBus(self.network, "can2")

    @property
    def faults(self) -> Faults:
        return self.network.faults("can2")

    def received(self) -> list[tuple[int, bytes]]:
        self.clock.advance_ns(NS_PER_MS)
        return [(can_id, data) for can_id, data, _ in self.host.receive_frames()]


@pytest.fixture
def wire() -> Iterator[Wire]:
    made = Wire()
    yield made
    made.board.shutdown()
    made.host.shutdown()


def test_a_frame_can_be_read_after_the_delay_and_not_before(wire: Wire) -> None:
    wire.board.send_frames([(0x100, b"\x01")])
    assert wire.host.receive_frames() == []
    wire.clock.advance_ns(NS_PER_MS - 1)
    assert wire.host.receive_frames() == []
    wire.clock.advance_ns(1)
    assert wire.host.receive_frames() == [(0x100, b"\x01", NS_PER_MS)]
    assert wire.host.receive_frames() == []


def test_receivers_cannot_spoil_each_others_frames(wire: Wire) -> None:
    guard = MemoryBus(wire.network, "can2")
    wire.board.send_frames([(0x100, b"\x01")])
    wire.clock.advance_ns(NS_PER_MS)
    guard.receive_frames().clear()
    assert len(wire.host.receive_frames()) == 1
    guard.shutdown()


def test_channels_do_not_mix(wire: Wire) -> None:
    other = MemoryBus(wire.network, "can3")
    wire.board.send_frames([(0x100, b"\x01")])
    wire.clock.advance_ns(NS_PER_MS)
    assert other.receive_frames() == []
    other.shutdown()


def test_recv_never_waits_for_virtual_time(wire: Wire) -> None:
    assert wire.host.recv(timeout=None) is None


def test_dropped_frames_are_counted_where_they_are_missed(wire: Wire) -> None:
    wire.faults.drop_next = 2
    wire.board.send_frames([(0x100, b"\x01"), (0x101, b"\x02"), (0x102, b"\x03")])
    assert wire.received() == [(0x102, b"\x03")]
    assert wire.host.frames_lost == 2
    assert wire.board.frames_lost == 0


def test_an_identifier_can_be_made_to_vanish(wire: Wire) -> None:
    wire.faults.drop_ids.add(0x3DA)
    for _ in range(2):
        wire.board.send_frames([(0x3DA, b"\x01"), (0x3DB, b"\x02")])
        assert wire.received() == [(0x3DB, b"\x02")]
    assert wire.host.frames_lost == 2


def test_corruption_inverts_the_data_and_is_not_a_loss(wire: Wire) -> None:
    wire.faults.corrupt_next = 1
    wire.board.send_frames([(0x100, b"\x0f\x00"), (0x100, b"\x0f\x00")])
    assert wire.received() == [(0x100, b"\xf0\xff"), (0x100, b"\x0f\x00")]
    assert wire.host.frames_lost == 0


def test_a_duplicated_frame_arrives_twice(wire: Wire) -> None:
    wire.faults.duplicate_next = 1
    wire.board.send_frames([(0x100, b"\x01"), (0x101, b"\x02")])
    assert wire.received() == [(0x100, b"\x01"), (0x100, b"\x01"), (0x101, b"\x02")]
    assert wire.host.frames_lost == 0


def test_extra_delay_adds_to_the_networks(wire: Wire) -> None:
    wire.faults.delay_ns = 2 * NS_PER_MS
    wire.board.send_frames([(0x100, b"\x01")])
    assert wire.received() == []
    assert wire.received() == []
    assert wire.received() == [(0x100, b"\x01")]


def test_a_channel_that_is_off_carries_nothing_and_every_node_sees_it(wire: Wire) -> None:
    wire.faults.bus_off = True
    wire.board.send_frames([(0x100, b"\x01")])
    assert wire.received() == []
    assert wire.board.frames_lost == 1
    assert wire.host.state is can.BusState.ERROR
    with pytest.raises(can.CanOperationError, match="is off"):
        wire.host.send(can.Message(arbitration_id=1, is_extended_id=False))
    wire.faults.bus_off = False
    wire.board.send_frames([(0x100, b"\x02")])
    assert wire.received() == [(0x100, b"\x02")]
    assert not wire.host.is_off()
