"""Hands of a running stack, moved from Python: what to import.

    async with CartesianControl(limb="right_arm") as arm:
        arm.on("motion-ongoing", print, checkpoint=0.5)
        await arm.go_to_pose((-0.3, 0.2, 0.1), time_s=1.5)
        await arm.wait_motion_done()

BlockingCartesianControl is the same without asyncio. Whatever cannot be had is an error with its
reason; docs/cartesian.md has every call.
"""

import asyncio
import contextlib
import functools
from collections.abc import Callable, Coroutine
from types import TracebackType
from typing import ParamSpec, Self

from services.core.awaitable import AwaitableClient, awaitable
from services.core.clock import NS_PER_S, RealClock
from services.reaching.cartesian_messages import (
    DONE,
    CartesianEvent,
    CartesianSettings,
    MotionState,
    TipVelocity,
)
from services.reaching.client_blocking import (
    LOOK_AGAIN_S,
    WAIT_S,
    BlockingCartesianControl,
    ended_well,
)
from services.reaching.client_events import Listener, Listeners
from services.reaching.client_types import (
    MotionFailedError,
    PlanSpeeds,
    Pose,
    Posture,
    RequestRefusedError,
    Settings,
    WaitTimeoutError,
    tip_pose,
)

__all__ = (
    "BlockingCartesianControl",
    "CartesianControl",
    "CartesianEvent",
    "CartesianSettings",
    "MotionFailedError",
    "MotionState",
    "PlanSpeeds",
    "Pose",
    "Posture",
    "RequestRefusedError",
    "Settings",
    "TipVelocity",
    "WaitTimeoutError",
    "tip_pose",
)

P = ParamSpec("P")
Callback = (
    Callable[[CartesianEvent], None] | Callable[[CartesianEvent], Coroutine[None, None, None]]
)


class CartesianControl(AwaitableClient[BlockingCartesianControl]):
    """One limb of a running stack. Use it as an asynchronous context manager, in one event loop."""

    how_to_use = "not connected: use `async with CartesianControl(...) as arm`"

    pose = awaitable(BlockingCartesianControl.pose)
    poses = awaitable(BlockingCartesianControl.poses)
    desired = awaitable(BlockingCartesianControl.desired)
    ask_for_pose = awaitable(BlockingCartesianControl.ask_for_pose)
    ask_for_poses = awaitable(BlockingCartesianControl.ask_for_poses)
    speeds = awaitable(BlockingCartesianControl.speeds)
    motion = awaitable(BlockingCartesianControl.motion)
    info = awaitable(BlockingCartesianControl.info)
    settings = awaitable(BlockingCartesianControl.settings)
    change = awaitable(BlockingCartesianControl.change)
    attach_tip = awaitable(BlockingCartesianControl.attach_tip)
    tip = awaitable(BlockingCartesianControl.tip)
    remove_tip = awaitable(BlockingCartesianControl.remove_tip)
    store_context = awaitable(BlockingCartesianControl.store_context)
    restore_context = awaitable(BlockingCartesianControl.restore_context)
    delete_context = awaitable(BlockingCartesianControl.delete_context)
    take_set_points = awaitable(BlockingCartesianControl.take_set_points)
    go_to_pose = awaitable(BlockingCartesianControl.go_to_pose)
    go_to_position = awaitable(BlockingCartesianControl.go_to_position)
    go_to_poses = awaitable(BlockingCartesianControl.go_to_poses)
    move = awaitable(BlockingCartesianControl.move)
    stop = awaitable(BlockingCartesianControl.stop)

    def __init__(self, limb: str = "right_arm", stack: str = "icub") -> None:
        """Connects when it is entered.

        Args:
            limb: right_arm, left_arm, both_arms, or auto: the arm with the nearer hand.
            stack: name of the running stack.
        """
        super().__init__(functools.partial(BlockingCartesianControl, limb, stack))
        self._clock = RealClock()
        self._listeners = Listeners()
        self._ended = asyncio.Event()
        self._watching: set[asyncio.Task[None]] = set()
        self._running: set[asyncio.Task[None]] = set()

    async def __aenter__(self) -> Self:
        self._loop = asyncio.get_running_loop()
        await super().__aenter__()
        self.connected().listen(self._listeners)
        self._listeners.add(DONE, None, lambda event: self._in_loop(self._note_end, event))
        return self

    async def __aexit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        traceback: TracebackType | None,
    ) -> None:
        for task in self._running:
            task.cancel()
        await super().__aexit__(kind, error, traceback)

    async def wait_motion_done(self, timeout_s: float = WAIT_S, motion: int = 0) -> MotionState:
        """Wait until a motion is done: the newest that this client asked for, or that number.

        Raises:
            MotionFailedError: it has ended elsewhere; and why.
            WaitTimeoutError: it goes on for longer.
            ServiceError: the stack has gone.
        """
        number = motion or (await self.ready()).newest
        end_ns = self._clock.now_ns() + round(timeout_s * NS_PER_S)
        while True:
            self._ended.clear()
            state = await self.motion(number)
            if state.done:
                return ended_well(state)
            left_s = (end_ns - self._clock.now_ns()) / NS_PER_S
            if left_s <= 0.0:
                raise WaitTimeoutError(f"motion {state.motion} goes on after {timeout_s:g} s")
            with contextlib.suppress(TimeoutError):
                await asyncio.wait_for(self._ended.wait(), min(left_s, LOOK_AGAIN_S))

    def on(self, kind: str, callback: Callback, checkpoint: float | None = None) -> Listener:
        """Have a function called, or a coroutine run, on events, in the event loop.

        Args:
            kind: motion-onset, motion-ongoing, motion-done, closing or *.
            callback: gets the event.
            checkpoint: of motion-ongoing: 0 to 1 of the way. One that the controller does not take
                is an error of the next call.

        Raises:
            ServiceError: no such kind, or not connected.
        """
        blocking = self.connected()
        listener = self._listeners.add(
            kind, checkpoint, lambda event: self._in_loop(self._run, callback, event)
        )
        if checkpoint is not None:
            self._watch(blocking, checkpoint, on=True)
        return listener

    def off(self, listener: Listener) -> None:
        """Take back what `on` registered."""
        blocking = self.connected()
        if self._listeners.remove(listener) and listener.checkpoint is not None:
            self._watch(blocking, listener.checkpoint, on=False)

    async def ready(self) -> BlockingCartesianControl:
        """The connection, once the controller knows of all checkpoints.

        Raises:
            ServiceError: not connected, or a checkpoint that the controller does not take.
        """
        watching, self._watching = self._watching, set()
        for task in watching:
            await task
        return self.connected()

    def _watch(self, blocking: BlockingCartesianControl, checkpoint: float, *, on: bool) -> None:
        async def watch() -> None:
            await asyncio.to_thread(blocking.watch, checkpoint, on=on)

        self._watching.add(asyncio.create_task(watch()))

    def _in_loop(self, function: Callable[P, None], *arguments: P.args, **named: P.kwargs) -> None:
        """From a thread of Zenoh's."""
        with contextlib.suppress(RuntimeError):  # the loop has been closed meanwhile
            self._loop.call_soon_threadsafe(functools.partial(function, *arguments, **named))

    def _note_end(self, event: CartesianEvent) -> None:  # noqa: ARG002
        self._ended.set()

    def _run(self, callback: Callback, event: CartesianEvent) -> None:
        result = callback(event)
        if result is not None:
            task = self._loop.create_task(result)
            self._running.add(task)
            task.add_done_callback(self._running.discard)
