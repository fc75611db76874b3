"""CAN frames over Zenoh, and the client session that they need.

Key `<robot>/can/<bus>`; one put carries the frames of one tick, in order, as MessagePack
[sender, index of the first frame, [[identifier, data], ...]]. Receivers compare the index with what
they have had from that sender, so a lost frame is counted and never silent. Delivery is reliable
and ordered (TCP, blocking, real-time priority); while the hub is away the bus is off.

This file takes its time from the clock it is given; only a bus that a python-can tool opens by
itself (interface "ulna_zenoh") reads the monotonic clock here.
"""

import ctypes
import json
import os
import secrets
import threading
import time  # noqa: TID251  see above
from collections import deque
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from typing import TypeVar

import msgspec
import zenoh
from can.typechecking import CanFilters

from hal.buses.bus import Clock, TupleBus
from hal.errors import BusError
from hal.wire.can import Frame, Received

DEFAULT_ENDPOINT = "tcp/127.0.0.1:7447"
INBOX_LIMIT = 4096  # batches; 2 s of two busy senders at 1 kHz
LEASE_MS = 5000  # a frozen peer is noticed after this; a starved one must not be taken for it
RECONNECT = {"period_init_ms": 50, "period_max_ms": 500, "period_increase_factor": 1.5}
# What a consumer that stops reading may cost the others, once, before its link is closed [us].
CLOSE_STALLED_LINK_US = 50_000
# Threads of Zenoh's runtime. Every hand-over from thread to thread is a system call or two, and
# idle threads wake each other to look for work: a client gets by with two, and the hub does all
# but sending in its receiving threads (with Zenoh's own division its context switches are three
# times as many, and it takes half a processor instead of a third). In the hub a frozen consumer
# takes up to one receiving thread with it; with a single one it would stop all traffic, so there
# are spare ones.
THREADS_VARIABLE = "ZENOH_RUNTIME"
CLIENT_THREADS = (
    "(rx: (worker_threads: 1), tx: (worker_threads: 1), "
    "acc: (handover: rx), app: (handover: rx), net: (handover: rx))"
)
ROUTER_THREADS = (
    "(rx: (worker_threads: 4), tx: (worker_threads: 1), "
    "acc: (handover: rx), app: (handover: rx), net: (handover: rx))"
)

ItemT = TypeVar("ItemT")

_attached: set[int] = set()  # threads of Zenoh's that the interpreter knows for good

Batch = tuple[int, int, list[tuple[int, bytes]]]
_encode = msgspec.msgpack.Encoder().encode
_decode = msgspec.msgpack.Decoder(Batch).decode


class MonotonicClock:
    """For a bus opened outside Ulna's processes."""

    now_ns = staticmethod(time.monotonic_ns)


def base_settings(mode: str) -> dict[str, object]:
    """Settings that every session of Ulna shares: loopback-safe, no discovery, HLC time stamps."""
    return {
        "mode": mode,
        "scouting/multicast/enabled": False,
        "scouting/delay": 0,
        "timestamping/enabled": True,
        "transport/shared_memory/enabled": False,  # killed processes leave its files behind
        "transport/link/tx/lease": LEASE_MS,
        "transport/link/tx/queue/congestion_control/block/wait_before_close": CLOSE_STALLED_LINK_US,
    }


def open_session(settings: dict[str, object]) -> zenoh.Session:
    """Open a session; raises zenoh.ZError. The process's first one settles Zenoh's threads."""
    config = zenoh.Config()
    for path, value in settings.items():
        config.insert_json5(path, json.dumps(value))
    with _threads(ROUTER_THREADS if settings["mode"] == "router" else CLIENT_THREADS):
        return zenoh.open(config)


@contextmanager
def _threads(wanted: str) -> Iterator[None]:
    """Zenoh reads its threads from the environment only; child processes must not inherit ours."""
    if THREADS_VARIABLE in os.environ:  # the user's own choice
        yield
        return
    os.environ[THREADS_VARIABLE] = wanted
    try:
        yield
    finally:
        del os.environ[THREADS_VARIABLE]


def open_client(endpoint: str, timeout_s: float = 5.0) -> zenoh.Session:
    """Open a client session on the hub at `endpoint`; waits for the hub that long.

    The session finds the hub again after an outage. It must be closed, or the interpreter hangs.

    Raises:
        BusError: no hub there.
    """
    settings = base_settings("client") | {
        "connect/endpoints": [endpoint],
        "connect/timeout_ms": round(timeout_s * 1000),
        "connect/retry": RECONNECT,
    }
    try:
        return open_session(settings)
    except zenoh.ZError as error:
        raise BusError(
            f"no Zenoh hub answers at {endpoint} within {timeout_s:g} s: "
            "start the stack, or correct the endpoint"
        ) from error


