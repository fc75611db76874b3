import pytest

from services.cli import up
from services.cli.can_up import commands_for
from services.cli.main import app
from services.config import load_robot
from services.core.errors import ConfigError
from services.processes import HUB, PROCESSES, STAGES, stage_of

VIRTUAL = ("vcan0", "vcan2")


def test_what_the_user_asks_for_is_taken(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(up, "interfaces_up", lambda _names: True)
    assert up.choose_can("zenoh", VIRTUAL) == ("zenoh", "as asked for")
    assert up.choose_can("socketcan", VIRTUAL) == ("socketcan", "as asked for")


def test_socketcan_without_its_interfaces_is_refused_before_anything_starts(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(up, "interfaces_up", lambda _names: False)
    with pytest.raises(ConfigError, match="not all of vcan0, vcan2 are up"):
        up.choose_can("socketcan", VIRTUAL)


@pytest.mark.parametrize(("all_up", "chosen"), [(True, "socketcan"), (False, "zenoh")])
def test_socketcan_is_the_default_where_the_interfaces_are_up(
    monkeypatch: pytest.MonkeyPatch, all_up: bool, chosen: str
) -> None:
    monkeypatch.setattr(up, "interfaces_up", lambda _names: all_up)
    can, reason = up.choose_can(None, VIRTUAL)
    assert can == chosen
    assert "vcan0, vcan2" in reason


def test_real_boards_on_an_interface_that_is_up_make_the_transport_mixed(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(up, "interfaces_up", lambda names: tuple(names) == ("can2",))
    real = up.real_interfaces(load_robot("icub@real"))
    assert real == tuple(f"can{number}" for number in range(10))
    can, reason = up.choose_can(None, ("vcan0", "can2"), ("can2",))
    assert can == "mixed"
    assert reason == "real boards are on can2; the others over zenoh"
    assert up.choose_can(None, ("vcan0", "can3"), ("can3",))[0] == "zenoh"


def test_emulated_boards_run_where_the_site_has_some() -> None:
    assert up.rows_for(load_robot("icub:reach")) == PROCESSES
    names = [row.name for row in up.rows_for(load_robot("icub:reach@real"))]
    assert "boards" not in names
    assert "robot" in names


def test_controllers_of_reaching_run_only_where_a_limb_is() -> None:
    assert up.rows_for(load_robot("icub:reach_left")) == PROCESSES
    names = [row.name for row in up.rows_for(load_robot("icub:lower_body"))]
    assert names == ["hub", "boards", "robot", "guard", "dynamics", "learner"]


def test_dynamics_runs_only_where_a_force_torque_sensor_is() -> None:
    names = [row.name for row in up.rows_for(load_robot("icub:head"))]
    assert names == ["hub", "boards", "robot", "guard"]


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
