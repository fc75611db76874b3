import pytest

from services.core.clock import RealClock, VirtualClock


def test_virtual_time_moves_only_when_told() -> None:
    clock = VirtualClock(start_ns=5)
    assert clock.now_ns() == 5
    clock.advance_ns(10)
    clock.sleep_until(12)
    assert clock.now_ns() == 15
    clock.sleep_until(20)
    assert clock.now_ns() == 20
    with pytest.raises(ValueError, match="cannot go back by 1 ns"):
        clock.advance_ns(-1)


def test_real_time_waits_for_the_deadline() -> None:
    clock = RealClock()
    deadline_ns = clock.now_ns() + 2_000_000
    clock.sleep_until(deadline_ns)
    assert clock.now_ns() >= deadline_ns
    clock.sleep_until(deadline_ns)  # has passed: returns at once
    assert clock.now_ns() < deadline_ns + 1_000_000_000
