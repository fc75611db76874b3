"""Which board is plugged in: the robot file's, or one made by hand."""

import pytest

from services.config import load_robot
from services.core.errors import ConfigError
from services.emulated.emulation import rig_spec
from services.emulated.plug import Place, Plugged, plugged


def at(bus: str, address: int, kind: str = "", firmware: str = "") -> Plugged:
    place = Place(bus=bus, address=address, type=kind, firmware=firmware)
    return plugged(load_robot("icub"), place)


@pytest.mark.parametrize("bus", ["right_arm", "2", "vcan2"])
def test_a_bus_goes_by_name_number_or_interface(bus: str) -> None:
    found = at(bus, 1)
    assert found.name == "r_shoulder"
    assert found.bus.number == 2
    assert found.joints == {0: "r_shoulder_pitch", 1: "r_shoulder_roll"}
    assert (found.board.type, found.board.firmware) == ("bll_ie", "2.50")


def test_bll_names_the_family_of_which_the_robot_file_knows_the_member() -> None:
    assert at("vcan2", 1, "bll").board.type == "bll_ie"
    assert at("vcan0", 1, "bll").board.type == "bll_dc"


def test_nothing_but_the_board_with_its_axes_and_sensor_is_left_of_the_robot() -> None:
    spec = rig_spec(at("left_hand", 5).robot, seed=0)
    assert [(board.bus, board.address, board.type) for board in spec.boards] == [(5, 5, "dc4")]
    assert [(axis.address, axis.axis) for axis in spec.axes] == [(5, 0), (5, 1), (6, 0), (6, 1)]
    assert spec.sensors == ()
    strain = rig_spec(at("right_arm", 13).robot, seed=0)
    assert [(sensor.bus, sensor.address) for sensor in strain.sensors] == [(2, 13)]


def test_a_board_that_is_real_at_the_site_is_emulated_when_it_is_plugged_in() -> None:
    found = plugged(load_robot("icub@real"), Place(bus="can2", address=1))
    assert found.robot.is_simulated("r_shoulder")
    assert rig_spec(found.robot, seed=0).axes[0].driven is False


@pytest.mark.parametrize(
    ("place", "sentence"),
    [
        (("vcan2", 3, "bll"), "r_forearm at bus right_arm address 3 is a dc4"),
        (
            ("vcan2", 4),
            "address 4 is the second one of r_forearm on bus right_arm; say",
        ),
        (("vcan2", 9), "has no board at bus right_arm address 9; boards there: 1 r_shoulder"),
        (("vcan2", 9, "bll"), "give --type and --firmware"),
        (("vcan77", 1), "no bus 'vcan77'; buses: head_torso (vcan0)"),
        (("vcan2", 1, "ems4"), "unknown board type 'ems4'; known: bll, bll_ie"),
        (("vcan2", 1, "", "two"), "firmware 'two' is not of the form major.minor"),
        (("vcan2", 15, "bll", "2.50"), "address 15 is outside 1..14"),
    ],
)
def test_what_does_not_fit_the_robot_file_is_refused_with_what_would(
    place: tuple[str, int], sentence: str
) -> None:
    with pytest.raises(ConfigError) as refused:
        at(*place)
    assert sentence in str(refused.value)


def test_a_firmware_by_hand_replaces_the_robot_files() -> None:
    found = at("vcan2", 1, firmware="1.50")
    assert found.name == "r_shoulder"
    assert found.board.firmware == "1.50"


def test_a_board_by_hand_turns_free_bars() -> None:
    found = at("vcan2", 9, "dc4", "2.28")
    axes = rig_spec(found.robot, seed=0).axes
    assert [(axis.address, axis.axis) for axis in axes] == [(9, 0), (9, 1), (10, 0), (10, 1)]
    assert {axis.mechanism for axis in axes} == {"single"}
    assert {axis.hard_stop_deg for axis in axes} == {(-170.0, 170.0)}


def test_another_type_by_hand_takes_the_place_of_the_robot_files() -> None:
    found = at("vcan2", 3, "strain", "3.0")
    assert (found.name, found.board.type) == ("bench", "strain")
    assert len(rig_spec(found.robot, seed=0).sensors) == 1


def test_the_text_says_what_it_is_and_what_it_moves() -> None:
    assert at("vcan2", 1).text == (
        "r_shoulder: bll_ie, firmware 2.50, bus 2, address 1, moves r_shoulder_pitch, "
        "r_shoulder_roll"
    )
    assert at("right_hand", 14).text == "r_mais: mais, firmware 3.1, bus 6, address 14"
