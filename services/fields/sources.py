"""All objects that the sources have sent, each where it is taken to be now.

A source's message takes the place of all that it sent before. An object in it that is none keeps
its last good state, if it had one; the others are taken. What falls silent stays: at rest where it
was, or, if it moved, where it went within a moment, and is then called lost.
"""

from dataclasses import dataclass, field

from services.core.clock import NS_PER_S
from services.core.errors import ConfigError
from services.fields.messages import SourceInfo
from services.fields.object_checks import MOST_OBJECTS, as_objects, check_object
from services.fields.seen import SeenObject
from services.fields.tracked import SourceClock, TrackedObject
from services.messages import Objects

MOST_SOURCES = 16


@dataclass(slots=True)
class _Source:
    objects: dict[str, TrackedObject] = field(default_factory=dict)
    arrived_ns: int = 0
    clock: SourceClock = field(default_factory=SourceClock)


class Sources:
    """By name."""

    def __init__(self) -> None:
        self._sources: dict[str, _Source] = {}

    def take(self, now_ns: int, message: Objects) -> list[str]:
        """Take in what a source has sent; what is wrong with it, a sentence each."""
        if message.source not in self._sources and len(self._sources) >= MOST_SOURCES:
            return [f"more than {MOST_SOURCES} sources of objects"]
        problems: list[str] = []
        source = self._sources.setdefault(message.source, _Source())
        before, source.objects = source.objects, {}
        source.arrived_ns = now_ns
        seen_ns = source.clock.time_ns(now_ns, message.stamp_ns)
        room = MOST_OBJECTS - sum(len(other.objects) for other in self._sources.values())
        for item in as_objects(message):
            at_ns = seen_ns - older_ns(message.stamp_ns, item.seen_ns)
            known = before.get(item.name)
            if item.name in source.objects:
                problems.append(f"object {item.name!r}: twice in one message; the first counts")
                continue
            try:
                check_object(item)
            except ConfigError as error:
                problems.append(str(error))
                if known is not None:
                    source.objects[item.name] = known
                continue
            if len(source.objects) >= room:
                problems.append(f"object {item.name!r}: more than {MOST_OBJECTS} objects")
                break
            source.objects[item.name] = (
                known.updated(at_ns, item)
                if known is not None
                else TrackedObject.first(at_ns, item)
            )
        return problems

    def forget(self, source: str) -> int:
        """Drop all of a source; how many those were.

        Raises:
            ConfigError: there is no such source.
        """
        if source not in self._sources:
            known = ", ".join(map(repr, self._sources)) or "none"
            raise ConfigError(f"no source {source!r} of objects; there are: {known}")
        return len(self._sources.pop(source).objects)

    def seen(self, now_ns: int) -> tuple[SeenObject, ...]:
        """Every object as it is taken to be now."""
        return tuple(
            tracked.at(now_ns, name)
            for name, source in self._sources.items()
            for tracked in source.objects.values()
        )

    def info(self, now_ns: int) -> tuple[SourceInfo, ...]:
        """What there is, as it was sent."""
        return tuple(
            SourceInfo(
                source=name,
                objects=tuple(tracked.item for tracked in source.objects.values()),
                age_s=(now_ns - source.arrived_ns) / NS_PER_S,
            )
            for name, source in self._sources.items()
        )


def older_ns(stamp_ns: int, item_ns: int) -> int:
    """By how much an object is older than its message; not at all where one has no stamp."""
    return max(0, stamp_ns - item_ns) if stamp_ns > 0 and item_ns > 0 else 0


def find_object(seen: tuple[SeenObject, ...], name: str) -> SeenObject | None:
    """The object of that name, or of that `source/name`; the first where several have it."""
    for one in seen:
        if name in (one.name, f"{one.source}/{one.name}"):
            return one
    return None


def names_of(seen: tuple[SeenObject, ...]) -> str:
    """For a sentence."""
    return ", ".join(one.name for one in seen) or "none"
