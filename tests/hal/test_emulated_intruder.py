"""The HAL against emulated boards that another host gives commands to."""

from collections.abc import Iterator

import pytest

from tests.hal.emulated import Bench


@pytest.fixture
def bench() -> Iterator[Bench]:
    bench = Bench()
    bench.calibrated()
    yield bench
    bench.close()


def intrude(bench: Bench, can_id: int, data: str) -> None:
    bench.buses[2].send_frames([(can_id, bytes.fromhex(data))])


def test_a_mask_set_for_an_axis_that_the_robot_does_not_use(bench: Bench) -> None:
    intrude(bench, 0x004, "C900000000")  # finger ab/adduction, but the mask is the address's
    bench.tick(500)

    (fault,) = bench.robot.status().faults
    assert fault.startswith("foreign host: 1 frames")
    assert bench.robot.is_fresh(3, bench.now_ns)


def test_a_handshake_that_the_board_refuses(bench: Bench) -> None:
    bench.finish(bench.robot.request("mode", ["roll"], "idle"))
    intrude(bench, 0x001, "5B0209")
    bench.tick(3)
    assert not bench.axes[1].node.accepted
    bench.tick(100)

    task = bench.robot.request("mode", ["roll"], "position")
    bench.finish(task)
    assert task.ok, task.reason


@pytest.mark.parametrize("data", ["CB00080000", "840300080A000100"])  # the offset; a calibration
def test_an_encoder_whose_zero_was_moved_counts_as_not_calibrated(bench: Bench, data: str) -> None:
    assert bench.robot.is_fresh(1, bench.now_ns)
    intrude(bench, 0x001, data)
    bench.tick(300)

    assert bench.robot.joints.calibrated == [True, False, True, True]
    assert not bench.robot.is_fresh(1, bench.now_ns)
    assert "roll: another host has moved its encoder's zero, calibrate it again" in (
        bench.robot.status().faults
    )


def test_a_reference_in_direct_mode_is_sent_again_at_once(bench: Bench) -> None:
    bench.finish(bench.robot.request("mode", ["roll"], "direct"))
    q_rad = bench.robot.joints.q_rad[1]
    bench.robot.set_positions([1], [q_rad])
    bench.tick(12)
    wanted = bench.axes[1].reference.ticks
    intrude(bench, 0x001, "BE00040000")
    bench.tick(3)
    assert bench.axes[1].reference.ticks == 1024
    bench.tick(25)

    assert bench.axes[1].reference.ticks == wanted
