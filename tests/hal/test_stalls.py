"""Ages without the time that the process itself lost."""

from hal.stalls import Stalls

MS = 1_000_000


def stepped(*instants_ms: int) -> Stalls:
    stalls = Stalls()
    for instant_ms in instants_ms:
        stalls.note(instant_ms * MS)
    return stalls


def test_age_is_the_difference_while_steps_are_regular() -> None:
    stalls = stepped(0, 1, 2, 3)
    assert stalls.age_ns(3 * MS, 1 * MS) == 2 * MS
    assert stalls.count == 0


def test_own_stall_is_left_out() -> None:
    stalls = stepped(0, 1, 131, 132)
    assert stalls.count == 1
    assert stalls.age_ns(132 * MS, 0) == 2 * MS


def test_stall_before_the_stamp_does_not_count() -> None:
    stalls = stepped(0, 1, 131, 132)
    assert stalls.age_ns(140 * MS, 132 * MS) == 8 * MS


def test_stamp_from_within_the_stall_is_not_younger_than_its_end() -> None:
    stalls = stepped(0, 1, 131, 132)
    assert stalls.age_ns(135 * MS, 100 * MS) == 4 * MS


def test_silence_after_a_stall_still_grows() -> None:
    stalls = stepped(0, 1, 131)
    assert stalls.age_ns(231 * MS, 1 * MS) == 100 * MS


def test_a_process_that_is_slow_all_the_time_hides_nothing_from_itself() -> None:
    stalls = stepped(*range(0, 400, 20))
    assert stalls.count == 19
    assert stalls.age_ns(380 * MS, 0) == 360 * MS
