"""`ulna dynamics` and `ulna learner` on a live stack: an arm is calibrated, moved, identified."""

from pathlib import Path

import numpy as np
import pytest

from services.cli.main import main
from services.cli.up import Stack
from services.config import load_robot
from services.core.clock import NS_PER_S, RealClock
from services.messages import RobotRequest
from services.processes import HUB, PROCESSES
from services.streams import ROBOT_CALL, ROBOT_STATUS

pytestmark = pytest.mark.live

ROBOT = "icub:reach"
STACK = "feeling"
NEEDED = ("boards", "robot", "dynamics", "learner")
PATIENCE_S = 150.0  # one slow core that others use too, and code not yet compiled


def do(stack: Stack, request: RobotRequest) -> None:
    """Have the HAL do something and wait until it has."""
    clock = RealClock()
    client = stack.client
    client.watch(ROBOT_STATUS)
    give_up_ns = clock.now_ns() + round(PATIENCE_S * NS_PER_S)
    reply = client.call(ROBOT_CALL, request)
    while True:
        status = client.latest(ROBOT_STATUS)
        if reply.ok and status is not None and status.finished_task >= reply.task:
            assert reply.task not in dict(status.failed_tasks), status.failed_tasks
            return
        assert clock.now_ns() < give_up_ns, reply.reason
        clock.sleep_until(clock.now_ns() + 20_000_000)
        if not reply.ok:  # the boards are still being looked for
            reply = client.call(ROBOT_CALL, request)


def assert_shown(capsys: pytest.CaptureFixture[str], *texts: str) -> None:
    """All of them were printed since the last look."""
    printed = capsys.readouterr().out
    assert [text for text in texts if text not in printed] == []


def test_a_sensor_is_calibrated_identified_learned_and_reset(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    robot = load_robot(ROBOT)
    home = tuple(np.radians(robot.reach.home_deg).tolist())
    rows = (HUB, *(row for row in PROCESSES if row.name in NEEDED))

    def verb(*words: str) -> int:
        return main(["dynamics", *words, "--stack", STACK])

    def learner(*words: str) -> int:
        return main(["learner", *words, "--stack", STACK])

    with Stack(ROBOT, name=STACK, can="zenoh", rows=rows) as stack:
        assert verb("calibrate") == 1
        assert "calibrate the robot's joints first" in capsys.readouterr().err
        do(stack, RobotRequest(action="calibrate"))
        do(stack, RobotRequest(action="move", joints=robot.chain, q_rad=home, duration_s=2.0))

        assert verb("calibrate", "r_arm_ft") == 0
        assert "r_arm_ft" in capsys.readouterr().out
        assert verb("calibrate", "nose") == 1
        assert "no sensor 'nose' here; there is r_arm_ft" in capsys.readouterr().err
        assert verb("status") == 0
        assert "no torques" not in capsys.readouterr().out

        out = str(tmp_path / "gain.toml")
        assert verb("identify", "r_arm_ft", "--moves", "5", "--degrees", "30", "--out", out) == 0
        assert_shown(capsys, "of 6 directions", Path(out).read_text(encoding="utf-8"))

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

        assert verb("assume", "custom", "r_hand", "r_forearm") == 0
        assert verb("status") == 0
        assert "a touch on it cannot be told" in capsys.readouterr().out
        assert verb("assume", "default") == 0
        assert verb("source", "moon") == 1
        assert "there are: base" in capsys.readouterr().err

        assert verb("reset") == 0
        assert verb("status") == 1
        assert "uncalibrated" in capsys.readouterr().out
