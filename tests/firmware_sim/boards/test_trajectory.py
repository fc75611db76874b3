"""References: moves, velocities, direct set-points."""

from hypothesis import given
from hypothesis import strategies as st

from firmware_sim.boards.trajectory import Reference
from tests.firmware_sim.boards.rows import row_of_words


def reference(ticks: int = 0) -> Reference:
    made = Reference()
    made.attach(row_of_words())
    made.boot()
    made.hold(ticks)
    return made


def advance(made: Reference, milliseconds: int) -> int:
    for _ in range(milliseconds):
        made.advance()
    return made.ticks


@given(st.integers(-5000, 5000), st.integers(-5000, 5000), st.integers(-10, 4000))
def test_a_move_ends_on_its_target_after_its_duration(start: int, end: int, speed: int) -> None:
    made = reference(start)
    made.start_move(end, speed)
    duration_ms = 100 * abs(end - start) // max(speed, 1)
    if duration_ms > 2000:
        return
    before = advance(made, max(duration_ms - 1, 0))
    assert min(start, end) <= before <= max(start, end)
    assert advance(made, 1) == end
    assert not made.active


def test_a_move_is_symmetric_in_time() -> None:
    made = reference(1000)
    made.start_move(1400, 100)
    way = [advance(made, 1) - 1000 for _ in range(400)]
    assert all(abs(way[t - 1] + way[400 - t - 1] - 400) <= 1 for t in range(1, 400))


def test_a_new_move_starts_from_the_present_reference() -> None:
    made = reference()
    made.start_move(400, 100)
    assert advance(made, 200) == 200
    made.start_move(0, 100)  # 200 ticks: 200 ms
    assert advance(made, 100) == 100
    assert advance(made, 100) == 0


def test_a_mixed_axis_adds_its_velocity_to_its_move() -> None:
    made = reference()
    made.start_move(400, 100)
    made.start_velocity(16, 1000)  # 1 tick/ms
    assert advance(made, 400) == 800


def test_velocity_stops_at_the_limit_and_comes_back_from_outside() -> None:
    made = reference(4990)
    made.start_velocity(16, 1000)
    assert advance(made, 50) == 5000
    made.hold(5100)
    made.start_velocity(16, 1000)
    assert advance(made, 10) == 5100
    made.start_velocity(-16, 1000)
    assert advance(made, 10) == 5090


def test_velocity_ramps_down_after_the_time_out() -> None:
    made = reference()
    made.velocity_timeout_ms = 10
    made.start_velocity(16, 4)
    advance(made, 10)
    assert made.velocity == 16
    velocities = []
    for _ in range(5):
        advance(made, 1)
        velocities.append(made.velocity)
    assert velocities == [12, 8, 4, 0, 0]
    assert not made.active


def test_fractions_are_symmetric() -> None:
    up, down = reference(), reference()
    up.start_velocity(5, 1000)
    down.start_velocity(-5, 1000)
    for _ in range(100):
        assert advance(up, 1) == -advance(down, 1)
    assert up.ticks == 5 * 100 // 16