def in_network_thread(
    take: Callable[[ItemT], None], drop: Callable[[], None] | None = None
) -> "zenoh.handlers.Callback[ItemT]":
    """Have `take` called in Zenoh's own thread, for each item: it must not wait.

    Zenoh attaches its thread to the interpreter for each call and detaches it again, which maps and
    unmaps memory; a thread that has attached itself once more stays: 40 % less work for each item.
    """

    def called(item: ItemT) -> None:
        thread = threading.get_ident()
        if thread not in _attached:
            _attached.add(thread)
            ctypes.pythonapi.PyGILState_Ensure()
        take(item)

    return zenoh.handlers.Callback(called, drop, indirect=False)


def close_session(session: zenoh.Session) -> None:
    """Close a session, which undeclares all that was declared on it."""
    session.close()  # type: ignore[no-untyped-call]  # untyped in zenoh's stubs


class ZenohBus(TupleBus):
    """One node's access to a CAN bus carried by Zenoh.

    Two buses of one session do not hear each other: give each node a session, as each process has.
    """

    def __init__(
        self,
        channel: str,
        can_filters: CanFilters | None = None,
        *,
        session: zenoh.Session | None = None,
        clock: Clock | None = None,
        endpoint: str = DEFAULT_ENDPOINT,
    ) -> None:
        """`channel` is "<robot>/<bus>", as icub/can2. Without a session the bus opens its own."""
        robot, separator, bus = channel.partition("/")
        if not separator:
            raise BusError(f"channel {channel!r} must read <robot>/<bus>, as icub/can2")
        self._own_session = open_client(endpoint) if session is None else None
        self._session = session or self._own_session or open_client(endpoint)
        self._now_ns = (clock or MonotonicClock()).now_ns
        self._inbox: deque[tuple[bytes, int]] = deque()
        self._sender = secrets.randbits(63)
        self._sent = 0
        self._expected: dict[int, int] = {}  # sender -> index of its next frame
        self._lost = 0
        self.unreadable = 0  # batches that were no batches
        self._waiting = False
        self._arrived = threading.Event()
        key = f"{robot}/can/{bus}"
        self._subscriber = self._session.declare_subscriber(
            key,
            in_network_thread(self._take),
            allowed_origin=zenoh.Locality.REMOTE,
        )
        self._publisher = self._session.declare_publisher(
            key,
            congestion_control=zenoh.CongestionControl.BLOCK,
            priority=zenoh.Priority.REAL_TIME,
            reliability=zenoh.Reliability.RELIABLE,
        )
        super().__init__(channel, can_filters)

    @property
    def frames_lost(self) -> int:
        """Gaps in what others sent, and frames that we could not send while the hub was away."""
        return self._lost

    def is_off(self) -> bool:
        """Whether the hub is away."""
        return self._session.is_closed() or not self._session.info.transports()

    def send_frames(self, frames: Sequence[Frame]) -> None:
        """Send the frames together; see FrameBus."""
        if not frames:
            return
        if self.is_off():
            self._lost += len(frames)
            return
        self._publisher.put(_encode((self._sender, self._sent, frames)))
        self._sent += len(frames)

    def receive_frames(self) -> list[Received]:
        """See FrameBus; the stamp is the instant at which the batch reached this process."""
        inbox = self._inbox
        frames: list[Received] = []
        while inbox:
            payload, stamp_ns = inbox.popleft()
            try:
                sender, index, batch = _decode(payload)
            except msgspec.DecodeError:
                self.unreadable += 1
                continue
            self._lost += max(0, index - self._expected.get(sender, index))
            self._expected[sender] = index + len(batch)
            frames += [(can_id, data, stamp_ns) for can_id, data in batch]
        return self._filtered(frames) if self._filters else frames

    def shutdown(self) -> None:
        """Leave the bus, and close the session if it is our own."""
        if not self._is_shutdown:
            super().shutdown()
            if not self._session.is_closed():
                self._subscriber.undeclare()  # type: ignore[no-untyped-call]  # so in zenoh's stubs
                self._publisher.undeclare()  # type: ignore[no-untyped-call]
            if self._own_session is not None:
                close_session(self._own_session)

    def _take(self, sample: zenoh.Sample) -> None:
        """Runs in Zenoh's thread: keep it short. Past the limit the gap in the index tells."""
        if len(self._inbox) < INBOX_LIMIT:
            self._inbox.append((sample.payload.to_bytes(), self._now_ns()))
        if self._waiting:
            self._arrived.set()

    def _wait(self, timeout_s: float | None) -> None:
        self._arrived.clear()
        self._waiting = True
        if not self._inbox:
            self._arrived.wait(timeout_s)
        self._waiting = False
