"""The command itself: its list of verbs, and what it sees to before any of them runs."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

from services.cli.main import ONE_THREAD, app, main

ROOT = Path(__file__).resolve().parents[3]
LOOK = """
import os, sys
from services.cli.main import main
assert "numpy" not in sys.modules
main(["--version"])
print(*(os.environ[name] for name in sys.argv[1:]))
"""


@pytest.mark.parametrize(
    ("given", "found"),
    [({}, ["1", "1", "1"]), ({"OMP_NUM_THREADS": "2"}, ["2", "1", "1"])],
    ids=["nothing said", "two threads asked for"],
)
def test_linear_algebra_has_one_thread_unless_the_user_says_otherwise(
    given: dict[str, str], found: list[str]
) -> None:
    others = {name: value for name, value in os.environ.items() if name not in ONE_THREAD}
    looked = subprocess.run(
        [sys.executable, "-c", LOOK, *ONE_THREAD],
        env={**others, **given, "PYTHONPATH": str(ROOT)},
        capture_output=True,
        text=True,
        check=True,
    )
    assert looked.stdout.split()[-3:] == found


def test_the_list_of_verbs_says_what_up_does(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["--help"]) == 0
    (line,) = [line for line in capsys.readouterr().out.splitlines() if "│ up " in line]
    assert "Start the stack" in line


@pytest.mark.parametrize(
    "group", ["can", "ik", "cartesian", "joints", "experiment", "field", "field objects"]
)
def test_the_list_of_a_group_describes_every_verb(
    group: str, capsys: pytest.CaptureFixture[str]
) -> None:
    words = group.split()
    assert main(words) == 0
    lines = [line.strip("│ ").split() for line in capsys.readouterr().out.splitlines()]
    shown = app
    for word in words:
        shown = shown[word]
    verbs = set(shown) - {"--help", "-h", "--version"}
    described = [line for line in lines if line and line[0] in verbs]
    assert {line[0] for line in described} == verbs
    assert all(len(line) > 3 for line in described)
