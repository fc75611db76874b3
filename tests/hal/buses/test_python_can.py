"""Any python-can bus as a bus of ours."""

from collections.abc import Iterator

import can
import pytest

from hal.buses.python_can import PythonCanBus
from hal.errors import BusError


class Standing:
    """A clock that stands at 7 ns."""

    def now_ns(self) -> int:
        return 7


@pytest.fixture
def ours(request: pytest.FixtureRequest) -> Iterator[PythonCanBus]:
    bus = PythonCanBus("virtual", request.node.name, Standing())
    yield bus
    bus.shutdown()


@pytest.fixture
def other(request: pytest.FixtureRequest) -> Iterator[can.BusABC]:
    with can.Bus(interface="virtual", channel=request.node.name) as bus:
        yield bus


def test_frames_go_both_ways_in_order(ours: PythonCanBus, other: can.BusABC) -> None:
    ours.send_frames([(0x101, b"\x01"), (0x7FF, b"")])
    sent = [other.recv(1.0), other.recv(1.0)]
    assert [(m.arbitration_id, bytes(m.data), m.is_extended_id) for m in sent if m] == [
        (0x101, b"\x01", False),
        (0x7FF, b"", False),
    ]
    other.send(can.Message(arbitration_id=0x20, data=b"ab", is_extended_id=False))
    assert ours.receive_frames() == [(0x20, b"ab", 7)]
    assert ours.receive_frames() == []


def test_frames_that_the_protocol_has_not_are_passed_over_and_counted(
    ours: PythonCanBus, other: can.BusABC
) -> None:
    other.send(can.Message(arbitration_id=0x12345, is_extended_id=True))
    other.send(can.Message(arbitration_id=0x20, is_extended_id=False, is_remote_frame=True))
    other.send(can.Message(arbitration_id=0x21, is_extended_id=False))
    assert ours.receive_frames() == [(0x21, b"", 7)]
    assert ours.foreign == 2


def test_a_bus_that_works_is_active_and_has_lost_nothing(ours: PythonCanBus) -> None:
    assert ours.state is can.BusState.ACTIVE
    assert ours.frames_lost == 0


def test_a_frame_that_is_filtered_out_does_not_hide_the_next(
    ours: PythonCanBus, other: can.BusABC
) -> None:
    ours.set_filters([{"can_id": 0x20, "can_mask": 0x7FF}])
    other.send(can.Message(arbitration_id=0x21, is_extended_id=False))
    other.send(can.Message(arbitration_id=0x20, is_extended_id=False))
    assert ours.receive_frames() == [(0x20, b"", 7)]


def test_an_unknown_interface_is_refused_with_the_known_ones() -> None:
    with pytest.raises(BusError, match=r"cannot open interface 'nocan', .* socketcan"):
        PythonCanBus("nocan", "x", Standing())
