import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from services.cli.can_dump import Dump, dump
from services.cli.can_names import BusNames, Selection, check_selection
from services.core.errors import ConfigError
from tests.services.cli.can_bench import ROBOT, MakeWires, frame_of_text

NAMES = {bus: BusNames(ROBOT, bus) for bus in ROBOT.buses}
ARM = NAMES["right_arm"]


def text_of(frame: str, names: BusNames = ARM) -> str:
    named = names.name(*frame_of_text(frame))
    return f"{named.board}: {names.text(named)}"


# Right arm of the robot file: shoulder pitch 11.375 ticks/deg, zero 177; TorqueMax 8 Nm.
@pytest.mark.parametrize(
    ("frame", "text"),
    [
        (  # 2104 / 11.375 - 177, 3526 / 11.375 - 37
            "111#38080000C60D0000",
            "r_shoulder: POSITION position0=2104 tick (r_shoulder_pitch 7.97 deg), "
            "position1=3526 tick (r_shoulder_roll 272.98 deg)",
        ),
        (  # 110 tick/s / 11.375
            "001#1B380800000B00",
            "to r_shoulder: POSITION_MOVE r_shoulder_pitch target=2104 tick (7.97 deg), "
            "speed=11 x 10 tick/s (9.67 deg/s)",
        ),
        (  # 29 / 2^8 * 1000 / 11.375, 1 / 2^8 * 10^6 / 11.375
            "001#1C1D000100",
            "to r_shoulder: VELOCITY_MOVE r_shoulder_pitch "
            "velocity=29 tick/ms / 2^velocity_shift (9.959 deg/s), "
            "acceleration=1 tick/ms^2 / 2^velocity_shift (343.4 deg/s^2)",
        ),
        (  # example 20 of can-protocol 12
            "001#579000332A000000",
            "to r_shoulder: SET_IMPEDANCE_PARAMS r_shoulder_pitch "
            "stiffness=144 TorqueMax/0x8000/tick (0.3999 Nm/deg), "
            "damping=10803 TorqueMax/0x8000*ms/tick (0.03 Nm s/deg)",
        ),
        (
            "001#2C00100000",
            "to r_shoulder: SET_DESIRED_TORQUE r_shoulder_pitch "
            "torque=4096 TorqueMax/0x8000 (1 Nm)",
        ),
        (  # example 23
            "3CA#FFBF01600080",
            "virtual right_arm: FORCE fx=49151 (r_shoulder_pitch 4 Nm), "
            "fy=24577 (r_shoulder_roll -2 Nm), fz=32768 (r_shoulder_yaw 0 Nm)",
        ),
        (
            "114#5E0188FF00000000",
            "r_shoulder: CURRENT current0=350 mA (r_shoulder_pitch 0.35 A), "
            "current1=-120 mA (r_shoulder_roll -0.12 A)",
        ),
        ("002#8901", "to r_elbow: SET_CONTROL_MODE r_elbow mode=POSITION"),
        (
            "001#4C",
            "to r_shoulder: GET_OFFSET_ABS_ENCODER r_shoulder_pitch",
        ),
        ("001#4B10000000", "to r_shoulder: SET_OFFSET_ABS_ENCODER r_shoulder_pitch offset=16 tick"),
        ("001#1B38", "to r_shoulder: POSITION_MOVE of wrong length: 1b 38"),
        ("7FF#AABB", "everybody: unknown: aa bb"),
        ("70F#FF", "to everybody: DISCOVER"),
    ],
)
def test_frame_is_shown_with_names_and_physical_values(frame: str, text: str) -> None:
    assert text_of(frame) == text


def test_speed_of_a_4dc_is_read_without_the_shift() -> None:
    # 16 ticks/ms: wrist pitch of the 4DC 16000 / 11.375 deg/s; of a BLL board 16000 / 32 / 11.375.
    assert "velocity1=16 tick/ms / 2^shift (r_wrist_pitch 1407 deg/s)" in text_of(
        "137#0000100000000000"
    )
    assert "velocity0=16 tick/ms / 2^shift (r_shoulder_pitch 43.96 deg/s)" in text_of(
        "117#1000000000000000"
    )


def test_second_address_of_a_4dc_has_its_name_and_its_joints() -> None:
    assert text_of("141#0000000000000000").startswith(
        "r_forearm: POSITION position0=0 tick (r_wrist_yaw 180.00 deg)"
    )


