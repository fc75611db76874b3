"""Where a preview has objects later."""

import math

import numpy as np

from services.core.clock import NS_PER_S
from services.fields.preview import moved_on
from services.fields.seen import as_obstacle
from services.fields.sources import Sources
from services.messages import Objects, WorldObject

SIGMA_M = 0.005


def noisy(sources: Sources, now_ns: int, place: np.ndarray) -> None:
    x, y, z = place.tolist()
    variance = SIGMA_M**2
    item = WorldObject(
        name="ball",
        shape="sphere",
        size_m=(0.04,),
        position_m=(x, y, z),
        covariance_m2=(variance, 0.0, 0.0, variance, 0.0, variance),
    )
    sources.take(now_ns, Objects(stamp_ns=now_ns, objects=(item,), source="eyes"))


def test_a_slow_ball_that_is_seen_with_noise_is_kept_clear_of_where_it_will_be() -> None:
    sources, rng = Sources(), np.random.default_rng(0)
    off_m = []
    for i in range(240):
        now_ns = NS_PER_S + round(i / 30 * NS_PER_S)
        noisy(sources, now_ns, np.array((0.03 * i / 30, 0.0, 0.0)) + rng.normal(0.0, SIGMA_M, 3))
        if i >= 90:
            (later,) = moved_on(sources.seen(now_ns), 15.0)
            true_m = (0.03 * (i / 30 + 15.0), 0.0, 0.0)
            off_m.append(math.dist(as_obstacle(later).position_m, true_m))
    assert max(off_m) < 0.2


def test_what_is_kept_clear_of_goes_as_far_as_what_is_followed() -> None:
    sources, rng = Sources(), np.random.default_rng(0)
    for i in range(60):
        now_ns = NS_PER_S + round(i / 30 * NS_PER_S)
        place = np.array((0.2 * i / 30, 0.0, 0.0)) + rng.normal(0.0, SIGMA_M, 3)
        noisy(sources, now_ns, place)
    now = sources.seen(now_ns)
    (later,) = moved_on(now, 5.0)
    assert later.avoided is not None
    assert now[0].avoided is not None
    went = np.array(later.place_m) - now[0].place_m
    kept_went = np.array(later.avoided.position_m) - now[0].avoided.position_m
    np.testing.assert_allclose(kept_went, went, atol=1e-12)
    assert went[0] > 0.8
