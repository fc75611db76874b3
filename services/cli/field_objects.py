"""`ulna field objects`: what the field takes to be in the world."""

from collections.abc import Callable
from typing import Literal

import msgspec
from rich.console import Console

from services.cli.complaint import complain
from services.cli.field_tables import numbers_text, objects_table
from services.core.clock import NS_PER_S, RealClock
from services.core.errors import ConfigError, ServiceError
from services.fields.client_blocking import BlockingFieldControl
from services.fields.object_checks import check_object
from services.messages import WorldObject
from services.reaching.client_types import RequestRefusedError

REFUSED = 1
FAILED = 2
SOURCE = "user"
TAKEN_UP_S = 2.0
LOOK_S = 0.05

Triple = tuple[float, float, float]
Change = Callable[[dict[str, WorldObject]], None]


def objects_list(*, stack: str = "icub") -> int:
    """Everything that the sources have sent.

    Example: ulna field objects list

    Args:
        stack: name of the running stack.

    Returns:
        Exit status: 0, 2 without an answer.
    """
    try:
        with BlockingFieldControl(stack) as control:
            Console().print(objects_table(control.info()))
    except ServiceError as error:
        return _complain(error)
    return 0


def objects_add(
    name: str,
    shape: Literal["sphere", "ellipsoid", "box", "cylinder"],
    /,
    *size: float,
    at: Triple,
    rotation: Triple = (0.0, 0.0, 0.0),
    role: Literal["obstacle", "target"] = "obstacle",
    stack: str = "icub",
) -> int:
    """Put an object into the world, at rest; it stays until it is removed.

    Example: ulna field objects add table box 0.3 0.4 0.02 --at -0.4 0 -0.1

    Args:
        name: of the object.
        shape: sphere, ellipsoid, box or cylinder.
        size: m; radius | semi-axes | half edges | radius and half length.
        at: X Y Z of its centre, m, base frame.
        rotation: of its own axes, as a rotation vector, rad.
        role: obstacle, or target: may be followed, and is not avoided.
        stack: name of the running stack.

    Returns:
        Exit status: 0, 1 when refused, 2 without an answer.
    """
    item = WorldObject(
        name=name,
        shape=shape,
        size_m=size,
        position_m=at,
        rotation_rad=rotation,
        velocity_m_s=(0.0, 0.0, 0.0),
        role=role,
        seen_ns=RealClock.now_ns(),
    )

    def add(items: dict[str, WorldObject]) -> None:
        if name in items:
            raise ConfigError(f"there is an object {name!r}; move it, or remove it first")
        items[name] = item

    return _change(stack, add)


def objects_move(
    name: str,
    /,
    *,
    to: Triple,
    rotation: Triple | None = None,
    stack: str = "icub",
) -> int:
    """Put an object that was added here somewhere else, at once.

    Example: ulna field objects move ball --to -0.35 0.1 0.05

    Args:
        name: of the object.
        to: X Y Z of its centre, m, base frame.
        rotation: of its own axes; None: as before.
        stack: name of the running stack.

    Returns:
        Exit status: 0, 1 when refused, 2 without an answer.
    """

    def move(items: dict[str, WorldObject]) -> None:
        before = _known(items, name)
        turned = before.rotation_rad if rotation is None else rotation
        items[name] = msgspec.structs.replace(
            before, position_m=to, rotation_rad=turned, seen_ns=RealClock.now_ns()
        )

    return _change(stack, move)


def objects_remove(name: str = "", /, *, source: str = "", stack: str = "icub") -> int:
    """Remove an object that was added here, or all of a source.

    Example: ulna field objects remove ball

    Args:
        name: of the object.
        source: instead: all that this source has sent.
        stack: name of the running stack.

    Returns:
        Exit status: 0, 1 when refused, 2 without an answer.
    """
    if bool(name) == bool(source):
        complain("give the name of an object, or --source; one of the two")
        return FAILED
    if name:
        return _change(stack, lambda items: _remove(items, name))
    try:
        with BlockingFieldControl(stack) as control:
            print(f"{control.forget(source)} objects of {source!r} forgotten")
    except ServiceError as error:
        return _complain(error)
    return 0


def _change(stack: str, change: Change) -> int:
    """Publish the set of this source again, changed, and see it taken up."""
    try:
        with BlockingFieldControl(stack, SOURCE, keep_objects=True) as control:
            items = {item.name: item for item in _mine(control)}
            change(items)
            for item in items.values():
                check_object(item)
            control.publish(tuple(items.values()))
            clock = RealClock()
            end_ns = clock.now_ns() + round(TAKEN_UP_S * NS_PER_S)
            while _mine(control) != tuple(items.values()):
                if clock.now_ns() > end_ns:
                    raise ServiceError(f"not taken up: {control.status().refusal}")
                clock.sleep_until(clock.now_ns() + round(LOOK_S * NS_PER_S))
    except ServiceError as error:
        return _complain(error)
    for item in items.values():
        print(f"{item.name}: {item.shape} {numbers_text(item.size_m)}", end=" ")
        print(f"at {numbers_text(item.position_m)}, {item.role}")
    return 0


def _mine(control: BlockingFieldControl) -> tuple[WorldObject, ...]:
    for source in control.info().sources:
        if source.source == SOURCE:
            return source.objects
    return ()


def _known(items: dict[str, WorldObject], name: str) -> WorldObject:
    if name not in items:
        known = ", ".join(items) or "none"
        raise ConfigError(f"no object {name!r} was added here; there are: {known}")
    return items[name]


def _remove(items: dict[str, WorldObject], name: str) -> None:
    _known(items, name)
    del items[name]


def _complain(error: ServiceError) -> int:
    complain(error)
    refused = (RequestRefusedError, ConfigError)
    return REFUSED if isinstance(error, refused) else FAILED
