"""The IK service refuses what is no request, says why, and goes on."""

import pytest

from services.core.testing import Bench
from services.ik import Ik
from services.reaching.messages import IkRequest, LimbSetup, PoseTarget, TipPose
from services.robotfile.robot_tables import RobotFile
from tests.services.asking import HERE, HOME_RAD, ask, at, refusal, standing

NAN = float("nan")


@pytest.fixture
def bench(robot: RobotFile) -> Bench:
    return standing(robot)


@pytest.mark.parametrize(
    ("request_", "expected"),
    [
        (IkRequest(poses=()), "0 poses; between 1 and 5000"),
        (IkRequest(poses=(HERE,) * 5001), "5001 poses"),
        (IkRequest(poses=(HERE, at(NAN, 0.0, 0.0))), "pose 1: target position is not finite"),
        (IkRequest(poses=(at(1e300, 0.0, 0.0),)), "pose 0: target position (1e+300, 0.0, 0.0) is"),
        (
            IkRequest(poses=(PoseTarget(tips=(TipPose(rotation_rad=(NAN, 0.0, 0.0)),)),)),
            "pose 0: rotation vector is not finite",
        ),
        (
            IkRequest(poses=(PoseTarget(tips=(TipPose(rotation_rad=(0.0, 0.0, 0.0, 1.0)),)),)),
            "pose 0: rotation by 1 rad about an axis of length 0",
        ),
        (
            IkRequest(poses=(PoseTarget(tips=(TipPose(rotation_rad=(NAN, 0.0, 0.0, 1.0)),)),)),
            "pose 0: rotation by 1 rad about an axis of length nan",
        ),
        (
            IkRequest(poses=(PoseTarget(tips=(TipPose(rotation_rad=(1.0, 0.0)),)),)),
            "pose 0: a rotation is a vector of 3 numbers or axis and angle, 4; not 2",
        ),
        (IkRequest(poses=(PoseTarget(tips=()),)), "pose 0: neither position nor orientation"),
        (IkRequest(poses=(PoseTarget(tips=(TipPose(),)),)), "pose 0: neither position nor"),
        (IkRequest(poses=(PoseTarget(tips=HERE.tips * 2),)), "pose 0: 2 tips; the limb has 1"),
        (IkRequest(poses=(HERE,), limb="tail"), "unknown limb 'tail'; there are: right_arm"),
        (IkRequest(poses=(HERE,), start_rad=(0.0,) * 9), "start has shape (9,), expected (10,)"),
        (IkRequest(poses=(HERE,), start_rad=(NAN,) * 10), "start is not finite"),
        (IkRequest(poses=(HERE,), start_rad=(1e100,) * 10), "start: a joint at more than 100 rad"),
        (IkRequest(poses=(HERE,), deadline_ms=-1.0), "a deadline of -1.0 ms"),
        (IkRequest(poses=(HERE,), deadline_ms=NAN), "a deadline of nan ms"),
        (
            IkRequest(poses=(HERE,), setup=LimbSetup(limb="left_arm")),
            "a set-up of 'left_arm' for 'right_arm'",
        ),
        (
            IkRequest(poses=(HERE,), setup=LimbSetup(limb="", solver="magic")),
            "unknown solver 'magic'; known: sqp, ipopt, fatrop",
        ),
        (
            IkRequest(poses=(HERE,), setup=LimbSetup(limb="", rest_rad=(0.0,))),
            "rest_rad has 1 values; the limb has 10 joints",
        ),
        (
            IkRequest(poses=(HERE,), setup=LimbSetup(limb="", lower_rad=(9.0,) * 10)),
            "joint 0: lower limit 9.0 above upper",
        ),
    ],
)
def test_what_is_no_request_is_refused_with_the_reason(
    bench: Bench, request_: IkRequest, expected: str
) -> None:
    assert expected in refusal(bench, request_)


def test_refusals_are_counted(bench: Bench) -> None:
    assert ask(bench, IkRequest(poses=())).statistics.refused == 1
    ask(bench, IkRequest(poses=(HERE,), limb="tail"))
    reply = ask(bench, IkRequest(poses=(HERE,)))
    assert (reply.statistics.refused, reply.statistics.solves) == (2, 1)


def test_a_posture_that_is_not_known_must_be_given(robot: RobotFile) -> None:
    bench = Bench(Ik(robot))
    assert "measured posture is not known" in refusal(bench, IkRequest(poses=(HERE,)))
    assert ask(bench, IkRequest(poses=(HERE,), start_rad=HOME_RAD)).ok
