"""Ticks by the wall clock: absolute deadlines, catching up, slipping."""

from services.core.clock import NS_PER_MS, VirtualClock
from services.core.paced import PacedClock


def test_waits_for_every_tick_s_absolute_deadline() -> None:
    host = VirtualClock(5 * NS_PER_MS)
    paced = PacedClock(host)
    host.advance_ns(NS_PER_MS // 2)  # work in the tick
    paced.advance_ns(NS_PER_MS)
    assert paced.now_ns() == 6 * NS_PER_MS
    assert paced.slips == 0


def test_a_short_stall_is_caught_up() -> None:
    host = VirtualClock()
    paced = PacedClock(host)
    host.advance_ns(11 * NS_PER_MS)
    for _ in range(11):
        paced.advance_ns(NS_PER_MS)
    assert paced.now_ns() == 11 * NS_PER_MS
    assert host.now_ns() == 11 * NS_PER_MS
    paced.advance_ns(NS_PER_MS)
    assert paced.now_ns() == 12 * NS_PER_MS
    assert paced.slips == 0


def test_beyond_twenty_ticks_time_slips_and_is_counted() -> None:
    host = VirtualClock()
    paced = PacedClock(host)
    host.advance_ns(51 * NS_PER_MS)
    paced.advance_ns(NS_PER_MS)
    assert paced.slips == 30
    for _ in range(20):
        paced.advance_ns(NS_PER_MS)
    assert host.now_ns() == 51 * NS_PER_MS  # caught up, without a wait
