"""Which transport a bus is opened over."""

from collections.abc import Iterator

import pytest
import zenoh

from hal.buses.socketcan import SocketCanBus, interfaces_up
from hal.buses.zenoh import ZenohBus
from services.core.clock import RealClock
from services.core.live import LiveBuses
from services.core.session import connect, disconnect, open_hub

pytestmark = pytest.mark.live


@pytest.fixture
def session() -> Iterator[zenoh.Session]:
    with open_hub() as hub:
        opened = connect(hub.endpoint)
        yield opened
        disconnect(opened)


def test_a_mixed_robot_has_zenoh_where_no_interface_is_up(session: zenoh.Session) -> None:
    buses = LiveBuses("mixed", "icub", session, RealClock())
    assert isinstance(buses.open(2, "nocan0"), ZenohBus)
    buses.close()


@pytest.mark.skipif(not interfaces_up(["vcan2"]), reason="vcan2 is not up on this kernel")
def test_a_mixed_robot_has_vcan_and_zenoh_side_by_side(session: zenoh.Session) -> None:
    buses = LiveBuses("mixed", "icub", session, RealClock())
    assert isinstance(buses.open(2, "vcan2"), SocketCanBus)
    assert isinstance(buses.open(3, "nocan0"), ZenohBus)
    buses.close()
