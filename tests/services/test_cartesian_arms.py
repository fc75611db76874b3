"""Which arm moves: auto, handover from one limb to another."""

import numpy as np
import pytest

from dforc.arrays import Vector
from services.config import load_robot
from services.core.service import Outputs
from services.reaching.arm_choice import nearer_arm
from services.reaching.messages import TipPose
from services.streams import EXTERNAL
from services.wholebody.dynamics_messages import ContactEstimate, Contacts
from tests.services.cartesian_stand import Stand

HANDS_M = {"left_arm": (-0.3, -0.2, 0.0), "right_arm": (-0.3, 0.2, 0.0)}


@pytest.fixture
def stand() -> Stand:
    return Stand(load_robot("icub:arms"))


def beside(hand_m: Vector, metres: float) -> tuple[TipPose]:
    x, y, z = (hand_m + np.array([-0.03, metres, 0.03])).tolist()
    return (TipPose(position_m=(x, y, z)),)


@pytest.mark.parametrize(
    ("y_m", "before", "chosen"),
    [
        (0.15, "", "right_arm"),
        (-0.15, "", "left_arm"),
        (0.02, "left_arm", "left_arm"),  # nearer to the right one by 4 cm only
        (0.03, "left_arm", "right_arm"),  # by 6 cm
        (-0.02, "right_arm", "right_arm"),
        (0.0, "nose", "left_arm"),  # what is not there any more does not count
    ],
)
def test_the_nearer_hand_is_chosen_with_hysteresis(y_m: float, before: str, chosen: str) -> None:
    assert nearer_arm((-0.3, y_m, 0.0), HANDS_M, before) == chosen


def test_auto_moves_the_nearer_hand(stand: Stand) -> None:
    for limb, outward_m in (("left_arm", -0.02), ("right_arm", 0.02)):
        reply = stand.ask("go", "auto", poses=beside(stand.hands(limb)[0][1], outward_m))
        assert reply.ok, reply.reason
        assert reply.limb == limb
        assert reply.motion is not None
        assert stand.wait(reply.motion.motion).limb == limb
        assert stand.status.limb == limb


def test_auto_does_not_flap_between_targets_in_the_middle(stand: Stand) -> None:
    middle = 0.5 * (stand.hands("left_arm")[0][1] + stand.hands("right_arm")[0][1])
    chosen = [
        stand.ask("ask", "auto", poses=beside(middle, metres)).limb
        for metres in (-0.02, 0.02, -0.02, 0.02, -0.01, 0.01)
    ]
    assert len(set(chosen)) == 1


def test_auto_needs_one_position(stand: Stand) -> None:
    assert not stand.ask("go", "auto", poses=(TipPose(rotation_rad=(0.0, 0.0, 1.0)),)).ok
    assert not stand.ask("go", "auto", poses=(TipPose(position_m=(np.nan, 0.0, 0.0)),)).ok
    assert not stand.ask("go", "auto", poses=()).ok


def test_auto_leaves_out_an_arm_that_is_not_known(stand: Stand) -> None:
    stand.joints.invalid.add("left_arm")
    stand.run(0.1)
    left_m = stand.hands("left_arm")[0][1]
    assert stand.ask("ask", "auto", poses=beside(left_m, 0.0)).limb == "right_arm"


def test_a_handover_first_stops_the_hand_that_moves(stand: Stand) -> None:
    stand.go((-0.05, 0.0, 0.05), "left_arm")
    stand.run(0.8)
    assert stand.go((-0.05, 0.0, 0.05), "right_arm").ok
    left = stand.ended(1)
    assert left is not None
    assert left.outcome == "replaced"
    assert "right_arm is to move" in left.reason
    speeds = [c.dq_rad_s for part, c in stand.joints.commands if part == "left_arm"]
    assert np.abs(speeds[-1]).max() < 0.02
    assert stand.wait(2).outcome == "reached"
    after = [part for part, c in stand.joints.commands if c.stamp_ns > left_end_ns(stand)]
    assert "left_arm" not in after


def left_end_ns(stand: Stand) -> int:
    return next(e.stamp_ns for e in stand.caller.events if e.kind == "motion-done")


def test_the_waist_goes_on_from_where_the_other_arm_left_it(stand: Stand) -> None:
    assert stand.go((-0.12, 0.0, 0.05), "left_arm").ok
    stand.wait(1)
    stand.run(0.05)
    count = len(stand.joints.commands)
    before = [stand.joints.q_rad[joint] for joint in stand.robot.parts["torso"]]
    assert np.abs(before).max() > 0.01
    stand.go((-0.02, 0.0, 0.02), "right_arm")
    stand.run(0.05)
    first = next(c for part, c in stand.joints.commands[count:] if part == "torso")
    assert first.q_rad == pytest.approx(before, abs=1e-3)


def test_a_push_on_the_arm_in_use_is_felt_by_its_own_sensor() -> None:
    stand = Stand(load_robot("icub:arms"), writes=(EXTERNAL,))

    def push(now_ns: int, outputs: Outputs) -> None:
        felt = [("l_arm_ft", (0.0, 0.0, -20.0)), ("r_arm_ft", (5.0, 0.0, 0.0))]
        contacts = tuple(
            ContactEstimate(
                limb="",
                link="",
                point_m=(0.0, 0.0, 0.0),
                force_n=force_n,
                moment_nm=(0.0, 0.0, 0.0),
                touching=True,
                location="assumed",
                sensor=sensor,
            )
            for sensor, force_n in felt
        )
        outputs.put(EXTERNAL, Contacts(stamp_ns=now_ns, contacts=contacts))

    stand.caller.stream = push
    stand.go((-0.05, 0.0, 0.05), "left_arm")
    stand.run(0.1)
    assert stand.status.external_force_n == pytest.approx(20.0)
    assert stand.status.gated


def test_one_arm_alone_knows_no_other() -> None:
    stand = Stand(load_robot("icub:reach"))
    assert not stand.ask("go", "left_arm", poses=stand.poses((-0.02, 0.0, 0.0))).ok
    assert not stand.ask("go", "both_arms", poses=stand.poses((-0.02, 0.0, 0.0))).ok
    assert stand.ask("ask", "auto", poses=stand.poses((-0.02, 0.0, 0.0))).limb == "right_arm"
