"""What the sources have sent, over time."""

from itertools import pairwise

import msgspec
import pytest

from services.core.clock import NS_PER_MS, NS_PER_S
from services.core.errors import ConfigError
from services.fields.client_objects import ObjectShelf, objects_message
from services.fields.seen import SIGMAS, WIDEST_M, SeenObject, as_obstacle
from services.fields.sources import Sources, find_object
from services.fields.tracked import SourceClock
from services.messages import Objects, Vector3, WorldObject

STILL = (0.0, 0.0, 0.0)


def ball(name: str, place: Vector3, **more: object) -> WorldObject:
    plain = WorldObject(
        name=name, shape="sphere", size_m=(0.05,), position_m=place, velocity_m_s=STILL
    )
    return msgspec.structs.replace(plain, **more)


def send(sources: Sources, now_ns: int, *items: WorldObject, source: str = "eyes") -> list[str]:
    return sources.take(now_ns, Objects(stamp_ns=now_ns, objects=items, source=source))


def names(sources: Sources, now_ns: int = 0) -> list[str]:
    return [f"{one.source}/{one.name}" for one in sources.seen(now_ns)]


def test_a_message_takes_the_place_of_all_that_its_source_sent_and_of_nothing_else() -> None:
    sources = Sources()
    send(sources, 0, ball("a", STILL), ball("b", STILL))
    send(sources, 0, ball("c", STILL), source="hand")
    send(sources, 1, ball("b", STILL))
    assert names(sources) == ["eyes/b", "hand/c"]
    send(sources, 2)
    assert names(sources) == ["hand/c"]


def test_an_object_that_is_none_keeps_its_last_good_state_and_the_others_are_taken() -> None:
    sources = Sources()
    send(sources, 0, ball("a", (0.1, 0.0, 0.0)), ball("b", (0.2, 0.0, 0.0)))
    problems = send(
        sources, 1, ball("a", (float("nan"), 0.0, 0.0)), ball("b", (0.3, 0.0, 0.0)),
        ball("new", (float("inf"), 0.0, 0.0)),
    )  # fmt: skip
    assert len(problems) == 2
    places = {one.name: one.place_m[0] for one in sources.seen(1)}
    assert places == {"a": 0.1, "b": 0.3}


def test_of_two_objects_of_one_name_the_first_counts() -> None:
    sources = Sources()
    problems = send(sources, 0, ball("a", (0.1, 0.0, 0.0)), ball("a", (0.2, 0.0, 0.0)))
    assert problems == ["object 'a': twice in one message; the first counts"]
    assert [one.place_m[0] for one in sources.seen(0)] == [0.1]


def test_there_is_room_for_64_objects_of_all_sources_together() -> None:
    sources = Sources()
    send(sources, 0, *(ball(str(i), STILL) for i in range(60)))
    problems = send(sources, 0, *(ball(str(i), STILL) for i in range(5)), source="hand")
    assert problems == ["object '4': more than 64 objects"]
    assert len(sources.seen(0)) == 64


def test_two_sources_may_use_one_name() -> None:
    sources = Sources()
    send(sources, 0, ball("ball", (0.1, 0.0, 0.0)))
    send(sources, 0, ball("ball", (0.2, 0.0, 0.0)), source="hand")
    seen = sources.seen(0)
    second = find_object(seen, "hand/ball")
    assert second is not None
    assert second.place_m[0] == 0.2
    assert find_object(seen, "cube") is None


def test_a_velocity_that_is_not_sent_is_estimated_from_exact_positions() -> None:
    sources = Sources()
    for i in range(31):
        now_ns = 1 + i * 33 * NS_PER_MS
        send(sources, now_ns, ball("a", (0.1 * now_ns / NS_PER_S, 0.0, 0.0), velocity_m_s=None))
    (seen,) = sources.seen(now_ns)
    assert seen.velocity_m_s[0] == pytest.approx(0.1, abs=0.01)
    assert seen.place_m[0] == pytest.approx(0.099, abs=1e-6)  # exact: as it was sent
    assert seen.sigma_m == 0.0


