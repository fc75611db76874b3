import pytest

from services import stack_choice
from services.config import load_robot
from services.core.errors import ConfigError
from services.processes import PROCESSES
from services.stack_choice import choose_can, real_interfaces, rows_for

VIRTUAL = ("vcan0", "vcan2")


def test_what_the_user_asks_for_is_taken(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(stack_choice, "interfaces_up", lambda _names: True)
    assert choose_can("zenoh", VIRTUAL) == ("zenoh", "as asked for")
    assert choose_can("socketcan", VIRTUAL) == ("socketcan", "as asked for")


def test_socketcan_without_its_interfaces_is_refused_before_anything_starts(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(stack_choice, "interfaces_up", lambda _names: False)
    with pytest.raises(ConfigError, match="not all of vcan0, vcan2 are up"):
        choose_can("socketcan", VIRTUAL)


@pytest.mark.parametrize(("all_up", "chosen"), [(True, "socketcan"), (False, "zenoh")])
def test_socketcan_is_the_default_where_the_interfaces_are_up(
    monkeypatch: pytest.MonkeyPatch, all_up: bool, chosen: str
) -> None:
    monkeypatch.setattr(stack_choice, "interfaces_up", lambda _names: all_up)
    can, reason = choose_can(None, VIRTUAL)
    assert can == chosen
    assert "vcan0, vcan2" in reason


def test_real_boards_on_an_interface_that_is_up_make_the_transport_mixed(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(stack_choice, "interfaces_up", lambda names: tuple(names) == ("can2",))
    real = real_interfaces(load_robot("icub@real"))
    assert real == tuple(f"can{number}" for number in range(10))
    can, reason = choose_can(None, ("vcan0", "can2"), ("can2",))
    assert can == "mixed"
    assert reason == "real boards are on can2; the others over zenoh"
    assert choose_can(None, ("vcan0", "can3"), ("can3",))[0] == "zenoh"


def test_emulated_boards_run_where_the_site_has_some() -> None:
    assert rows_for(load_robot("icub:reach")) == PROCESSES
    names = [row.name for row in rows_for(load_robot("icub:reach@real"))]
    assert "boards" not in names
    assert "robot" in names


def test_controllers_of_reaching_run_only_where_a_limb_is() -> None:
    assert rows_for(load_robot("icub:reach_left")) == PROCESSES
    names = [row.name for row in rows_for(load_robot("icub:lower_body"))]
    assert names == ["hub", "boards", "robot", "guard", "dynamics", "learner"]


def test_dynamics_runs_only_where_a_force_torque_sensor_is() -> None:
    names = [row.name for row in rows_for(load_robot("icub:head"))]
    assert names == ["hub", "boards", "robot", "guard"]
