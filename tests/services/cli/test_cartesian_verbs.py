"""`ulna cartesian`: what it prints, and one sentence for what cannot be done."""

import math

import numpy as np
import pytest

from services.cli.cartesian_tables import motion_line, pose_lines, status_lines
from services.cli.main import main
from services.messages import NAN3, CartesianStatus
from services.reaching.cartesian_messages import MotionState
from services.reaching.client_types import Pose

TURNED_TWICE = ("--rotation", "0", "0", "1", "--axis-angle", "0", "0", "1", "1")
REACHED = MotionState(
    motion=3,
    limb="left_arm",
    outcome="reached",
    progress=1.0,
    position_error_m=0.0021,
    orientation_error_rad=math.radians(0.4),
)
GOING = MotionState(motion=4, limb="left_arm", done=False, progress=0.456)
NEAR = MotionState(
    motion=6,
    limb="left_arm",
    outcome="reached",
    position_error_m=0.0021,
    out_of_reach="nearest position is 1.5 m away",
)
LOST = MotionState(motion=5, limb="left_arm", outcome="lost", reason="l_elbow is in idle")


@pytest.mark.parametrize(
    ("motion", "line"),
    [
        (REACHED, "motion 3 of left_arm: reached, 2.1 mm and 0.4 deg away"),
        (GOING, "motion 4 of left_arm: 46 % of the way"),
        (
            NEAR,
            "motion 6 of left_arm: reached, 2.1 mm from the nearest pose; "
            "out of reach: nearest position is 1.5 m away",
        ),
        (LOST, "motion 5 of left_arm: lost: l_elbow is in idle"),
    ],
)
def test_a_motion_is_told_in_one_line(motion: MotionState, line: str) -> None:
    assert motion_line(motion) == line


def test_a_status_tells_who_commands_and_what_is_missing() -> None:
    status = CartesianStatus(
        stamp_ns=0,
        state="waiting",
        q_rad=(),
        hand_position_m=NAN3,
        hand_rotation_rad=NAN3,
        mode="field",
        limb="right_arm",
        reason="no joint states of torso",
        ignored=12,
    )
    assert list(status_lines(status, MotionState(motion=0))) == [
        "field, right_arm: waiting",
        "nothing is commanded: no joint states of torso",
        "12 virtual points ignored while requests commanded",
    ]


def test_a_hand_is_shown_as_a_command_line_takes_it() -> None:
    turned = np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])
    pose = Pose(np.array([-0.3, 0.2, 0.1]), turned)
    line = "hand: --position -0.3000 0.2000 0.1000 --rotation 0.0000 0.0000 1.5708"
    assert list(pose_lines((pose,))) == [line]


@pytest.mark.parametrize(
    "words",
    [
        ("status",),
        ("go", "--position", "-0.3", "0.2", "0.1"),
        ("position", "-0.3", "0.2", "0.1"),
        ("stop",),
        ("ask", "--position", "-0.3", "0.2", "0.1"),
        ("info",),
    ],
)
def test_without_a_stack_every_verb_says_how_to_start_one(
    words: tuple[str, ...], capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["cartesian", *words, "--stack", "nobody"]) == 2
    error = capsys.readouterr().err
    assert error.startswith("ulna: no stack named 'nobody' is up here")
    assert "start one with `ulna up`" in error


@pytest.mark.parametrize(
    ("words", "expected"),
    [
        (("go",), "no pose is given: --position, --rotation or --axis-angle"),
        (("ask",), "no pose is given: --position, --rotation or --axis-angle"),
        (("go", *TURNED_TWICE), "give --rotation or --axis-angle, not both"),
        (("ask", *TURNED_TWICE), "give --rotation or --axis-angle, not both"),
        (
            ("go", "--position", "-0.3", "0.2", "0.1", "--second-position", "-0.3", "-0.2", "0.1"),
            "--second-position and --second-rotation are of --limb both_arms",
        ),
    ],
)
def test_no_part_of_a_pose_is_passed_over_in_silence(
    words: tuple[str, ...], expected: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["cartesian", *words]) == 2
    assert expected in capsys.readouterr().err
