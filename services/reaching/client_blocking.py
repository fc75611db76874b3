"""A limb of a running stack, moved from Python by calls that return when they have been heard."""

import contextlib
import logging
import threading
from collections.abc import Callable, Sequence
from concurrent.futures import Future, ThreadPoolExecutor

from dforc.arrays import ArrayLike
from services.core.clock import NS_PER_S
from services.core.connection import StackConnection
from services.core.errors import ServiceError
from services.reaching.cartesian_messages import (
    DONE,
    CartesianEvent,
    CartesianRequest,
    MotionState,
    TipVelocity,
)
from services.reaching.client_events import Listener, Listeners
from services.reaching.client_modes import switch_to_direct
from services.reaching.client_settings import SettingRequests
from services.reaching.client_types import (
    MotionFailedError,
    Rotation,
    WaitTimeoutError,
    tip_pose,
)
from services.reaching.limb_names import AUTO
from services.reaching.messages import TipPose
from services.streams import CARTESIAN_CALL, CARTESIAN_EVENTS

logger = logging.getLogger(__name__)

SWITCH_S = 10.0  # for joints to change their mode
WAIT_S = 30.0  # for a motion, unless told otherwise: nobody waits for ever
LOOK_AGAIN_S = 0.5  # at a motion whose end may have been missed

Callback = Callable[[CartesianEvent], None]


