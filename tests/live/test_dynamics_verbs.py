"""`ulna joints`, `dynamics` and `learner` on a live stack: an arm moves and is identified."""

from pathlib import Path

import pytest

from services.cli.main import main
from services.processes import HUB, PROCESSES
from services.stack import Stack

pytestmark = pytest.mark.live

ROBOT = "icub:reach"
STACK = "feeling"
NEEDED = ("boards", "robot", "dynamics", "learner")


def assert_shown(capsys: pytest.CaptureFixture[str], *texts: str) -> None:
    """All of them were printed since the last look."""
    printed = capsys.readouterr().out
    assert [text for text in texts if text not in printed] == []


def joints(*words: str) -> int:
    return main(["joints", *words, "--stack", STACK])


def calibrate_and_move_the_joints(capsys: pytest.CaptureFixture[str]) -> None:
    assert joints("calibrate") == 0
    assert joints("compliant", "r_elbow") == 1
    assert "ulna dynamics calibrate" in capsys.readouterr().err
    assert joints("home") == 0
    assert joints("status", "r_elbow") == 0
    assert_shown(capsys, "r_elbow", "position")


def keep_and_restore_what_was_learned(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    def learner(*words: str) -> int:
        return main(["learner", *words, "--stack", STACK])

    state = tmp_path / "arm.state"
    assert learner("status") == 0
    assert "learning" in capsys.readouterr().out
    assert learner("save", str(state)) == 0
    assert state.stat().st_size > 0
    assert learner("freeze") == 0
    assert learner("restore", str(state)) == 0
    assert learner("restore", str(tmp_path / "none.state")) == 1
    assert "none.state" in capsys.readouterr().err
    assert learner("reset", "nose") == 1
    assert learner("resume") == 0


def test_a_sensor_is_calibrated_identified_learned_and_reset(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    rows = (HUB, *(row for row in PROCESSES if row.name in NEEDED))

    def verb(*words: str) -> int:
        return main(["dynamics", *words, "--stack", STACK])

    with Stack(ROBOT, name=STACK, can="zenoh", rows=rows):
        assert verb("calibrate") == 1
        assert "ulna joints calibrate" in capsys.readouterr().err
        calibrate_and_move_the_joints(capsys)

        assert verb("calibrate", "r_arm_ft") == 0
        assert "r_arm_ft" in capsys.readouterr().out
        assert verb("calibrate", "nose") == 1
        assert "no sensor 'nose' here; there is r_arm_ft" in capsys.readouterr().err
        assert joints("compliant", "r_elbow") == 0
        assert joints("stiff") == 0
        assert verb("status") == 0
        assert "no torques" not in capsys.readouterr().out

        out = str(tmp_path / "gain.toml")
        assert verb("identify", "r_arm_ft", "--moves", "5", "--degrees", "30", "--out", out) == 0
        assert_shown(capsys, "of 6 directions", Path(out).read_text(encoding="utf-8"))

        keep_and_restore_what_was_learned(tmp_path, capsys)

        assert verb("assume", "custom", "r_hand", "r_forearm") == 0
        assert verb("status") == 0
        assert "a touch on it cannot be told" in capsys.readouterr().out
        assert verb("assume", "default") == 0
        assert verb("source", "moon") == 1
        assert "there are: base" in capsys.readouterr().err

        assert verb("reset") == 0
        assert verb("status") == 1
        assert "uncalibrated" in capsys.readouterr().out
        assert joints("park") == 0
        assert joints("home") == 1
        assert "is idle" in capsys.readouterr().err
