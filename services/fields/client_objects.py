"""Objects that a client puts into the field's world, moved by handle at any rate."""

import threading
from collections.abc import Callable, Sequence

import msgspec

from dforc.arrays import ArrayLike
from services.core.clock import RealClock
from services.core.errors import ServiceError
from services.fields.object_checks import check_object
from services.messages import Objects, Vector3, WorldObject
from services.reaching.client_settings import as_vector
from services.reaching.client_types import Rotation

STILL: Vector3 = (0.0, 0.0, 0.0)

Publish = Callable[[tuple[WorldObject, ...]], None]


class ObjectHandle:
    """One object; what is not given to `move` stays. May be used from any thread."""

    def __init__(self, name: str, shelf: "ObjectShelf") -> None:
        self.name = name
        self._shelf = shelf

    @property
    def item(self) -> WorldObject:
        """As it was published last."""
        return self._shelf.item(self.name)

    def move(
        self,
        position_m: ArrayLike,
        rotation: Rotation | None = None,
        velocity_m_s: ArrayLike | None = None,
        covariance_m2: Sequence[float] | None = None,
    ) -> None:
        """It is there now. Without a velocity the field estimates it from the positions.

        Raises:
            ServiceError: that is no place; nothing has changed.
        """
        changes: dict[str, object] = {
            "position_m": triple(position_m),
            "velocity_m_s": None if velocity_m_s is None else triple(velocity_m_s),
        }
        if rotation is not None:
            changes["rotation_rad"] = as_vector(rotation)
        if covariance_m2 is not None:
            changes["covariance_m2"] = tuple(float(x) for x in covariance_m2)
        self._shelf.see(msgspec.structs.replace(self.item, **changes))

    def rest(self) -> None:
        """It stays where it is, at rest."""
        self._shelf.see(msgspec.structs.replace(self.item, velocity_m_s=STILL))

    def switch(self, *, on: bool) -> None:
        """Whether it has any effect; it is not seen anew by that."""
        self._shelf.put(msgspec.structs.replace(self.item, on=on))

    def remove(self) -> None:
        """It is gone."""
        self._shelf.remove(self.name)


class ObjectShelf:
    """All objects of one source; each change publishes all of them, those that stay as they were.

    So each carries when it was seen: what is only published again is no new measurement.
    """

    def __init__(self, publish: Publish, now_ns: Callable[[], int] = RealClock.now_ns) -> None:
        """`now_ns` is the clock that `publish` stamps its messages by."""
        self._publish = publish
        self._now_ns = now_ns
        self._lock = threading.Lock()
        self._items: dict[str, WorldObject] = {}

    def item(self, name: str) -> WorldObject:
        """One of them.

        Raises:
            ServiceError: it has been removed.
        """
        with self._lock:
            if name not in self._items:
                raise ServiceError(f"object {name!r} has been removed")
            return self._items[name]

    def add(self, item: WorldObject) -> ObjectHandle:
        """A new one.

        Raises:
            ServiceError: it is none, or there is one of that name.
        """
        with self._lock:
            if item.name in self._items:
                raise ServiceError(
                    f"there is an object {item.name!r} already; move it by its handle"
                )
        self.see(item)
        return ObjectHandle(item.name, self)

    def see(self, item: WorldObject) -> None:
        """One that is there now.

        Raises:
            ServiceError: it is none.
        """
        self.put(msgspec.structs.replace(item, seen_ns=self._now_ns()))

    def put(self, item: WorldObject) -> None:
        """A new state of one, seen when it says.

        Raises:
            ServiceError: it is none.
        """
        check_object(item)
        with self._lock:
            self._items[item.name] = item
            self._publish(tuple(self._items.values()))

    def remove(self, name: str) -> None:
        """Without it."""
        with self._lock:
            if self._items.pop(name, None) is not None:
                self._publish(tuple(self._items.values()))

    def take_all(self) -> bool:
        """Forget all; whether there were any."""
        with self._lock:
            were = bool(self._items)
            self._items.clear()
            return were


def objects_message(now_ns: int, source: str, items: tuple[WorldObject, ...]) -> Objects:
    """What a source publishes."""
    return Objects(stamp_ns=now_ns, objects=items, source=source)


def triple(values: ArrayLike) -> Vector3:
    """Three numbers.

    Raises:
        ServiceError: another number of them.
    """
    numbers = [float(x) for x in values]
    if len(numbers) != 3:
        raise ServiceError(f"a place or a velocity has 3 numbers, not {len(numbers)}")
    x, y, z = numbers
    return x, y, z
