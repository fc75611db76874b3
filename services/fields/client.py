"""The field of a running stack, from Python: what to import.

    async with FieldControl() as field:
        await field.set("ulna", gains={"margin": 0.03})
        ball = await field.add_object("ball", "sphere", (0.05,), (-0.35, 0.1, 0.05))
        goal = await field.go((-0.4, 0.05, 0.1))
        await field.wait_for("arrived", goal=goal)

BlockingFieldControl is the same without asyncio. Whatever cannot be had is an error with its
reason; docs/fields.md has every call.
"""

import asyncio
import functools
from collections.abc import Callable, Coroutine
from types import TracebackType
from typing import Concatenate, ParamSpec, Self, TypeVar

from services.core.errors import ServiceError
from services.fields.client_blocking import SOURCE, BlockingFieldControl
from services.fields.client_objects import ObjectHandle
from services.fields.messages import FieldInfo, FieldStatus, Preview
from services.reaching.client_types import RequestRefusedError, WaitTimeoutError

__all__ = (
    "BlockingFieldControl",
    "FieldControl",
    "FieldInfo",
    "FieldStatus",
    "ObjectHandle",
    "Preview",
    "RequestRefusedError",
    "WaitTimeoutError",
)

P = ParamSpec("P")
ResultT = TypeVar("ResultT")


def awaitable(
    method: Callable[Concatenate[BlockingFieldControl, P], ResultT],
) -> Callable[Concatenate["FieldControl", P], Coroutine[None, None, ResultT]]:
    """The same call, to be awaited: another thread waits for the answer."""

    async def call(control: "FieldControl", /, *arguments: P.args, **named: P.kwargs) -> ResultT:
        return await asyncio.to_thread(method, control.connected(), *arguments, **named)

    functools.update_wrapper(call, method)
    return call


class FieldControl:
    """The field of one stack. Use it as an asynchronous context manager."""

    info = awaitable(BlockingFieldControl.info)
    gains = awaitable(BlockingFieldControl.gains)
    set = awaitable(BlockingFieldControl.set)
    go = awaitable(BlockingFieldControl.go)
    follow = awaitable(BlockingFieldControl.follow)
    stop = awaitable(BlockingFieldControl.stop)
    preview = awaitable(BlockingFieldControl.preview)
    add_object = awaitable(BlockingFieldControl.add_object)
    forget = awaitable(BlockingFieldControl.forget)
    status = awaitable(BlockingFieldControl.status)
    wait_for = awaitable(BlockingFieldControl.wait_for)

    def __init__(
        self, stack: str = "icub", source: str = SOURCE, *, keep_objects: bool = False
    ) -> None:
        """Connects when it is entered; the arguments are those of BlockingFieldControl."""
        self._connect = functools.partial(
            BlockingFieldControl, stack, source, keep_objects=keep_objects
        )
        self._blocking: BlockingFieldControl | None = None

    async def __aenter__(self) -> Self:
        self._blocking = await asyncio.to_thread(self._connect)
        return self

    async def __aexit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        traceback: TracebackType | None,
    ) -> None:
        blocking, self._blocking = self._blocking, None
        if blocking is not None:
            await asyncio.to_thread(blocking.close)

    def connected(self) -> BlockingFieldControl:
        """The connection.

        Raises:
            ServiceError: there is none.
        """
        if self._blocking is None:
            raise ServiceError("use it inside `async with FieldControl() as field:`")
        return self._blocking