def test_an_exact_object_that_jumps_once_is_where_it_was_sent_to_be() -> None:
    sources = Sources()
    for i in range(10):
        send(sources, 1 + i * 33 * NS_PER_MS, ball("a", STILL, velocity_m_s=None))
    jump_ns = 400 * NS_PER_MS
    send(sources, jump_ns, ball("a", (0.5, 0.0, 0.0), velocity_m_s=None))
    for later_ns in (jump_ns, jump_ns + NS_PER_S):
        (seen,) = sources.seen(later_ns)
        assert seen.place_m == (0.5, 0.0, 0.0)
        assert seen.velocity_m_s == STILL


def test_a_position_with_a_covariance_is_filtered_and_keeps_a_sigma() -> None:
    sources = Sources()
    covariance = (1e-4, 0.0, 0.0, 1e-4, 0.0, 1e-4)  # 1 cm
    for i in range(60):
        wobble = 0.01 if i % 2 else -0.01
        now_ns = 1 + i * 33 * NS_PER_MS
        item = ball("a", (0.3 + wobble, 0.0, 0.0), velocity_m_s=None, covariance_m2=covariance)
        send(sources, now_ns, item)
    (seen,) = sources.seen(now_ns)
    assert seen.place_m[0] == pytest.approx(0.3, abs=0.005)
    assert 0.0 < seen.sigma_m < 0.01


def test_an_object_at_rest_stays_when_its_source_dies() -> None:
    sources = Sources()
    send(sources, 0, ball("a", (0.1, 0.0, 0.0)))
    (seen,) = sources.seen(60 * NS_PER_S)
    assert (seen.place_m, seen.lost) == ((0.1, 0.0, 0.0), "")
    assert seen.age_s == pytest.approx(60.0)


def test_an_object_in_motion_goes_on_for_a_moment_and_is_then_lost() -> None:
    sources = Sources()
    send(sources, 0, ball("a", STILL, velocity_m_s=(0.2, 0.0, 0.0)))
    (soon,) = sources.seen(100 * NS_PER_MS)
    assert soon.place_m[0] == pytest.approx(0.02)
    assert soon.lost == ""
    (late,) = sources.seen(2 * NS_PER_S)
    assert late.place_m[0] == pytest.approx(0.06)  # 0.3 s on
    assert late.velocity_m_s == STILL
    assert late.lost == "last seen 2.0 s ago, at 0.20 m/s"


def extent_m(seen: SeenObject) -> tuple[float, float]:
    """What is kept clear of along x."""
    obstacle = as_obstacle(seen)
    half_m = obstacle.size_m[0] + obstacle.margin_m
    return obstacle.position_m[0] - half_m, obstacle.position_m[0] + half_m


@pytest.mark.parametrize("speed_m_s", [0.1, 0.35, 2.0])
def test_the_room_around_what_is_lost_grows_from_what_it_was_and_never_shrinks(
    speed_m_s: float,
) -> None:
    sources = Sources()
    send(sources, 0, ball("a", STILL, velocity_m_s=(speed_m_s, 0.0, 0.0)))
    extents = []
    for after_ms in (300, 301, 310, 400, 1000, 10_000):
        (seen,) = sources.seen(after_ms * NS_PER_MS)
        assert bool(seen.lost) == (after_ms > 300)
        extents.append(extent_m(seen))
    rear = [round(low, 9) for low, _ in extents]
    front = [round(high, 9) for _, high in extents]
    assert rear == sorted(rear, reverse=True)
    assert front == sorted(front)
    assert front[1] - front[0] < 0.0025  # 1 ms at up to 2 m/s
    assert front[-1] - rear[-1] == pytest.approx(2 * (0.05 + WIDEST_M))
    assert seen.sigma_m == pytest.approx(WIDEST_M / SIGMAS)


