"""One object over time: as it was sent, or filtered where its place or speed is not known exactly.

A position without covariance is exact and taken as it is; only a velocity that is not sent is
estimated. A position with one is filtered.
"""

import math
from dataclasses import dataclass, replace

import numpy as np

from dforc.arrays import Matrix
from dforc.collision.obstacles import Obstacle, Triple
from dforc.field.tracking import ObjectTracker, Sample
from services.core.clock import NS_PER_MS, NS_PER_S
from services.fields.object_checks import covariance_matrix
from services.fields.seen import SeenObject, Sighting, solid_of
from services.messages import WorldObject

PREDICTED_S = 0.3  # that an object is taken to go on as it moved, once it is seen no more
MOVING_M_S = 0.02  # what moved faster than this when it was seen last may be anywhere
EXACT_SIGMA_M = 0.001  # of positions from which a velocity is estimated
# A source sends all that it has when one object changes. What has no stamp of its own and comes
# again to the last bit is no new measurement: no camera repeats its noise, and what is exact is
# taken to stand only if it does so for longer than a camera's period.
REPEATED_NS = 50 * NS_PER_MS
SMALLEST_VARIANCE_M2 = 1e-10
AGED_PER_S = 1e-4  # drift of a sender's clock against ours, at most; of most clocks, that is
LATEST_NS = 100 * NS_PER_MS  # what is later than this, for longer, comes by a slower clock
STILL: Triple = (0.0, 0.0, 0.0)


@dataclass(frozen=True, slots=True, eq=False)
class TrackedObject:
    """What is known of an object. Its tracker is the only part that changes in place."""

    item: WorldObject
    solid: Obstacle  # where it was sent to be
    seen_ns: int
    tracker: ObjectTracker | None  # None: place and velocity were sent, exactly
    believed: bool  # False: the newest position is an outlier, unless nothing more comes

    @classmethod
    def first(cls, seen_ns: int, item: WorldObject) -> "TrackedObject":
        """An object that was not known; it has passed the checks."""
        return cls._seen(seen_ns, item, None)

    def updated(self, seen_ns: int, item: WorldObject) -> "TrackedObject":
        """The same object, seen again; it has passed the checks."""
        if self._is_repeated(seen_ns, item):
            return self if item == self.item else replace(self, item=item, solid=solid_of(item))
        if item == self.item and self.tracker is None:
            return replace(self, seen_ns=seen_ns)
        noisy_before = self.item.covariance_m2 is not None
        keeps = noisy_before == (item.covariance_m2 is not None)
        return self._seen(seen_ns, item, self.tracker if keeps else None)

    def _is_repeated(self, seen_ns: int, item: WorldObject) -> bool:
        """Whether it says of the place what is known, and does not say that it was seen again."""
        if item.seen_ns not in (0, self.item.seen_ns) or measured(item) != measured(self.item):
            return False
        if item.seen_ns or item.covariance_m2 is not None:
            return True
        return seen_ns - self.seen_ns < REPEATED_NS

    def at(self, now_ns: int, source: str) -> SeenObject:
        """Where it is taken to be now."""
        age_s = max(0.0, (now_ns - self.seen_ns) / NS_PER_S)
        ahead_s = min(age_s, PREDICTED_S)
        place = self._predicted(ahead_s, avoided=False)
        avoided = None if self.tracker is None else self._predicted(ahead_s, avoided=True)
        lost = ""
        if age_s > PREDICTED_S:
            speed_m_s, since_s = math.hypot(*place.velocity_m_s), 0.0
            if not self.believed:
                place = place._replace(position_m=self.solid.position_m, velocity_m_s=STILL)
                avoided = None
            elif speed_m_s > MOVING_M_S:
                lost = f"last seen {age_s:.1f} s ago, at {speed_m_s:.2f} m/s"
                since_s = age_s - PREDICTED_S
            avoided = (avoided or place).given_up(since_s)
            sigma_m = max(place.sigma_m, avoided.sigma_m) if lost else place.sigma_m
            place = place._replace(velocity_m_s=STILL, sigma_m=sigma_m)
        solid = self.solid
        if (place.position_m, place.velocity_m_s) != (solid.position_m, solid.velocity_m_s):
            solid = replace(solid, position_m=place.position_m, velocity_m_s=place.velocity_m_s)
        return SeenObject(
            name=self.item.name,
            source=source,
            solid=solid,
            role=self.item.role,
            on=self.item.on,
            sigma_m=place.sigma_m,
            avoided=avoided,
            age_s=age_s,
            lost=lost,
        )

    @classmethod
    def _seen(
        cls, seen_ns: int, item: WorldObject, tracker: ObjectTracker | None
    ) -> "TrackedObject":
        solid, covariance = solid_of(item), item.covariance_m2
        if covariance is None and item.velocity_m_s is not None:
            return cls(item, solid, seen_ns, None, believed=True)
        tracker = tracker or ObjectTracker(EXACT_SIGMA_M)
        taken = tracker.update(
            seen_ns / NS_PER_S,
            solid.position_m,
            None if covariance is None else positive(covariance_matrix(covariance)),
            item.velocity_m_s,
        )
        return cls(item, solid, seen_ns, tracker, believed=taken is not Sample.SKIPPED)

    def _predicted(self, ahead_s: float, *, avoided: bool) -> Sighting:
        """Some time after it was seen: as it is best followed, or as it is kept clear of."""
        sent_m = self.solid.position_m
        if self.tracker is None:
            return Sighting(sent_m, self.item.velocity_m_s or STILL, 0.0).after(ahead_s)
        at_s = self.seen_ns / NS_PER_S + ahead_s
        state = self.tracker.avoided_at(at_s) if avoided else self.tracker.at(at_s)
        u, v, w = state.velocity_m_s.tolist()
        if self.item.covariance_m2 is not None:
            x, y, z = state.position_m.tolist()
            return Sighting((x, y, z), (u, v, w), state.sigma_m)
        # An exact place is believed at once; its speed not before another sample agrees.
        moves = self.believed or avoided
        return Sighting(sent_m, (u, v, w) if moves else STILL, 0.0).after(ahead_s)


