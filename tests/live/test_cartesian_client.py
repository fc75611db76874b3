"""The Python client and `ulna cartesian` on a live stack: what a user does, not how fast."""

import re
from pathlib import Path

import numpy as np
import pytest

from services.cli.main import main
from services.processes import HUB, PROCESSES
from services.reaching.client import (
    BlockingCartesianControl,
    MotionFailedError,
    RequestRefusedError,
    WaitTimeoutError,
)
from services.stack import Stack

pytestmark = pytest.mark.live

ROOT = Path(__file__).resolve().parents[2]
STACK = "icub"
NEEDED = ("boards", "robot", "ik", "cartesian")
ATTEMPTS = 3  # a host that has no time for the stack loses joint states, which ends a motion


def snippet() -> str:
    text = (ROOT / "docs" / "cartesian.md").read_text(encoding="utf-8")
    (found,) = re.findall(r"```python\n(.*?)```", text, flags=re.DOTALL)
    return str(found)


def run_snippet() -> None:
    for attempt in range(ATTEMPTS):
        try:
            exec(compile(snippet(), "docs/cartesian.md", "exec"), {"__name__": "cartesian_page"})
        except MotionFailedError as error:
            if error.state.outcome != "lost" or attempt == ATTEMPTS - 1:
                raise
        else:
            return


def drive_blocking() -> None:
    with BlockingCartesianControl(limb="right_arm") as arm:
        kinds: list[str] = []
        listener = arm.on("*", lambda event: kinds.append(event.kind))
        here = arm.pose()
        above = here.position_m + np.array([0.0, 0.0, 0.03])
        motion = arm.go_to_pose(above, here.rotation, time_s=20.0)
        with pytest.raises(WaitTimeoutError):
            arm.wait_motion_done(timeout_s=0.2)
        arm.stop()
        with pytest.raises(MotionFailedError, match="stopped: by request"):
            arm.wait_motion_done()
        assert arm.motion(motion.motion).outcome == "stopped"
        arm.off(listener)
        assert kinds[0] == "motion-onset"
        context = arm.store_context()
        arm.change(free={"torso_yaw": False}, trajectory_time_s=1.5)
        assert not arm.settings().free["torso_yaw"]
        arm.restore_context(context)
        assert arm.settings().free["torso_yaw"]
        with pytest.raises(RequestRefusedError, match="narrowed"):
            arm.change(limits_rad={"r_elbow": (-9.0, 9.0)})


def test_hands_are_moved_from_python_and_from_the_command_line(
    capsys: pytest.CaptureFixture[str],
) -> None:
    rows = (HUB, *(row for row in PROCESSES if row.name in NEEDED))

    def joints(word: str) -> int:
        return main(["joints", word, "--stack", STACK])

    def verb(*words: str) -> int:
        return main(["cartesian", *words, "--stack", STACK])

    with Stack("icub:reach", name=STACK, can="zenoh", rows=rows):
        assert verb("status") == 1
        assert "ulna joints calibrate" in capsys.readouterr().err
        assert joints("calibrate") == 0
        assert joints("home") == 0
        assert verb("position", "-0.3", "0.2", "0.1") == 1
        assert "ulna joints direct" in capsys.readouterr().err
        run_snippet()
        printed = capsys.readouterr().out
        assert "half way" in printed
        assert "reached" in printed
        assert "out of reach" in printed

        assert joints("direct") == 0
        drive_blocking()

        assert verb("ask", "--position", "-0.3", "0.2", "0.1") == 0
        assert verb("ask", "--position", "-3", "0.2", "0.1") == 1
        assert verb("info") == 0
        assert verb("go", "--position", "-0.3", "0.2", "0.1", "--no-wait") == 0
        assert verb("stop") == 0
        assert verb("status") == 0
        assert "hand: --position" in capsys.readouterr().out
