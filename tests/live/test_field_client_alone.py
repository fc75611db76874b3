"""The Python client of the field on a hub, before whatever answers its requests."""

import asyncio
import threading
from collections.abc import Iterator

import pytest

from services.core.clock import NS_PER_S, RealClock
from services.core.loop import LiveExecutor
from services.core.rundir import Claim
from services.core.service import Inputs, Outputs, Period, Service
from services.core.session import connect, disconnect, open_hub
from services.fields.client import BlockingFieldControl, FieldControl
from services.fields.messages import FieldReply, FieldRequest
from services.messages import WorldObject
from services.streams import FIELD_CALL

pytestmark = pytest.mark.live

BALL = WorldObject(name="ball", shape="sphere", size_m=(0.05,), position_m=(0.1, 0.2, 0.3))
LONG_S = 20.0


class Asked(Service):
    """Takes every request, and notes it."""

    serves = (FIELD_CALL,)
    trigger = Period(0.01)

    def __init__(self) -> None:
        self.requests: list[FieldRequest] = []

    def step(self, now_ns: int, inputs: Inputs, outputs: Outputs) -> None:  # noqa: ARG002
        for token, request in inputs.requests(FIELD_CALL):
            self.requests.append(request)
            outputs.reply(FIELD_CALL, token, FieldReply(ok=True))


@pytest.fixture
def asked() -> Iterator[list[FieldRequest]]:
    """What has been asked of the field of a stack that has nothing else."""
    claim, service = Claim("icub", "icub"), Asked()
    with open_hub() as hub:
        claim.publish(hub.endpoint, "zenoh")
        session = connect(hub.endpoint)
        executor = LiveExecutor("field", service, session, "icub", RealClock())
        running = threading.Thread(target=executor.run)
        running.start()
        yield service.requests
        executor.stop()
        running.join()
        disconnect(session)
    claim.release()


def test_what_a_client_has_published_goes_with_it(asked: list[FieldRequest]) -> None:
    with BlockingFieldControl(source="eyes") as field:
        field.publish((BALL,))
    assert [(one.action, one.source) for one in asked] == [("forget", "eyes")]


def test_what_is_to_be_kept_stays_and_what_is_gone_is_not_asked_for(
    asked: list[FieldRequest],
) -> None:
    with BlockingFieldControl(keep_objects=True) as field:
        field.publish((BALL,))
    with BlockingFieldControl() as field:
        field.publish((BALL,))
        field.publish(())
    assert asked == []


def test_a_wait_that_is_given_up_does_not_hold_the_program_up(asked: list[FieldRequest]) -> None:
    async def give_up() -> None:
        async with FieldControl() as field:
            with pytest.raises(TimeoutError):
                await asyncio.wait_for(field.wait_for("arrived", timeout_s=LONG_S), 0.05)

    clock = RealClock()
    begun_ns = clock.now_ns()
    asyncio.run(give_up())
    assert clock.now_ns() - begun_ns < 0.25 * LONG_S * NS_PER_S
    assert asked == []
