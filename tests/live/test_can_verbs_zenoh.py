"""`ulna can` on the CAN of a running stack, carried by Zenoh."""

from pathlib import Path

import pytest

from hal.buses.zenoh import ZenohBus
from services.core.clock import RealClock
from services.processes import HUB
from services.stack import Stack
from tests.live.verbs import exercise

pytestmark = pytest.mark.live


def test_verbs_speak_on_the_buses_of_a_stack(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    with (
        Stack("icub", name="verbs", rows=(HUB,)) as stack,
        ZenohBus("icub/can2", endpoint=stack.endpoint, clock=RealClock()) as bus,
    ):
        exercise(bus, "right_arm", "verbs", tmp_path, capsys)
