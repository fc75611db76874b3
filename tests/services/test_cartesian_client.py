"""The Python client, without a stack: what it takes, and to whom it hands events."""

import asyncio
import math
from concurrent.futures import Future

import numpy as np
import pytest

from services.core.errors import NotRunningError, ServiceError
from services.reaching.cartesian_messages import (
    CartesianEvent,
    CartesianReply,
    CartesianRequest,
    MotionState,
)
from services.reaching.client import BlockingCartesianControl, CartesianControl
from services.reaching.client_blocking import ended_well, log_failure
from services.reaching.client_events import Listeners
from services.reaching.client_settings import SettingRequests
from services.reaching.client_types import (
    MotionFailedError,
    RequestRefusedError,
    Rotation,
    tip_pose,
)
from services.reaching.messages import TipPose

QUARTER = np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])  # about z


def event(kind: str, checkpoint: float = math.nan) -> CartesianEvent:
    return CartesianEvent(
        stamp_ns=0, kind=kind, motion=MotionState(motion=1), checkpoint=checkpoint
    )


@pytest.mark.parametrize(
    ("rotation", "numbers"),
    [
        (QUARTER, (0.0, 0.0, math.pi / 2)),
        ((0.1, 0.2, 0.3), (0.1, 0.2, 0.3)),
        ((0.0, 0.0, 2.0, 0.5), (0.0, 0.0, 2.0, 0.5)),
    ],
)
def test_a_rotation_may_be_a_matrix_a_vector_or_an_axis_with_an_angle(
    rotation: Rotation, numbers: tuple[float, ...]
) -> None:
    assert tip_pose(None, rotation).rotation_rad == pytest.approx(numbers)


@pytest.mark.parametrize("rotation", [2.0 * QUARTER, -QUARTER, (0.0, 1.0), np.zeros((2, 3))])
def test_what_is_no_rotation_is_an_error(rotation: Rotation) -> None:
    with pytest.raises(ServiceError, match="rotation"):
        tip_pose((0.0, 0.0, 0.0), rotation)


def test_a_position_has_three_numbers() -> None:
    assert tip_pose(np.array([1.0, 2.0, 3.0]), None) == TipPose(position_m=(1.0, 2.0, 3.0))
    with pytest.raises(ServiceError, match="3 numbers"):
        tip_pose((1.0, 2.0), None)


def test_events_go_to_those_that_want_them() -> None:
    listeners = Listeners()
    heard: list[tuple[str, str]] = []
    listeners.add("*", None, lambda e: heard.append(("all", e.kind)))
    half = listeners.add("motion-ongoing", 0.5, lambda e: heard.append(("half", e.kind)))
    listeners.add("motion-done", None, lambda e: heard.append(("done", e.kind)))
    for told in (event("motion-ongoing", 0.25), event("motion-ongoing", 0.5), event("motion-done")):
        listeners.tell(told)
    assert heard == [
        ("all", "motion-ongoing"),
        ("all", "motion-ongoing"),
        ("half", "motion-ongoing"),
        ("all", "motion-done"),
        ("done", "motion-done"),
    ]
    assert listeners.remove(half)
    assert not listeners.remove(half)


@pytest.mark.parametrize(("kind", "checkpoint"), [("motion", None), ("motion-done", 0.5)])
def test_there_is_no_such_event(kind: str, checkpoint: float | None) -> None:
    with pytest.raises(ServiceError):
        Listeners().add(kind, checkpoint, lambda _: None)


def test_a_motion_that_ends_elsewhere_is_an_error_with_its_reason() -> None:
    reached = MotionState(motion=1, outcome="reached")
    assert ended_well(reached) is reached
    lost = MotionState(motion=2, limb="left_arm", outcome="lost", reason="l_elbow is in idle")
    with pytest.raises(MotionFailedError, match="motion 2 of left_arm lost: l_elbow is in idle"):
        ended_well(lost)


def test_a_refusal_is_an_error_with_its_reason() -> None:
    def refuse(request: CartesianRequest) -> CartesianReply:
        return CartesianReply(ok=False, reason=f"no {request.action} for {request.limb}")

    arm = SettingRequests("left_arm", refuse)
    for call in (arm.pose, arm.desired, arm.speeds, arm.settings, arm.tip, arm.store_context):
        with pytest.raises(RequestRefusedError, match="left_arm"):
            call()


def test_without_a_stack_both_clients_say_how_to_start_one() -> None:
    with pytest.raises(NotRunningError, match="ulna up"):
        BlockingCartesianControl(stack="nobody")

    async def enter() -> None:
        async with CartesianControl(stack="nobody"):
            pass

    with pytest.raises(NotRunningError, match="ulna up"):
        asyncio.run(enter())


def test_a_client_that_is_not_entered_is_not_connected() -> None:
    async def ask() -> None:
        await CartesianControl().pose()

    with pytest.raises(ServiceError, match="not connected"):
        asyncio.run(ask())


def test_a_callback_that_fails_is_reported(caplog: pytest.LogCaptureFixture) -> None:
    called: Future[None] = Future()
    called.set_exception(ValueError("in the callback"))
    log_failure(called)
    assert "a callback has failed" in caplog.text
    assert "in the callback" in caplog.text
