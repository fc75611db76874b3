"""ulna experiment: what it lists and what it refuses, before anything takes time."""

from pathlib import Path

import pytest

from services.cli.experiment import VERBS
from services.cli.main import main

NAMES = (
    "force-table1",
    "force-fig5",
    "force-fig6",
    "force-fig7",
    "closed-loop",
    "cartesian",
    "ik",
    "dforc-fig4",
    "dforc-fig5",
    "dforc-scenes",
    "dforc-fig6",
)


def test_help_lists_every_experiment(capsys: pytest.CaptureFixture[str]) -> None:
    main(["experiment", "--help"])
    listed = capsys.readouterr().out
    assert all(name in listed for name in NAMES)
    assert len(VERBS) == len(NAMES)


@pytest.mark.parametrize("name", NAMES)
def test_help_of_each_ends_with_its_options_and_shows_an_example(
    name: str, capsys: pytest.CaptureFixture[str]
) -> None:
    main(["experiment", name, "--help"])
    text = capsys.readouterr().out
    assert f"Example: ulna experiment {name}" in text
    assert "--short" in text
    assert "--json" in text


@pytest.mark.parametrize(
    ("arguments", "expected"),
    [
        (["force-table1", "--data", "nowhere.tgz"], "there is no file nowhere.tgz; --data FILE"),
        (["force-table1", "--runs", "0"], "--runs: 0 is outside 1..100"),
        (["force-table1", "--robot", "icub:head"], "no force/torque sensor among its parts"),
        (["force-table1", "--json", "/nowhere/a.json"], "there is no folder /nowhere"),
        (["force-table1", "--json", "/"], "cannot write /: Is a directory"),
        (["force-fig5", "--plot", "/proc/a.png"], "cannot write /proc/a.png: "),
        (["force-fig5", "--limb", "tail"], "--limb tail: no force/torque sensor"),
        (["force-fig5", "--plot", "/nowhere/a.png"], "there is no folder /nowhere"),
        (["closed-loop", "--robot", "coman"], "known robots: icub"),
        (["cartesian", "--plant", "gantry"], "--plant gantry: there are: ideal, lagged, boards"),
        (["cartesian", "--controller", "pid"], "there are: ulna, reference, vite, vite-loop, dls"),
        (["cartesian", "--robot", "icub:head"], "right_arm"),
        (["ik", "--robot", "coman"], "known robots: icub"),
        (["ik", "--robot", "icub:head"], "unknown limb 'right_arm'"),
        (["dforc-scenes", "--level", "toe"], "unknown level 'toe'; there are point, arm, all"),
        (["dforc-scenes", "--scenes", "0"], "--scenes: 0 is outside 1..1000"),
        (["ik", "--plot", "/nowhere/a.png"], "there is no folder /nowhere"),
        (["force-fig6", "--runs", "101"], "--runs: 101 is outside 1..100"),
        (["force-fig7", "--data", "nowhere.tgz"], "there is no file nowhere.tgz; --data FILE"),
    ],
)
def test_refuses_in_one_sentence(
    arguments: list[str], expected: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["experiment", *arguments]) == 2
    said = capsys.readouterr()
    assert said.out == ""
    assert expected in said.err
    assert said.err.count("\n") == 1


def test_refuses_a_file_that_is_not_the_recording(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    other = tmp_path / "other.tgz"
    other.write_bytes(b"something else")
    assert main(["experiment", "force-table1", "--data", str(other)]) == 2
    assert "is not the recording icubdyn.tgz" in capsys.readouterr().err


def test_refuses_unknown_options(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit) as ended:
        main(["experiment", "force-fig5", "--fast"])
    assert ended.value.code != 0
    assert "--fast" in capsys.readouterr().err