def test_the_room_around_what_hardly_moved_when_it_was_last_seen_stays_as_it_was() -> None:
    sources = Sources()
    send(sources, 0, ball("a", STILL, velocity_m_s=(0.015, 0.0, 0.0)))
    extents = []
    for after_ms in (300, 310, 10_000):
        (seen,) = sources.seen(after_ms * NS_PER_MS)
        assert seen.lost == ""
        extents.append(extent_m(seen))
    assert extents[1] == pytest.approx(extents[0])
    assert extents[2] == extents[1]


def test_a_source_is_forgotten_and_an_unknown_one_is_an_error() -> None:
    sources = Sources()
    send(sources, 0, ball("a", STILL), ball("b", STILL))
    assert sources.forget("eyes") == 2
    assert sources.seen(0) == ()
    with pytest.raises(ConfigError, match=r"no source 'eyes' of objects; there are: none"):
        sources.forget("eyes")


def test_what_a_source_sent_is_told_as_it_was_sent() -> None:
    sources = Sources()
    item = ball("a", (0.1, 0.0, 0.0))
    send(sources, 0, item)
    (info,) = sources.info(NS_PER_S)
    assert (info.source, info.objects, info.age_s) == ("eyes", (item,), 1.0)


class Client:
    """One source by the Python client's shelf, on the service's own clock."""

    def __init__(self) -> None:
        self.now_ns = NS_PER_S
        self.sources = Sources()
        self.shelf = ObjectShelf(self._publish, lambda: self.now_ns)

    def _publish(self, items: tuple[WorldObject, ...]) -> None:
        self.sources.take(self.now_ns, objects_message(self.now_ns, "python", items))

    def seen(self, name: str) -> SeenObject:
        found = find_object(self.sources.seen(self.now_ns), name)
        assert found is not None
        return found


NOISY = (1e-4, 0.0, 0.0, 1e-4, 0.0, 1e-4)  # 1 cm


def test_two_objects_of_one_client_that_are_moved_in_turn_both_have_their_speed() -> None:
    client = Client()
    handles = [client.shelf.add(ball(name, STILL, velocity_m_s=None)) for name in "ab"]
    for _ in range(60):
        client.now_ns += 33 * NS_PER_MS
        for handle in handles:
            client.now_ns += NS_PER_MS
            handle.move((0.2 * (client.now_ns / NS_PER_S - 1.0), 0.0, 0.0))
    speeds = [client.seen(name).velocity_m_s[0] for name in "ab"]
    assert speeds == pytest.approx([0.2, 0.2], abs=0.01)


def test_one_sighting_does_not_get_surer_by_being_published_again() -> None:
    client = Client()
    client.shelf.add(ball("once", (0.5, 0.0, 0.0), velocity_m_s=None, covariance_m2=NOISY))
    other = client.shelf.add(ball("other", STILL))
    for i in range(300):
        client.now_ns += 10 * NS_PER_MS
        other.move((0.0005 * i, 0.0, 0.0))
    assert client.seen("once").sigma_m >= 0.01
    assert client.seen("once").age_s == pytest.approx(3.0)


def test_what_is_published_again_without_a_stamp_of_its_own_is_no_new_measurement() -> None:
    sources = Sources()
    once = ball("once", (0.5, 0.0, 0.0), velocity_m_s=None, covariance_m2=NOISY)
    exact = ball("exact", STILL, velocity_m_s=None)
    for i in range(120):  # the exact one comes anew every 40 ms, and in between again
        now_ns = NS_PER_S + 20 * i * NS_PER_MS
        if i % 2 == 0:
            place = (0.2 * i * 0.02, 0.0, 0.0)
            exact = msgspec.structs.replace(exact, position_m=place)
        send(sources, now_ns, once, exact)
    seen = {one.name: one for one in sources.seen(now_ns)}
    assert seen["once"].sigma_m >= 0.01
    assert seen["exact"].velocity_m_s[0] == pytest.approx(0.2, abs=0.01)


