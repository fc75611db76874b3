import pytest

from hal.wire.can import Frame
from services.cli.can_danger import danger
from services.cli.can_names import BusNames
from services.cli.can_send import expects_answer, is_answer, named_frame, raw_frame, send
from services.core.errors import ConfigError
from tests.services.cli.can_bench import ROBOT, MakeWires, frame_of_text

ARM = BusNames(ROBOT, "right_arm")


def made(name: str, *values: str, to: str = "", joint: str = "", axis: int = 0) -> str:
    can_id, data = named_frame(name, values, ARM, to=to, joint=joint, axis=axis)
    return f"{can_id:03X}#{data.hex().upper()}"


# The frames are those of can-protocol 12.
def test_frame_is_made_from_name_and_values() -> None:
    assert made("POSITION_MOVE", "2104", "11", to="r_shoulder") == "001#1B380800000B00"
    assert made("position_move", "speed=11", "target=2104", to="1") == "001#1B380800000B00"
    assert made("SET_CONTROL_MODE", "POSITION", joint="r_elbow") == "002#8901"
    assert made("SET_CONTROL_MODE", "mode=0x09", to="r_shoulder") == "001#0909"
    assert made("GET_FULL_SCALES", "0", to="r_arm_strain") == "20D#1800"
    assert made("SET_COMMAND_POSITION", "1376", to="r_elbow", axis=1) == "002#BE60050000"
    assert made("DISCOVER", to="everybody") == "70F#FF"
    assert made("7:GET_ADDITIONAL_INFO", to="3") == "703#0C"
    assert made("GET_P_GAIN", joint="r_wrist_yaw") == "004#1F"


def test_broadcast_is_sent_in_the_name_of_a_board() -> None:
    assert made("POSITION", "2104", "3526", to="r_shoulder") == "111#38080000C60D0000"
    assert made("FORCE", "0x8000", "32570", "33601", to="13") == "3DA#00803A7F4183"
    assert made("FORCE", "0x8000", "32570", "33601", "5", to="13") == "3DA#00803A7F418305"


def test_of_two_lengths_the_values_choose() -> None:
    assert made("ADDRESS", "16", "512", "PROGRAM", to="13") == "70D#0110000200"
    assert made("ADDRESS", "16", "512", "PROGRAM", "0", to="13") == "70D#01100002000000"
    assert made("DATA", "1", "2", to="13") == "70D#030102"


@pytest.mark.parametrize(
    ("arguments", "named"),
    [
        (("NO_SUCH",), "no message 'NO_SUCH'"),
        (("GET_ADDITIONAL_INFO",), "write one of 0:GET_ADDITIONAL_INFO, 7:GET_ADDITIONAL_INFO"),
        (("POSITION_MOVE", "1"), "POSITION_MOVE carries target, speed; got 1 values"),
        (("POSITION_MOVE", "1", "2", "3"), "POSITION_MOVE carries target, speed; got 3 values"),
        (("POSITION_MOVE", "target=1", "pace=2"), "carries target, speed; got target, pace"),
        (("POSITION_MOVE", "1", "40000"), "speed = 40000 does not fit i16"),
        (("SET_CONTROL_MODE", "FLY"), "mode=FLY is no number: IDLE, POSITION, VELOCITY"),
        (("4:TRIANGLE_HEAD", *"1234567"), "send skin frames as identifier#bytes"),
    ],
)
def test_what_cannot_be_sent_is_explained(arguments: tuple[str, ...], named: str) -> None:
    with pytest.raises(ConfigError, match=named):
        made(*arguments, to="1")


def test_an_unknown_receiver_is_refused() -> None:
    with pytest.raises(ConfigError, match="'right_arm' has no board 'r_knee'"):
        made("GET_P_GAIN", to="r_knee")
    with pytest.raises(ConfigError, match="'right_arm' has no joint 'r_knee'"):
        made("GET_P_GAIN", joint="r_knee")
    with pytest.raises(ConfigError, match="say which board with --to or --joint"):
        made("GET_P_GAIN")


def test_raw_frame() -> None:
    assert raw_frame("001#1B380800000B00") == (1, bytes.fromhex("1B380800000B00"))
    assert raw_frame("2D0#") == (0x2D0, b"")
    assert raw_frame("70f#01.10.00") == (0x70F, b"\x01\x10\x00")


@pytest.mark.parametrize("text", ["800#00", "001#123", "x#00", "001#000102030405060708"])
def test_raw_text_that_is_no_frame_is_refused(text: str) -> None:
    with pytest.raises(ConfigError, match="is no frame"):
        raw_frame(text)


@pytest.mark.parametrize(
    "frame",
    [
        "70F#FF",
        "703#FF",
        "70D#0000",
        "70F#0110000200",
        "70F#03CFBB",
        "70F#0200000000",
        "70D#3205",
        "001#3202",
        "001#0A",
        "20D#09",
        "20D#3203",
        "001#0901",
        "002#8950",
        "001#1B380800000B00",
        "006#1C1D000100",
        "002#BE60050000",
        "001#2C00100000",
        "001#725000",
        "001#040355090A00090C",
        "3CA#FFBF01600080",
        "3BB#FFBF01600080",
    ],
)
def test_dangerous_frame_has_a_reason(frame: str) -> None:
    assert danger(*frame_of_text(frame)) != ""


@pytest.mark.parametrize(
    "frame",
    [
        "001#0900",
        "001#0909",
        "001#5B0106",
        "001#14",
        "20D#1800",
        "703#0C",
        "703#04",
        "730#FF0301",
        "111#38080000C60D0000",
        "3DA#00803A7F4183",
        "001#",
        "2D0#09",
        "20D#",
    ],
)
def test_harmless_frame_has_none(frame: str) -> None:
    assert danger(*frame_of_text(frame)) == ""


def test_answer_is_told_from_other_frames() -> None:
    question = frame_of_text("001#14")
    assert is_answer(question, *frame_of_text("010#143808000000000000"[:18]))
    assert not is_answer(question, *frame_of_text("020#14380800000000"))
    assert not is_answer(question, *frame_of_text("010#15"))
    assert not is_answer(question, *frame_of_text("111#1438080000000000"))
    assert not is_answer(question, *frame_of_text("001#14"))
    assert is_answer(frame_of_text("70F#FF"), *frame_of_text("7E0#FF06020306"))
    assert is_answer(frame_of_text("20D#0700"), *frame_of_text("2D0#"))


def test_gets_expect_an_answer_and_sets_do_not() -> None:
    assert expects_answer(frame_of_text("001#14"))
    assert expects_answer(frame_of_text("20D#1800"))
    assert not expects_answer(frame_of_text("001#0900"))
    assert not expects_answer(frame_of_text("111#0000000000000000"))


def test_send_shows_the_frame_and_its_answers(make_wires: MakeWires) -> None:
    wires = make_wires("right_arm")
    lines: list[str] = []
    wires.sends("right_arm", "010#14380800000C00", "111#38080000C60D0000")
    question: Frame = frame_of_text("001#14")

    answers = send(wires.taps[0], question, wires.clock, 0.05, lines.append)

    assert answers == 1
    assert [frame[:2] for frame in wires.boards["right_arm"].receive_frames()] == [question]
    assert lines[0].endswith("to r_shoulder    GET_ENCODER_POSITION r_shoulder_pitch")
    assert "GET_ENCODER_POSITION r_shoulder_pitch position=2104 tick (7.97 deg)" in lines[1]
    assert len(lines) == 2
