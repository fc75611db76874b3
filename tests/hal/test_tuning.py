"""Changing gains and limits while the robot runs."""

import pytest
from msgspec.structs import replace

from hal.description import Impedance
from hal.tasks import Task
from hal.tuning import CurrentLimit, Tuning, VelocityLimit
from tests.hal.arm import DESCRIPTION, ROLL, SHOULDER_PID, TORQUE_PID
from tests.hal.scripted import Script, frame


@pytest.fixture
def script() -> Script:
    script = Script()
    script.ready()
    return script


def tuned(script: Script, change: Tuning) -> tuple[Task, list[str]]:
    task = script.robot.tune("roll", change)
    sent: list[str] = []
    while not task.done:
        sent += script.tick()
    return task, sent


def test_writes_what_differs_and_reads_it_back(script: Script) -> None:
    task, sent = tuned(script, replace(SHOULDER_PID, kp=16000, ki=30))

    assert task.ok, task.reason
    assert sent == ["001 9E803E", "001 A21E00", "001 9F", "001 A3"]


def test_keeps_to_the_new_gains_when_a_foreign_host_meddles(script: Script) -> None:
    tuned(script, replace(SHOULDER_PID, kp=16000))
    script.say("001 9E0000")

    assert "001 9E803E" in script.tick(60)


@pytest.mark.parametrize(
    ("change", "reason"),
    [
        (
            replace(SHOULDER_PID, kp=-32000),
            "roll: kp -32000 has the opposite sign of the robot file's kp 32000: positive feedback",
        ),
        (replace(SHOULDER_PID, kd=-1), "roll: kd -1 has the opposite sign"),
        (replace(SHOULDER_PID, shift=16), "roll: shift 16 is not within 0 and 15"),
        (replace(SHOULDER_PID, output_limit=801), "roll: output_limit 801 is not within 0 and 800"),
        (replace(SHOULDER_PID, kp=40000), "roll: SET_P_GAIN"),
        (replace(TORQUE_PID, kp=76), "roll: kp 76 has the opposite sign"),
        (Impedance(stiffness_nm_deg=-0.1, damping_nms_deg=0.0), "roll: stiffness -0.1 is negative"),
        (Impedance(stiffness_nm_deg=1e6, damping_nms_deg=0.0), "roll: SET_IMPEDANCE_PARAMS"),
        (CurrentLimit(7001), "roll: current limit 7001 mA is not above 0 and at most 7000"),
        (VelocityLimit(0.0), "roll: velocity limit 0 deg/s is not above 0 and at most 60"),
        (VelocityLimit(61.0), "roll: velocity limit 61 deg/s"),
    ],
)
def test_refuses_what_would_not_be_safe(script: Script, change: Tuning, reason: str) -> None:
    task = script.robot.tune("roll", change)

    assert task.done
    assert task.reason.startswith(reason)
    assert script.tick() == []


def test_refuses_torque_gains_where_the_robot_file_has_none(script: Script) -> None:
    assert script.robot.tune("wrist", TORQUE_PID).reason == (
        "wrist has no torque gains in the robot file, so their sign is not known"
    )


def test_writes_the_old_gains_again_when_the_board_does_not_keep_the_new(script: Script) -> None:
    script.bus.answers[frame("001 9F")] = frame("010 9F007D")
    script.bus._settings.discard(frame("001 9F"))
    task, sent = tuned(script, replace(SHOULDER_PID, kp=16000))

    assert task.reason == (
        "roll SET_P_GAIN: wrote 16000, read 32000; the old settings are written again"
    )
    assert [one for one in sent if "9E" in one] == ["001 9E803E", "001 9E803E", "001 9E007D"]
    assert script.robot._machine.axes[ROLL].joint == DESCRIPTION.joints[ROLL]


def test_a_slower_joint_takes_smaller_steps(script: Script) -> None:
    script.status(0x113, 0x01, 0x08)
    script.tick()
    task, sent = tuned(script, VelocityLimit(6.0))
    assert task.ok
    assert sent[0] == "001 C41100"  # 17 of 2^-8 ticks/ms
    script.robot.set_positions([ROLL], [0.0])

    # From 920 ticks, 6 deg/s is 0.68 ticks in 10 ms: 919, then 919, 918.
    assert script.tick(30) == ["001 BE97030000", "001 BE97030000", "001 BE96030000"]


def test_changes_a_current_limit(script: Script) -> None:
    task, sent = tuned(script, CurrentLimit(5000))

    assert task.ok
    assert sent == ["001 C888130000"]


def test_changes_a_spring(script: Script) -> None:
    task, sent = tuned(script, Impedance(stiffness_nm_deg=0.2, damping_nms_deg=0.03))

    assert task.ok, task.reason
    assert sent[0] == "001 D74800332A000000"  # half of example 20


def test_does_not_tune_an_axis_that_is_busy(script: Script) -> None:
    script.robot.request("mode", ["roll"], "direct")

    assert script.robot.tune("roll", CurrentLimit(5000)).reason == "busy: mode uses this joint"


def test_lists_the_joints(script: Script) -> None:
    assert "known: pitch, roll, prosup" in script.robot.tune("knee", CurrentLimit(1)).reason
