"""Calibration that can be broken off, goes on where it stopped, and is told while it runs."""

from hal.wire.modes import ControlMode
from tests.hal.emulated import Bench

JOINTS = ("pitch", "roll", "prosup", "wrist")


def states(bench: Bench) -> dict[str, str]:
    return dict(bench.robot.status().calibration)


def test_tells_the_progress_of_every_joint(bench: Bench) -> None:
    bench.open()
    assert states(bench) == dict.fromkeys(JOINTS, "pending")
    task = bench.robot.request("calibrate")
    bench.tick(300)
    assert states(bench) == {**dict.fromkeys(JOINTS, "pending"), "pitch": "done", "roll": "done"}
    bench.finish(task)

    assert states(bench) == dict.fromkeys(JOINTS, "done")


def test_goes_on_where_it_was_broken_off(bench: Bench) -> None:
    bench.open()
    bench.robot.request("calibrate")
    bench.tick(300)
    bench.robot.request("stop")
    bench.tick(300)
    assert list(states(bench).values()) == ["done", "done", "pending", "pending"]
    began_deg = list(bench.angles_deg[:2])
    task = bench.robot.request("calibrate")
    bench.finish(task)

    assert task.ok, task.reason
    assert states(bench) == dict.fromkeys(JOINTS, "done")
    assert [axis.mode for axis in bench.axes] == [ControlMode.POSITION] * 4
    for before, after in zip(began_deg, bench.angles_deg[:2], strict=True):
        assert abs(after - before) < 1.0  # held where they were, not calibrated again


def test_keeps_the_reason_of_a_failure_until_it_is_tried_again(bench: Bench) -> None:
    bench.open()
    bench.axes[1].port.hall_fault = 1
    task = bench.robot.request("calibrate", ["pitch", "roll"])
    bench.finish(task)
    assert states(bench)["pitch"] == "done"
    assert states(bench)["roll"].startswith("failed: roll")
    bench.axes[1].port.hall_fault = 0
    bench.finish(bench.robot.request("calibrate", ["roll"]))

    assert states(bench)["roll"] == "done"


def test_calibrates_again_when_told_so(ready: Bench) -> None:
    ready.robot.request("calibrate", ["roll"], "again")
    ready.tick(5)

    assert states(ready)["roll"] == "pending"
    assert ready.robot.request("calibrate", ["wrist"], "twice").reason == (
        "unknown value 'twice'; known: again"
    )


def test_switches_calibrated_joints_on_without_touching_their_zero(ready: Bench) -> None:
    ready.finish(ready.robot.request("mode", value="idle"))
    task = ready.robot.request("calibrate")
    ready.finish(task, 500)

    assert task.ok
    assert [axis.mode for axis in ready.axes] == [ControlMode.POSITION] * 4


def test_parks_in_the_time_given_and_switches_off(ready: Bench) -> None:
    task = ready.robot.request("park", ["pitch"], q_rad=[-0.6], duration_s=5.0)
    ready.finish(task, 5000)

    assert task.ok, task.reason
    assert abs(ready.angles_deg[0] - -34.4) < 0.6
    assert not ready.axes[0].enabled
    assert ready.axes[1].enabled


def test_gives_parking_up_when_its_time_is_over(ready: Bench) -> None:
    ready.boards.board(1, 1).axes[0].pwm_limit = 0  # it cannot move
    task = ready.robot.request("park", ["pitch"], q_rad=[-1.2], duration_s=1.0)
    ready.finish(task, 1100)

    assert task.reason == "the limb was still moving when its time was up"
    assert not ready.axes[0].enabled


def test_refuses_to_park_for_too_long_or_where_it_cannot_be(ready: Bench) -> None:
    refused = ready.robot.request("park", ["pitch"], q_rad=[-0.6], duration_s=31.0)
    assert refused.reason == "duration_s 31.0 is not within 0 and 30"
    assert "is outside" in ready.robot.request("park", ["pitch"], q_rad=[2.0]).reason
