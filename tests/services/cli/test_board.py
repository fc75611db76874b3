"""`ulna board list` and what `ulna board run` refuses."""

import can
import pytest

from hal.buses.python_can import PythonCanBus
from hal.wire import motor
from services.cli.board import board_table
from services.cli.main import main
from services.config import load_robot
from services.core.clock import RealClock
from services.core.errors import ServiceError
from services.emulated.board_process import PluggedBoard, found_out, senders
from services.emulated.plug import Place, plugged


def test_every_board_is_listed_under_its_bus() -> None:
    robot = load_robot("icub@bench")
    columns = [list(column.cells) for column in board_table(robot).columns]
    rows = list(zip(*columns, strict=True))
    assert len(rows) == len(robot.boards) + len(robot.buses)
    start = rows.index(("2 right_arm vcan2", "", "", "", "", ""))
    moves = "r_shoulder_pitch, r_shoulder_roll"
    assert rows[start + 1] == ("  r_shoulder", "1", "bll_ie", "2.50", "real", moves)
    assert rows[start + 3][:5] == ("  r_forearm", "3, 4", "dc4", "2.19", "simulated")


@pytest.mark.parametrize(
    ("arguments", "sentence"),
    [
        (["list", "--robot", "marvin"], "known robots: icub"),
        (
            ["run", "--bus", "vcan2", "--address", "3", "--type", "bll"],
            "r_forearm at bus right_arm",
        ),
        (["run", "--bus", "vcan2", "--address", "9"], "has no board at bus right_arm address 9"),
    ],
)
def test_what_cannot_be_done_is_one_sentence_and_status_2(
    arguments: list[str], sentence: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["board", *arguments]) == 2
    assert sentence in capsys.readouterr().err.replace("\n", " ")


def test_a_transport_is_found_or_it_says_what_is_missing() -> None:
    with pytest.raises(ServiceError, match=r"nocan0 is not up on this machine .* 'nobody' is up"):
        found_out("nobody", "nocan0")


def test_an_address_is_taken_by_whoever_sends_with_it() -> None:
    position_of_1, host_to_2, discovered_3 = (0x111, b""), (0x002, b""), (0x730, b"")
    frames = [(*frame, 0) for frame in (position_of_1, host_to_2, discovered_3)]
    assert senders(frames) == {0, 1}


def test_a_board_on_a_python_can_bus_answers_the_handshake() -> None:
    chosen = plugged(load_robot("icub"), Place(bus="right_arm", address=1))
    bus = PythonCanBus("virtual", "plugged", RealClock())
    board = PluggedBoard(chosen, bus)
    with can.Bus(interface="virtual", channel="plugged") as host:
        can_id, data = motor.GET_FIRMWARE_VERSION.request(1, 0, *motor.HOST_PROTOCOL)
        host.send(can.Message(arbitration_id=can_id, data=data, is_extended_id=False))
        said = board.step() + board.step()
        answer = host.recv(1.0)
    bus.shutdown()
    assert said == ["handshake accepted, protocol 1.6"]
    assert answer is not None
    assert answer.arbitration_id == 0x010
    assert bytes(answer.data)[:4] == bytes((91, 4, 2, 0x50))
    assert board.status().startswith(
        "silent, r_shoulder_pitch idle, r_shoulder_roll idle; 1 frames"
    )