class SourceClock:
    """A sender's stamps as our time: arrivals come late by turns, stamps do not.

    Stamps that stand still or go back are no clock: then the arrival counts.
    """

    def __init__(self) -> None:
        self._stamp_ns = 0
        self._offset_ns: float | None = None
        self._late_ns: int | None = None  # since when messages come later than they may

    def time_ns(self, now_ns: int, stamp_ns: int) -> int:
        """When a message was made, at the latest now."""
        elapsed_ns, self._stamp_ns = stamp_ns - self._stamp_ns, stamp_ns
        if stamp_ns <= 0 or elapsed_ns <= 0:
            self._offset_ns = None
            return now_ns
        offset_ns = float(now_ns - stamp_ns)
        if self._offset_ns is not None:
            offset_ns = min(offset_ns, self._offset_ns + AGED_PER_S * elapsed_ns)
        if now_ns - (stamp_ns + offset_ns) <= LATEST_NS:
            self._late_ns = None
        elif self._late_ns is None:
            self._late_ns = now_ns
        elif now_ns - self._late_ns > LATEST_NS:
            offset_ns, self._late_ns = float(now_ns - stamp_ns), None
        self._offset_ns = offset_ns
        return min(now_ns, round(stamp_ns + offset_ns))


def measured(item: WorldObject) -> tuple[object, ...]:
    """What a source measures of an object."""
    return (
        item.position_m,
        item.rotation_rad,
        item.velocity_m_s,
        item.covariance_m2,
        item.vertices_m,
    )


def positive(covariance_m2: Matrix) -> Matrix:
    """A covariance without a direction in which it is exact."""
    values, axes = np.linalg.eigh(covariance_m2)
    return np.asarray((axes * np.maximum(values, SMALLEST_VARIANCE_M2)) @ axes.T, dtype=np.float64)