class BlockingCartesianControl(StackConnection, SettingRequests):
    """One limb of a running stack. Use it as a context manager; it may be used from any thread."""

    def __init__(self, limb: str = "right_arm", stack: str = "icub") -> None:
        """Connect.

        Args:
            limb: right_arm, left_arm, both_arms, or auto: the arm with the nearer hand.
            stack: name of the running stack.

        Raises:
            ServiceError: no such stack, or its hub does not answer.
        """
        StackConnection.__init__(self, stack)
        SettingRequests.__init__(self, limb, lambda request: self.call(CARTESIAN_CALL, request))
        self.newest = 0  # motion that this client asked for
        self._listeners = Listeners()
        self._switching = threading.Lock()
        self._ended = threading.Condition()
        self._ends = 0  # motions that have ended
        self._callbacks = ThreadPoolExecutor(max_workers=1)  # starts its thread when it is needed
        self.bus.listen(CARTESIAN_EVENTS, self._hear)

    def take_set_points(self, timeout_s: float = SWITCH_S) -> None:
        """Switch the limb's free joints to position-direct mode: then the controller moves them.

        Raises:
            RequestRefusedError: they cannot, for instance because they are not calibrated.
            WaitTimeoutError: it takes too long.
        """
        with self._switching:
            switch_to_direct(self.bus, self.clock, self._free_joints(), timeout_s)

    def go_to_pose(
        self,
        position_m: ArrayLike | None,
        rotation: Rotation | None = None,
        *,
        time_s: float = 0.0,
        nearest: bool = False,
    ) -> MotionState:
        """Move the hand to a pose; returns once the motion has begun.

        Args:
            position_m: where to, base frame; None: anywhere.
            rotation: a matrix, a rotation vector, or axis and angle; None: any.
            time_s: how long it takes; 0: the limb's trajectory time.
            nearest: where the pose is out of reach, go as near as can be.

        Returns:
            The motion; `out_of_reach` says how far an orientation is that can only be approached.

        Raises:
            RequestRefusedError: the pose is out of reach, or the limb cannot move; and why.
        """
        return self.go_to_poses((tip_pose(position_m, rotation),), time_s=time_s, nearest=nearest)

    def go_to_position(
        self, position_m: ArrayLike, *, time_s: float = 0.0, nearest: bool = False
    ) -> MotionState:
        """Move the hand to a position, turned as it likes; see `go_to_pose`."""
        return self.go_to_pose(position_m, None, time_s=time_s, nearest=nearest)

    def go_to_poses(
        self, poses: Sequence[TipPose | None], *, time_s: float = 0.0, nearest: bool = False
    ) -> MotionState:
        """The same for a limb with several hands, both arms: left, right; None: one is free."""
        reply = self._ask(
            CartesianRequest(
                action="go", limb=self.limb, poses=tuple(poses), duration_s=time_s, nearest=nearest
            )
        )
        if reply.motion is None:
            raise ServiceError("a reply without the motion that was asked for")
        self.newest = reply.motion.motion
        return reply.motion

    def move(self, *velocities: TipVelocity, time_s: float = 0.5) -> None:
        """Move the hands at velocities, base frame, and stop after `time_s` unless told again.

        Raises:
            RequestRefusedError: the limb cannot move; and why.
        """
        self._ask(
            CartesianRequest(
                action="velocity", limb=self.limb, velocities=velocities, duration_s=time_s
            )
        )

    def stop(self) -> None:
        """Come to rest, whatever moves the limb in use."""
        self._ask(CartesianRequest(action="stop"))

    def wait_motion_done(self, timeout_s: float = WAIT_S, motion: int = 0) -> MotionState:
        """Wait until a motion is done: the newest that this client asked for, or that number.

        Raises:
            MotionFailedError: it has ended elsewhere; and why.
            WaitTimeoutError: it goes on for longer.
            ServiceError: the stack has gone.
        """
        number = motion or self.newest
        end_ns = self.clock.now_ns() + round(timeout_s * NS_PER_S)
        while True:
            ends = self._ends
            state = self.motion(number)
            if state.done:
                return ended_well(state)
            left_s = (end_ns - self.clock.now_ns()) / NS_PER_S
            if left_s <= 0.0:
                raise WaitTimeoutError(f"motion {state.motion} goes on after {timeout_s:g} s")
            with self._ended:
                if self._ends == ends:  # none has ended since the look
                    self._ended.wait(min(left_s, LOOK_AGAIN_S))

    def on(self, kind: str, callback: Callback, checkpoint: float | None = None) -> Listener:
        """Have a function called on events, one by one in a thread of this client.

        Args:
            kind: motion-onset, motion-ongoing, motion-done, closing or *.
            callback: gets the event.
            checkpoint: of motion-ongoing: 0 to 1 of the way.

        Raises:
            ServiceError: no such kind, or the controller does not take the checkpoint.
        """

        def deliver(event: CartesianEvent) -> None:
            self._callbacks.submit(callback, event).add_done_callback(log_failure)

        listener = self._listeners.add(kind, checkpoint, deliver)
        if checkpoint is not None:
            self.watch(checkpoint)
        return listener

    def off(self, listener: Listener) -> None:
        """Take back what `on` registered."""
        if self._listeners.remove(listener) and listener.checkpoint is not None:
            self.watch(listener.checkpoint, on=False)

    def watch(self, checkpoint: float, *, on: bool = True) -> None:
        """Have the controller tell, or no longer, when a motion passes a checkpoint.

        Raises:
            RequestRefusedError: it is no checkpoint.
        """
        action = "watch" if on else "unwatch"
        self._ask(CartesianRequest(action=action, checkpoint=checkpoint))

    def listen(self, listeners: Listeners) -> None:
        """Register with others instead; before any event is wanted."""
        self._listeners = listeners

    def close(self) -> None:
        """Leave the bus. What moves goes on moving."""
        for listener in self._listeners.take_all():
            if listener.checkpoint is not None:
                with contextlib.suppress(ServiceError):  # the stack may have gone first
                    self.watch(listener.checkpoint, on=False)
        super().close()
        self._callbacks.shutdown(wait=False, cancel_futures=True)

    def _free_joints(self) -> tuple[str, ...]:
        if self.limb != AUTO:
            return tuple(joint for joint, free in self.settings().free.items() if free)
        arms = [limb for limb in self.info().limbs if len(limb.tips) == 1]
        return tuple(dict.fromkeys(joint for arm in arms for joint in arm.joints))

    def _hear(self, event: CartesianEvent) -> None:
        """Runs in a thread of Zenoh's."""
        self._listeners.tell(event)
        if event.kind == DONE:
            with self._ended:
                self._ends += 1
                self._ended.notify_all()


def ended_well(state: MotionState) -> MotionState:
    """A motion that has reached where it led.

    Raises:
        MotionFailedError: it has not.
    """
    if state.motion and state.outcome != "reached":
        raise MotionFailedError(state)
    return state


def log_failure(called: "Future[None]") -> None:
    """A callback that raises is reported; the next event is delivered all the same."""
    error = None if called.cancelled() else called.exception()
    if error is not None:
        logger.error("a callback has failed", exc_info=error)