def test_an_exact_object_that_is_sent_to_be_where_it_was_comes_to_rest() -> None:
    sources = Sources()
    for i in range(60):
        now_ns = NS_PER_S + 33 * i * NS_PER_MS
        place = (0.2 * 0.033 * min(i, 30), 0.0, 0.0)
        send(sources, now_ns, ball("a", place, velocity_m_s=None))
    (seen,) = sources.seen(now_ns)
    assert seen.velocity_m_s[0] == pytest.approx(0.0, abs=0.02)
    assert seen.lost == ""


def test_what_is_switched_off_without_being_seen_again_is_off() -> None:
    client = Client()
    handle = client.shelf.add(ball("a", STILL, velocity_m_s=None, covariance_m2=NOISY))
    client.now_ns += 100 * NS_PER_MS
    handle.switch(on=False)
    assert not client.seen("a").on
    assert client.seen("a").age_s == pytest.approx(0.1)


def test_stamps_take_the_jitter_out_of_arrivals() -> None:
    clock = SourceClock()
    offset_ns = 5 * NS_PER_S
    made = [1 + i * 10 * NS_PER_MS for i in range(20)]
    late = [3 * NS_PER_MS if i % 3 else 0 for i in range(20)]
    found = [
        clock.time_ns(stamp + offset_ns + delay, stamp)
        for stamp, delay in zip(made, late, strict=True)
    ]
    steps = {round((b - a) / NS_PER_MS, 1) for a, b in pairwise(found[1:])}
    assert steps == {10.0}


@pytest.mark.parametrize("rate", [1.0, 1.0 - 2e-4, 0.99, 0.9])
def test_a_sender_s_slower_clock_does_not_make_its_messages_old(rate: float) -> None:
    clock = SourceClock()
    oldest_ns = 0
    for i in range(12_000):  # 20 min
        now_ns = 100 * NS_PER_S + i * 100 * NS_PER_MS
        made_ns = clock.time_ns(now_ns, round(50 * NS_PER_S + rate * i * 100 * NS_PER_MS))
        oldest_ns = max(oldest_ns, now_ns - made_ns)
    assert oldest_ns <= 150 * NS_PER_MS


def test_messages_that_were_held_up_once_and_come_together_keep_their_own_times() -> None:
    clock = SourceClock()
    offset_ns = 5 * NS_PER_S
    for i in range(20):
        made_ns = NS_PER_S + 10 * i * NS_PER_MS
        clock.time_ns(made_ns + offset_ns, made_ns)
    held = [NS_PER_S + 10 * i * NS_PER_MS for i in range(20, 45)]
    together_ns = held[-1] + offset_ns
    for made_ns in held:  # the first of them 240 ms late
        found_ns = clock.time_ns(together_ns, made_ns)
        assert found_ns == pytest.approx(made_ns + offset_ns, abs=0.1 * NS_PER_MS)


def test_stamps_that_stand_still_are_no_clock() -> None:
    clock = SourceClock()
    assert clock.time_ns(1000, 0) == 1000
    assert clock.time_ns(2000, 0) == 2000


@pytest.mark.parametrize("rate_hz", [30.0, 100.0])
def test_an_exact_object_that_falls_is_kept_clear_of_at_its_speed(rate_hz: float) -> None:
    sources = Sources()
    shares = []
    for k in range(round(0.6 * rate_hz)):
        t_s = k / rate_hz
        fallen = ball("a", (0.0, 0.0, 1.0 - 4.905 * t_s**2), velocity_m_s=None)
        now_ns = round(t_s * NS_PER_S) + NS_PER_S
        sources.take(now_ns, Objects(stamp_ns=now_ns, source="eyes", objects=(fallen,)))
        (seen,) = sources.seen(now_ns)
        assert seen.avoided is not None
        if t_s > 0.15:
            shares.append(-seen.avoided.velocity_m_s[2] / (9.81 * t_s))
    assert min(shares) > 0.5
    assert sorted(shares)[len(shares) // 2] > 0.85
