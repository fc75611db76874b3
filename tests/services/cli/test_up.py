import pytest

from services.cli import up
from services.cli.can_up import commands_for
from services.cli.main import app
from services.processes import HUB, PROCESSES, STAGES, stage_of


def test_the_table_names_every_process_once_and_the_hub_first() -> None:
    names = [row.name for row in PROCESSES]
    assert len(set(names)) == len(names)
    assert PROCESSES[0] is HUB


def test_an_unknown_robot_is_one_sentence_and_a_status(capsys: pytest.CaptureFixture[str]) -> None:
    assert up.up("marvin") == 2
    output = capsys.readouterr()
    assert "ulna: no robot file" in output.err
    assert "known robots: icub" in output.err


@pytest.mark.parametrize("spelling", ["--stack", "--name"])
def test_a_stack_is_named_as_the_other_verbs_name_it_or_as_it_was_before(spelling: str) -> None:
    command, bound, _ = app.parse_args(["up", spelling, "toys"])
    assert command is up.up
    assert bound.arguments == {"stack": "toys"}


def test_an_interface_that_is_missing_is_made_before_it_is_brought_up() -> None:
    assert commands_for("vcan77") == [
        ["ip", "link", "add", "dev", "vcan77", "type", "vcan"],
        ["ip", "link", "set", "vcan77", "up"],
    ]
    assert commands_for("lo") == [["ip", "link", "set", "lo", "up"]]


def test_boards_start_before_the_host_and_both_after_what_takes_long_to_load() -> None:
    stages = {row.name: stage_of(row) for row in PROCESSES if row is not HUB}
    assert stages["ik"] == stages["dynamics"] == 0
    assert stages["boards"] == 1
    assert stages["robot"] == stages["guard"] == STAGES - 1