def test_force_is_shown_in_newton_by_the_full_scales_of_the_sensor() -> None:
    sensor = next(s for s in ROBOT.sensors.values() if s.board == "r_arm_strain")
    assert sensor.full_scale[:3] == (1521.0, 1658.0, 1966.0)
    assert text_of("3DA#00803A7F4183") == (  # example 26
        "r_arm_strain: FORCE fx=32768 (0 N), fy=32570 (-10 N), fz=33601 (50 N)"
    )


def test_imu_values_have_the_unit_of_their_sensor() -> None:
    head = BusNames(ROBOT, "head_torso")
    assert text_of("5E3#0500E8030000F6FF", head) == (
        "head_imu: IMU_TRIPLE sequence=5, sensor=ACCELEROMETER, x=1000 (10 m/s^2), "
        "y=0 (0 m/s^2), z=-10 (-0.1 m/s^2)"
    )
    assert "x=32 (2 deg/s)" in text_of("5E3#0502200000000000", head)


def test_a_bus_that_is_none_of_the_robots_shows_numbers() -> None:
    assert text_of("111#38080000C60D0000", BusNames(ROBOT, "can7")) == (
        "board 1: POSITION position0=2104 tick, position1=3526 tick"
    )


@pytest.mark.parametrize(
    ("selection", "messages"),
    [
        (Selection(), ["POSITION", "STATUS", "FORCE", "unknown", "POSITION_MOVE"]),
        (Selection(boards=("r_shoulder",)), ["POSITION", "POSITION_MOVE"]),
        (Selection(boards=("r_*",), messages=("pos*",)), ["POSITION", "POSITION_MOVE"]),
        (Selection(joints=("r_elbow",)), ["STATUS"]),
        (Selection(joints=("r_shoulder_roll",)), ["POSITION", "FORCE"]),
        (Selection(bad_only=True), ["unknown"]),
        (Selection(messages=("FORCE", "STATUS")), ["STATUS", "FORCE"]),
    ],
)
def test_selection(selection: Selection, messages: list[str]) -> None:
    frames = [
        "111#38080000C60D0000",
        "123#0000000100000000",
        "3CA#FFBF01600080",
        "13E#00",
        "001#1B380800000B00",
    ]
    named = [ARM.name(*frame_of_text(frame)) for frame in frames]
    assert [frame.message for frame in named if selection.takes(frame)] == messages


def test_an_unknown_joint_is_refused_with_those_that_there_are() -> None:
    with pytest.raises(ConfigError, match=r"no joint 'elbow'; known: .*r_elbow"):
        check_selection(Selection(joints=("elbow",)), ROBOT)


def test_dump_shows_time_bus_bytes_and_counts_what_it_cannot_read(make_wires: MakeWires) -> None:
    wires = make_wires("right_arm", "head_torso")
    lines: list[str] = []
    show = Dump(Selection(), lines.append)
    wires.sends("right_arm", "123#0000000100000000", "11E#00")
    wires.clock.advance_ns(4_000_000)
    wires.sends("head_torso", "151#0000", "205#")

    dump(wires.taps, wires.clock, show, until_ns=wires.after(10))

    assert [line[:68].strip() for line in lines] == [
        "0.000000 right_arm       123 00 00 00 01 00 00 00 00 r_elbow",
        "0.000000 right_arm       11E 00                      r_shoulder",
        "0.004000 head_torso      151 00 00                   torso_yaw",
        "0.004000 head_torso      205                         to torso_yaw",
    ]
    assert lines[2].endswith("POSITION of wrong length: 00 00")
    assert (show.shown, dict(show.causes)) == (4, {"unknown": 2, "length": 1})


def test_dump_ends_after_so_many_lines(make_wires: MakeWires) -> None:
    wires = make_wires("right_arm")
    lines: list[str] = []
    wires.sends("right_arm", *["123#0000000100000000"] * 5)
    dump(wires.taps, wires.clock, Dump(Selection(), lines.append), count=3)
    assert len(lines) == 3


@settings(max_examples=400, deadline=None)
@given(st.integers(0, 0x7FF), st.binary(max_size=8), st.sampled_from(sorted(ROBOT.buses)))
def test_no_frame_is_too_odd_to_be_shown(can_id: int, data: bytes, bus: str) -> None:
    named = NAMES[bus].name(can_id, data)
    assert NAMES[bus].text(named)
    assert named.board
    assert named.decoded.cause in ("", "unknown", "length")
    assert (named.decoded.form is None) == (named.decoded.cause == "unknown")
    assert not (named.decoded.cause and named.decoded.values)
