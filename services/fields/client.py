"""The field of a running stack, from Python: what to import.

    async with FieldControl() as field:
        await field.set("ulna", gains={"margin": 0.03})
        ball = await field.add_object("ball", "sphere", (0.05,), (-0.35, 0.1, 0.05))
        goal = await field.go((-0.4, 0.05, 0.1))
        await field.wait_for("arrived", goal=goal)

BlockingFieldControl is the same without asyncio. Whatever cannot be had is an error with its
reason; docs/fields.md has every call.
"""

import functools

from services.core.awaitable import AwaitableClient, awaitable
from services.fields.client_blocking import SOURCE, WAIT_S, BlockingFieldControl
from services.fields.client_objects import ObjectHandle
from services.fields.client_status import Wanted
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


class FieldControl(AwaitableClient[BlockingFieldControl]):
    """The field of one stack. Use it as an asynchronous context manager."""

    how_to_use = "use it inside `async with FieldControl() as field:`"

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

    def __init__(
        self, stack: str = "icub", source: str = SOURCE, *, keep_objects: bool = False
    ) -> None:
        """Connects when it is entered; the arguments are those of BlockingFieldControl."""
        super().__init__(
            functools.partial(BlockingFieldControl, stack, source, keep_objects=keep_objects)
        )

    async def wait_for(self, *states: str, goal: int = 0, timeout_s: float = WAIT_S) -> FieldStatus:
        """As of BlockingFieldControl; nothing goes on waiting where this is cancelled."""
        wanted = Wanted.checked(states, goal)
        return await (await self.ready()).heard.wait_awaited(wanted, timeout_s)
