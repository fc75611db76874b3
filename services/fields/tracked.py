"""One object over time: as it was sent, or its positions filtered where that is what is asked."""

from dataclasses import dataclass, replace

import numpy as np

from dforc.collision.obstacles import Obstacle, Triple
from services.core.clock import NS_PER_S
from services.fields.object_checks import covariance_matrix
from services.fields.plain_tracker import ObjectTracker
from services.fields.seen import SeenObject, solid_of
from services.messages import WorldObject

PREDICTED_S = 0.3  # that an object is taken to go on as it moved, once it is seen no more
MOVING_M_S = 0.02  # what moved faster than this when it was seen last may be anywhere
AGED_PER_S = 1e-4  # drift of a sender's clock against ours, at most


@dataclass(frozen=True, slots=True, eq=False)
class TrackedObject:
    """What is known of an object. Its tracker is the only part that changes in place."""

    item: WorldObject
    solid: Obstacle  # where it was sent to be
    seen_ns: int
    tracker: ObjectTracker | None  # of one whose velocity is not sent

    @classmethod
    def first(cls, seen_ns: int, item: WorldObject) -> "TrackedObject":
        """An object that was not known; it has passed the checks."""
        tracker = ObjectTracker() if item.velocity_m_s is None else None
        new = cls(item, solid_of(item), seen_ns, tracker)
        new._note()
        return new

    def updated(self, seen_ns: int, item: WorldObject) -> "TrackedObject":
        """The same object, seen again; it has passed the checks."""
        if item == self.item and self.tracker is None:
            return replace(self, seen_ns=seen_ns)
        tracker = None
        if item.velocity_m_s is None:
            tracker = self.tracker or ObjectTracker()
        new = TrackedObject(item, solid_of(item), seen_ns, tracker)
        new._note()
        return new

    def at(self, now_ns: int, source: str) -> SeenObject:
        """Where it is taken to be now."""
        age_s = max(0.0, (now_ns - self.seen_ns) / NS_PER_S)
        ahead_s = min(age_s, PREDICTED_S)
        place_m, velocity_m_s, sigma_m = self._predicted(ahead_s)
        lost = ""
        if age_s > PREDICTED_S and any(velocity_m_s):
            speed_m_s = float(np.linalg.norm(velocity_m_s))
            if speed_m_s > MOVING_M_S:
                lost = f"last seen {age_s:.1f} s ago, at {speed_m_s:.2f} m/s"
            velocity_m_s = (0.0, 0.0, 0.0)
        return SeenObject(
            name=self.item.name,
            source=source,
            solid=replace(self.solid, position_m=place_m, velocity_m_s=velocity_m_s),
            role=self.item.role,
            on=self.item.on,
            sigma_m=sigma_m,
            age_s=age_s,
            lost=lost,
        )

    def _note(self) -> None:
        if self.tracker is not None:
            covariance = self.item.covariance_m2
            self.tracker.update(
                self.seen_ns / NS_PER_S,
                np.array(self.solid.position_m),
                None if covariance is None else covariance_matrix(covariance),
            )

    def _predicted(self, ahead_s: float) -> tuple[Triple, Triple, float]:
        """Place, velocity and sigma of the place, some time after it was seen."""
        if self.tracker is None:
            velocity_m_s = self.item.velocity_m_s or (0.0, 0.0, 0.0)
            x, y, z = (
                p + ahead_s * v for p, v in zip(self.solid.position_m, velocity_m_s, strict=True)
            )
            return (x, y, z), velocity_m_s, sigma_of(self.item)
        position, velocity, sigma_m = self.tracker.at(self.seen_ns / NS_PER_S + ahead_s)
        (x, y, z), (u, v, w) = position.tolist(), velocity.tolist()
        return (x, y, z), (u, v, w), float(sigma_m)


class SourceClock:
    """A sender's stamps as our time: arrivals come late by turns, stamps do not.

    Stamps that stand still or go back are no clock: then the arrival counts.
    """

    def __init__(self) -> None:
        self._stamp_ns = 0
        self._offset_ns: float | None = None

    def time_ns(self, now_ns: int, stamp_ns: int) -> int:
        """When a message was made, at the latest now."""
        elapsed_ns, self._stamp_ns = stamp_ns - self._stamp_ns, stamp_ns
        if stamp_ns <= 0 or elapsed_ns <= 0:
            self._offset_ns = None
            return now_ns
        offset_ns = float(now_ns - stamp_ns)
        if self._offset_ns is not None:
            offset_ns = min(offset_ns, self._offset_ns + AGED_PER_S * elapsed_ns)
        self._offset_ns = offset_ns
        return min(now_ns, round(stamp_ns + offset_ns))


def sigma_of(item: WorldObject) -> float:
    """The largest standard deviation of the position that was sent; 0 for an exact one."""
    if item.covariance_m2 is None:
        return 0.0
    variances = np.linalg.eigvalsh(covariance_matrix(item.covariance_m2))
    return float(np.sqrt(max(variances[2], 0.0)))
