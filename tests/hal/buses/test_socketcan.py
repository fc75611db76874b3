"""What only SocketCAN has: a kernel that may drop frames, interfaces that go down."""

import socket
import struct
import subprocess
from collections.abc import Iterator

import can
import pytest

from hal.buses.socketcan import SocketCanBus, interfaces_up
from hal.errors import BusError
from services.core.clock import RealClock

CHANNEL = "vcan8"
FRAME = struct.Struct("=IB3x8s")

pytestmark = pytest.mark.live
needs_vcan = pytest.mark.skipif(
    not interfaces_up([CHANNEL]),
    reason=f"this kernel has no SocketCAN interface {CHANNEL} that is up",
)


@pytest.fixture
def bus() -> Iterator[SocketCanBus]:
    with SocketCanBus(CHANNEL, RealClock()) as opened:
        yield opened


@pytest.fixture
def raw() -> Iterator[socket.socket]:
    with socket.socket(socket.AF_CAN, socket.SOCK_RAW, socket.CAN_RAW) as opened:
        opened.bind((CHANNEL,))
        yield opened


def test_an_interface_that_is_not_there_is_told_with_the_remedy() -> None:
    with pytest.raises(BusError, match=r"vcan77: .*(ulna can up|--can zenoh)"):
        SocketCanBus("vcan77", RealClock())


def test_interfaces_up_is_false_where_one_is_missing() -> None:
    assert not interfaces_up(["vcan77"])


@needs_vcan
def test_counts_what_the_kernel_drops(raw: socket.socket) -> None:
    with SocketCanBus(CHANNEL, RealClock()) as bus:
        bus._socket.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 1)  # the kernel's least
        for number in range(1000):
            raw.send(FRAME.pack(0x100, 2, number.to_bytes(2, "big")))
        kept = len(bus.receive_frames())
        raw.send(FRAME.pack(0x101, 0, b""))
        assert len(bus.receive_frames()) == 1
        assert 0 < kept < 1000
        assert bus.frames_lost == 1000 - kept


@needs_vcan
def test_stamps_are_the_kernels_on_our_clock(bus: SocketCanBus, raw: socket.socket) -> None:
    clock = RealClock()
    bus.receive_frames()
    before_ns = clock.now_ns()
    raw.send(FRAME.pack(0x100, 0, b""))
    after_ns = clock.now_ns()
    clock.sleep_until(after_ns + 20_000_000)
    ((_, _, stamp_ns),) = bus.receive_frames()
    slack_ns = 1_000_000  # between two looks at two clocks
    assert before_ns - slack_ns <= stamp_ns <= after_ns + slack_ns


@needs_vcan
def test_frames_of_other_kinds_are_not_ours(bus: SocketCanBus, raw: socket.socket) -> None:
    raw.send(FRAME.pack(0x100 | socket.CAN_RTR_FLAG, 0, b""))
    raw.send(FRAME.pack(0x12345 | socket.CAN_EFF_FLAG, 0, b""))
    raw.send(FRAME.pack(0x102, 0, b""))
    assert [can_id for can_id, _, _ in bus.receive_frames()] == [0x102]


@needs_vcan
def test_bus_off_and_restart_are_seen(bus: SocketCanBus, raw: socket.socket) -> None:
    raw.send(FRAME.pack(0x040 | socket.CAN_ERR_FLAG, 8, bytes(8)))
    assert bus.receive_frames() == []
    assert bus.state is can.BusState.ERROR
    raw.send(FRAME.pack(0x100 | socket.CAN_ERR_FLAG, 8, bytes(8)))
    assert bus.receive_frames() == []
    assert not bus.is_off()


@needs_vcan
def test_an_interface_that_goes_down_is_off_until_it_is_up_again(bus: SocketCanBus) -> None:
    subprocess.run(["ip", "link", "set", CHANNEL, "down"], check=True)
    try:
        bus.send_frames([(0x100, b""), (0x101, b"")])
        assert bus.state is can.BusState.ERROR
        assert bus.frames_lost == 2
        assert bus.receive_frames() == []
    finally:
        subprocess.run(["ip", "link", "set", CHANNEL, "up"], check=True)
    assert not bus.is_off()
    bus.send_frames([(0x100, b"")])
    assert bus.frames_lost == 2
