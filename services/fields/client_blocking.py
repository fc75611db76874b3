"""The field of a running stack, from Python, by calls that return when they have been heard."""

import contextlib
from collections.abc import Sequence

from dforc.arrays import ArrayLike
from services.core.connection import StackConnection
from services.core.errors import CallFailedError, ServiceError
from services.fields.client_objects import ObjectHandle, ObjectShelf, objects_message, triple
from services.fields.client_questions import FieldQuestions
from services.fields.client_status import StatusWatch, Wanted
from services.fields.messages import FieldReply, FieldRequest, FieldStatus
from services.messages import Floats, Vector3, WorldObject
from services.reaching.client_settings import as_vector
from services.reaching.client_types import Rotation
from services.streams import FIELD_CALL, FIELD_STATUS, OBJECTS

WAIT_S = 30.0  # unless told otherwise: nobody waits for ever
SOURCE = "python"
STILL: Vector3 = (0.0, 0.0, 0.0)


class BlockingFieldControl(StackConnection, FieldQuestions):
    """The field of one stack. Use it as a context manager; it may be used from any thread."""

    def __init__(
        self, stack: str = "icub", source: str = SOURCE, *, keep_objects: bool = False
    ) -> None:
        """Connect.

        Args:
            stack: name of the running stack.
            source: that the objects of this client belong to; one client for each name.
            keep_objects: leave them in the world when this client closes.

        Raises:
            ServiceError: no such stack, or its hub does not answer.
        """
        StackConnection.__init__(self, stack)
        FieldQuestions.__init__(self, self._call)
        self._source = source
        self._keep_objects = keep_objects
        self._shelf = ObjectShelf(self.publish)
        self._has_published = False
        self.heard = StatusWatch(stack, self.clock)
        self.bus.listen(FIELD_STATUS, self.heard.hear)

    def add_object(
        self,
        name: str,
        shape: str,
        size_m: Sequence[float],
        position_m: ArrayLike,
        rotation: Rotation = STILL,
        *,
        role: str = "obstacle",
        velocity_m_s: ArrayLike | None = STILL,
        covariance_m2: Floats | None = None,
        vertices_m: Sequence[ArrayLike] = (),
    ) -> ObjectHandle:
        """Put an object into the world; its handle moves it, at any rate.

        Args:
            name: of this client's objects.
            shape: sphere, ellipsoid, box, cylinder or mesh.
            size_m: radius | semi-axes | half edges | radius and half length | nothing.
            position_m: of its centre, base frame; of a mesh its origin.
            rotation: of its own axes.
            role: obstacle, or target: may be followed, and is not avoided.
            velocity_m_s: None: to be estimated from the positions.
            covariance_m2: of the position: xx, xy, xz, yy, yz, zz; None: it is exact.
            vertices_m: of a mesh, in its own axes.

        Raises:
            ServiceError: it is none, or there is one of that name.
        """
        return self._shelf.add(
            WorldObject(
                name=name,
                shape=shape,
                size_m=tuple(float(x) for x in size_m),
                position_m=triple(position_m),
                rotation_rad=as_vector(rotation),
                role=role,
                velocity_m_s=None if velocity_m_s is None else triple(velocity_m_s),
                covariance_m2=covariance_m2,
                vertices_m=tuple(triple(vertex) for vertex in vertices_m),
            )
        )

    def publish(self, items: tuple[WorldObject, ...]) -> None:
        """Take the place of all that this client's source has sent; `add_object` does so, too."""
        self._has_published = bool(items)
        self.bus.put(OBJECTS, objects_message(self.clock.now_ns(), self._source, items))

    def status(self) -> FieldStatus:
        """The newest one.

        Raises:
            ServiceError: none comes.
        """
        return self.heard.newest()

    def next_status(self) -> FieldStatus:
        """The next one to come.

        Raises:
            ServiceError: none comes.
        """
        return self.heard.following()

    def wait_for(self, *states: str, goal: int = 0, timeout_s: float = WAIT_S) -> FieldStatus:
        """Wait until the field is in one of the states, `arrived` by default.

        Args:
            states: idle, reaching, planning, waiting, unreachable, arrived.
            goal: not before this goal has been taken up; 0: the newest.
            timeout_s: how long.

        Raises:
            WaitTimeoutError: it is in another; the text says which, and why.
            ServiceError: no such state, or the field is silent.
        """
        return self.heard.wait(Wanted.checked(states, goal), timeout_s)

    def close(self) -> None:
        """Leave the bus. What moves goes on moving."""
        if (self._shelf.take_all() or self._has_published) and not self._keep_objects:
            with contextlib.suppress(ServiceError):  # the stack may have gone first
                self.forget(self._source)
        super().close()

    def _call(self, request: FieldRequest) -> FieldReply:
        try:
            return self.call(FIELD_CALL, request)
        except CallFailedError as error:
            if "field" not in self.bus.alive():
                raise self.heard.silence() from error
            raise
