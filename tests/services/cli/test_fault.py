"""`ulna board fault` and `ulna board faults`."""

from pathlib import Path

import pytest

from firmware_sim.switch_table import SWITCHES
from services.cli.main import main
from services.core.rundir import Claim


def test_lists_every_fault(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["board", "faults"]) == 0
    listed = capsys.readouterr().out
    assert [name for name in SWITCHES if f" {name} " not in listed] == []


def test_says_that_no_stack_is_up(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.setenv("XDG_RUNTIME_DIR", str(tmp_path))
    assert main(["board", "fault", "estop", "--stack", "nobody"]) == 2
    assert "no stack named 'nobody' is up here" in capsys.readouterr().err


def test_refuses_an_identifier_that_is_no_number(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["board", "fault", "drop", "--bus", "2", "--identifier", "0xZZ"]) == 2
    assert "'0xZZ' is no hexadecimal identifier" in capsys.readouterr().err


def test_an_unknown_bus_is_told_with_those_of_the_running_stack(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.setenv("XDG_RUNTIME_DIR", str(tmp_path))
    claim = Claim("bench", "icub", "icub:right_arm")
    claim.publish("tcp/127.0.0.1:1", "zenoh")
    fault = ["board", "fault", "bus_off", "--stack", "bench", "--bus"]
    assert main([*fault, "tail"]) == 2
    assert "icub has no bus 'tail'; known: right_arm (2)" in capsys.readouterr().err
    claim.release()
