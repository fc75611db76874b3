"""The Python client of the field and `ulna field` on a live stack: what a user does."""

import re
from pathlib import Path

import pytest

from services.cli.main import main
from services.fields.client import BlockingFieldControl, RequestRefusedError, WaitTimeoutError
from services.processes import HUB, PROCESSES
from services.reaching.client import BlockingCartesianControl
from services.stack import Stack

pytestmark = pytest.mark.live

ROOT = Path(__file__).resolve().parents[2]
STACK = "icub"
NEEDED = ("boards", "robot", "ik", "cartesian", "field")
PATIENCE_S = 90.0  # of a host that has little time for the stack


def snippet() -> str:
    text = (ROOT / "docs" / "fields.md").read_text(encoding="utf-8")
    (found,) = re.findall(r"```python\n(.*?)```", text, flags=re.DOTALL)
    return str(found)


def drive_blocking() -> None:
    with BlockingCartesianControl(limb="right_arm") as arm:
        here = arm.pose()
    x, y, z = here.position_m.tolist()
    with BlockingFieldControl() as field:
        gains = field.set("dforc", preset="paper", gains={"K": 9.0, "D": 6.0})
        assert (gains["K"], gains["G"]) == (9.0, 10.0)
        ball = field.add_object("ball", "sphere", (0.03,), (x - 0.03, y, z - 0.3))
        cube = field.add_object("cube", "box", (0.01, 0.01, 0.01), (x, y, z + 0.05), role="target")
        while len(field.info().sources[0].objects) < 2:
            field.next_status()
        found = field.preview((x, y, z + 0.04), here.rotation)
        assert found.arrives
        assert found.closest_to == "hand - ball"
        goal = field.go((x, y, z + 0.04), here.rotation)
        status = field.wait_for("arrived", goal=goal, timeout_s=PATIENCE_S)
        assert status.goal_distance_m < 0.005
        assert status.mode == "dforc"
        follow = field.follow("cube")
        cube.move((x, y, z + 0.02), velocity_m_s=(0.0, 0.0, 0.0))
        status = field.wait_for("arrived", goal=follow, timeout_s=PATIENCE_S)
        assert status.goal == goal + 1
        ball.remove()
        with pytest.raises(RequestRefusedError, match="no object 'ball'"):
            field.follow("ball")
        field.stop()
        assert field.wait_for("idle").state == "idle"
        with pytest.raises(WaitTimeoutError, match=r"after 0\.2 s the field is idle"):
            field.wait_for("arrived", timeout_s=0.2)
    with BlockingFieldControl() as field:  # the first client has taken its objects with it
        assert field.info().sources == ()


def test_the_field_is_used_from_python_and_from_the_command_line(
    capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    rows = (HUB, *(row for row in PROCESSES if row.name in NEEDED))

    def joints(word: str) -> int:
        return main(["joints", word, "--stack", STACK])

    def verb(*words: str) -> int:
        return main(["field", *words, "--stack", STACK])

    with Stack("icub:reach", name=STACK, can="zenoh", rows=rows):
        assert verb("goal", "-0.3", "0.2", "0.1", "--timeout", "2") == 1
        assert "ulna joints calibrate" in capsys.readouterr().err
        assert verb("stop") == 0
        assert joints("calibrate") == 0
        assert joints("home") == 0
        assert joints("direct") == 0
        exec(compile(snippet(), "docs/fields.md", "exec"), {"__name__": "fields_page"})
        printed = capsys.readouterr().out
        assert "preview: arrived after" in printed
        assert "arrived, " in printed
        assert "K of mode ulna is 0.1 to 100 N/m, not -1" in printed

        drive_blocking()

        assert verb("objects", "add", "ball", "sphere", "0.04", "--at", "-0.5", "0.5", "0.3") == 0
        assert verb("objects", "add", "ball", "sphere", "0.04", "--at", "0", "0", "0") == 1
        assert verb("objects", "move", "ball", "--to", "-0.5", "0.5", "0.35") == 0
        assert verb("objects", "list") == 0
        assert "-0.5 0.5 0.35" in capsys.readouterr().out
        assert verb("objects", "remove", "ball") == 0
        assert verb("mode", "ulna") == 0
        assert verb("set", "margin=9") == 1
        assert "margin of mode ulna is 0 to 0.2 m, not 9" in capsys.readouterr().err
        plot = tmp_path / "preview.png"
        there = ("-0.33", "0.2", "0.06")
        assert verb("preview", *there, "--mode", "ulna", "--mode", "dforc") == 0
        assert verb("preview", *there, "--mode", "all", "--plot", str(plot)) in (0, 1)  # pmp
        assert plot.exists()
        assert verb("goal", *there, "--timeout", str(PATIENCE_S)) == 0
        assert verb("status", "--once") == 0
        assert "arrived" in capsys.readouterr().out
        assert verb("info") == 0
        assert verb("stop") == 0
