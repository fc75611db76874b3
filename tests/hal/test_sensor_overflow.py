"""What sensor boards say when their receive queue was full (can-protocol 3.1)."""

import pytest

from tests.hal.sensor_bench import ADDRESSES, SensorBench


@pytest.mark.parametrize(("name", "frame"), [("strain", "1D0 "), ("mais", "1E0 "), ("mtb", "7C5 ")])
def test_a_full_receive_queue_of_a_board_is_reported_once(name: str, frame: str) -> None:
    bench = SensorBench().open()
    bench.say(frame, frame)
    bench.tick()

    address = ADDRESSES[name]
    assert bench.faults == (
        f"board {name} (bus 1, address {address}) has lost commands: its receive queue was full",
    )
    assert bench.drops == {}
    bench.close()
