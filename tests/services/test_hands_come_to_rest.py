"""Every axis of both hands comes to rest where it was sent, bent and opened again.

A tendon sticks until the board's integral has grown; a slack one is wound first.
"""

import pytest

from benchmarks.whole_robot import WholeRobot
from hal.units import AxisUnits

SHARES = (0.9, 0.3, 0.4, 0.1, 0.15)  # of the range inside the margins; short ways back stick most
MOST_TICKS = 2
RESTS_MS = 500


@pytest.mark.parametrize("hand", ["left_hand", "right_hand"])
def test_every_axis_of_a_hand_comes_to_rest_within_two_ticks(hand: str) -> None:
    whole = WholeRobot(f"icub:{hand}")
    whole.calibrated()
    joints = whole.hal.description.joints
    assert len(joints) == 9
    units = [AxisUnits(joint, whole.hal.description.velocity_shift) for joint in joints]
    # The Hall sensors of a tendon that bends several joints step together.
    halls = [sum(len(f.hall) for f in whole.file.joints[joint.name].fingers) for joint in joints]
    for share in SHARES:
        q_rad = [one.min_rad + share * (one.max_rad - one.min_rad) for one in units]
        task = whole.hal.request("move", q_rad=q_rad, duration_s=0.5)
        while not task.done:
            whole.tick()
        assert task.ok, task.reason
        for wait_ms in (0, RESTS_MS):
            whole.tick(wait_ms)
            reached = whole.hal.joints.q_rad
            off = {
                joint.name: one.ticks(target) - one.ticks(q)
                for joint, one, target, q in zip(joints, units, q_rad, reached, strict=True)
            }
            most = {
                joint.name: max(MOST_TICKS, count)
                for joint, count in zip(joints, halls, strict=True)
            }
            assert {name: ticks for name, ticks in off.items() if abs(ticks) > most[name]} == {}
    whole.close()
