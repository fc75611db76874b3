"""Clients whose calls are awaited: those of a blocking client, which waits in another thread."""

import asyncio
import functools
from collections.abc import Callable, Coroutine
from types import TracebackType
from typing import ClassVar, Concatenate, Generic, ParamSpec, Protocol, Self, TypeVar

from services.core.connection import StackConnection
from services.core.errors import ServiceError

P = ParamSpec("P")
ResultT = TypeVar("ResultT")
BlockingT = TypeVar("BlockingT")
BlockingT_co = TypeVar("BlockingT_co", covariant=True)
ConnectionT_co = TypeVar("ConnectionT_co", bound=StackConnection, covariant=True)


class Ready(Protocol[BlockingT_co]):
    """Has a blocking client that can be asked."""

    async def ready(self) -> BlockingT_co:
        """That client."""
        ...


def awaitable(
    method: Callable[Concatenate[BlockingT, P], ResultT],
) -> Callable[Concatenate[Ready[BlockingT], P], Coroutine[None, None, ResultT]]:
    """The same call, to be awaited: another thread waits for the answer."""

    async def call(client: Ready[BlockingT], /, *arguments: P.args, **named: P.kwargs) -> ResultT:
        return await asyncio.to_thread(method, await client.ready(), *arguments, **named)

    functools.update_wrapper(call, method)
    return call


class AwaitableClient(Generic[ConnectionT_co]):
    """Use it as an asynchronous context manager; a blocking client connects and asks for it."""

    how_to_use: ClassVar[str]  # said where it has not been entered

    def __init__(self, connect: Callable[[], ConnectionT_co]) -> None:
        """`connect` is called when it is entered."""
        self._connect = connect
        self._blocking: ConnectionT_co | None = None

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

    def connected(self) -> ConnectionT_co:
        """The connection.

        Raises:
            ServiceError: there is none.
        """
        if self._blocking is None:
            raise ServiceError(self.how_to_use)
        return self._blocking

    async def ready(self) -> ConnectionT_co:
        """The connection, once it may be asked.

        Raises:
            ServiceError: there is none.
        """
        return self.connected()
