"""`ulna can` on a SocketCAN interface, with no stack there."""

from pathlib import Path

import pytest

from hal.buses.socketcan import SocketCanBus, interfaces_up
from services.core.clock import RealClock
from tests.live.verbs import exercise

INTERFACE = "vcan2"  # the right arm's in the robot file

pytestmark = [
    pytest.mark.live,
    pytest.mark.skipif(
        not interfaces_up([INTERFACE]), reason=f"{INTERFACE} is not up on this kernel"
    ),
]


def test_verbs_speak_on_an_interface(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    with SocketCanBus(INTERFACE, RealClock()) as bus:
        exercise(bus, INTERFACE, "", tmp_path, capsys)
