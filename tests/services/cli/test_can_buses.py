"""The verbs on python-can's own virtual interface, as a user calls them."""

import threading
from collections.abc import Iterator
from pathlib import Path

import can
import pytest

from services.cli.can_buses import opened, robot_in_use
from services.cli.can_dbc import can_dbc, can_docs, every_node
from services.cli.can_dump import can_dump
from services.cli.can_log import can_log, can_replay
from services.cli.can_send import can_send
from services.cli.can_stats import can_stats
from services.core.clock import RealClock
from services.core.errors import ConfigError, NotRunningError, ServiceError
from services.core.rundir import Claim
from tests.services.cli.can_bench import ROBOT

PLACE = "right_arm=virtual:ulna-test"


def message(text: str) -> can.Message:
    head, _, tail = text.partition("#")
    data = bytes.fromhex(tail)
    return can.Message(arbitration_id=int(head, 16), data=data, is_extended_id=False)


@pytest.fixture
def far_end() -> Iterator[can.BusABC]:
    with can.Bus("ulna-test", interface="virtual") as bus:
        yield bus


class Talker:
    """Sends a frame again and again from a thread, as boards do."""

    def __init__(self, bus: can.BusABC, text: str) -> None:
        self._stop = threading.Event()
        self._thread = threading.Thread(target=self._run, args=(bus, message(text)))

    def _run(self, bus: can.BusABC, sent: can.Message) -> None:
        while not self._stop.wait(0.002):
            bus.send(sent)

    def __enter__(self) -> None:
        self._thread.start()

    def __exit__(self, *_: object) -> None:
        self._stop.set()
        self._thread.join()


def test_dump_of_a_python_can_bus(far_end: can.BusABC, capsys: pytest.CaptureFixture[str]) -> None:
    with Talker(far_end, "111#38080000C60D0000"):
        assert can_dump(bus=(PLACE,), count=2, seconds=20.0) == 0
    output = capsys.readouterr()
    assert len(output.out.splitlines()) == 2
    assert "r_shoulder       POSITION position0=2104 tick (r_shoulder_pitch" in output.out
    assert output.err == "2 shown, 0 lost, 0 unknown, 0 of wrong length\n"


def test_send_to_a_python_can_bus(far_end: can.BusABC, capsys: pytest.CaptureFixture[str]) -> None:
    assert can_send(PLACE, "SET_CONTROL_MODE", "IDLE", joint="r_elbow", wait=0.0) == 0
    received = far_end.recv(timeout=0)
    assert received is not None
    assert (received.arbitration_id, bytes(received.data)) == (0x002, b"\x89\x00")
    assert "to r_elbow" in capsys.readouterr().out


def test_dangerous_frame_needs_a_yes(far_end: can.BusABC) -> None:
    with pytest.raises(ConfigError, match="not sent: DISCOVER: a discovery switches off all axes"):
        can_send(PLACE, "DISCOVER", to="everybody")
    assert far_end.recv(timeout=0) is None
    assert can_send(PLACE, "70F#FF", wait=0.0, yes=True) == 1  # nobody answers
    sent = far_end.recv(timeout=0)
    assert sent is not None
    assert (sent.arbitration_id, bytes(sent.data)) == (0x70F, b"\xff")


def test_question_without_an_answer_is_told(
    far_end: can.BusABC, capsys: pytest.CaptureFixture[str]
) -> None:
    assert can_send(PLACE, "GET_BOARD_ID", to="r_elbow", wait=0.0) == 1
    assert capsys.readouterr().err == "no answer\n"
    assert far_end.recv(timeout=0) is not None


def test_log_and_replay_through_a_file(
    far_end: can.BusABC, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / "arm.log"
    with Talker(far_end, "123#0000000100000000"):
        assert can_log(path, bus=(PLACE,), seconds=0.1) == 0
    frames = len(path.read_text().splitlines())
    assert frames > 0
    assert capsys.readouterr().err == f"{frames} frames in {path}, 0 lost\n"

    assert can_replay(path, bus=("2=virtual:ulna-test",), speed=100.0) == 0

    replayed = [far_end.recv(timeout=0) for _ in range(frames)]
    assert {bytes(one.data) for one in replayed if one is not None} == {b"\0\0\0\1\0\0\0\0"}
    assert None not in replayed
    assert f"{frames} sent, 0 of other buses" in capsys.readouterr().err


def test_replay_of_a_moving_frame_is_refused(far_end: can.BusABC, tmp_path: Path) -> None:
    path = tmp_path / "move.log"
    path.write_text("(1.0) can2 001#1B380800000B00\n")
    with pytest.raises(ConfigError, match="moves a joint, past every limit of the HAL; --yes"):
        can_replay(path, bus=("2=virtual:ulna-test",))
    assert far_end.recv(timeout=0) is None
    with pytest.raises(ConfigError, match="--speed 0: must be above 0"):
        can_replay(path, speed=0.0)


def test_stats_of_a_python_can_bus(far_end: can.BusABC, capsys: pytest.CaptureFixture[str]) -> None:
    with Talker(far_end, "111#38080000C60D0000"):
        assert can_stats(bus=(PLACE,), seconds=0.1, by="message") == 0
    assert "right_arm" in (output := capsys.readouterr().out)
    assert "POSITION" in output


@pytest.mark.parametrize("name", ["right_arm", "2"])
def test_a_bus_of_the_robot_has_its_name(far_end: can.BusABC, name: str) -> None:
    with opened(ROBOT, (f"{name}=virtual:ulna-test",)) as (tap,):
        assert (tap.number, tap.name) == (2, "right_arm")
    with opened(ROBOT, ("virtual:ulna-test",)) as (tap,):
        assert (tap.number, tap.name) == (-1, "virtual:ulna-test")
    assert far_end.recv(timeout=0) is None


def test_what_cannot_be_opened_is_one_sentence(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.setenv("XDG_RUNTIME_DIR", str(tmp_path))
    with pytest.raises(ConfigError, match="no bus 'tail' here; buses: head_torso"):
        opened(ROBOT, ("tail=virtual:x",)).__enter__()
    with pytest.raises(ServiceError, match="nonsense"):
        opened(ROBOT, ("nonsense:x",)).__enter__()
    with pytest.raises(ServiceError, match="can77"):
        opened(ROBOT, ("can77",)).__enter__()
    with pytest.raises(NotRunningError, match="no stack named 'other' is up here"):
        opened(ROBOT, (), stack="other").__enter__()


def test_without_stack_and_interfaces_there_is_nothing_to_listen_to(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.setenv("XDG_RUNTIME_DIR", str(tmp_path))
    monkeypatch.setattr("services.cli.can_buses.interfaces_up", lambda _names: False)
    with pytest.raises(NotRunningError, match="no stack of icub is up, and none of its interfaces"):
        opened(ROBOT, (), clock=RealClock()).__enter__()


def test_dbc_of_one_bus_has_the_names_of_the_robot(tmp_path: Path) -> None:
    path = tmp_path / "arm.dbc"
    assert can_dbc(bus="right_arm", out=path) == 0
    text = path.read_text()
    assert "BO_ 273 r_shoulder_POSITION: 8 r_shoulder" in text
    assert "BO_ 321 r_forearm_2_POSITION: 8 r_forearm_2" in text
    assert "BO_ 970 right_arm_virtual_FORCE: 7 host" in text
    assert "axis 0 r_shoulder_pitch: deg = tick / 11.375 - 177.0; axis 1 r_shoulder_roll" in text
    with pytest.raises(ConfigError, match="no bus 'tail'; known: head_torso"):
        can_dbc(bus="tail")


def test_dbc_of_all_buses_has_every_address_once() -> None:
    nodes = every_node(ROBOT)
    assert {(1, "bll_ie"), (4, "dc4 second"), (13, "strain"), (14, "mais"), (12, "virtual")} <= {
        (node.address, node.kind) for node in nodes
    }
    assert len(nodes) == len({(node.address, node.kind) for node in nodes})


def test_dbc_and_docs_go_to_standard_output_or_tell_why_not(
    capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    assert can_dbc() == 0
    assert capsys.readouterr().out.startswith('VERSION ""')
    assert can_docs() == 0
    assert capsys.readouterr().out.startswith("# The frames on the wire")
    with pytest.raises(ConfigError, match="cannot write"):
        can_docs(out=tmp_path / "missing" / "page.md")


def test_an_unknown_bus_is_told_with_those_that_there_are() -> None:
    with pytest.raises(
        ConfigError, match=r"no bus 'right_foot' here; buses: head_torso \(0\), lef"
    ):
        can_dump(bus=("right_foot",))


def test_refuses_to_wait_for_a_board_or_message_that_cannot_come() -> None:
    with pytest.raises(ConfigError, match="icub has no board 'r_sholder'; known: neck"):
        can_dump(bus=(PLACE,), board=("r_sholder",))
    with pytest.raises(ConfigError, match="no message 'POSITON'"):
        can_dump(bus=(PLACE,), message=("POSITON",))


def test_a_log_in_a_missing_folder_is_refused(tmp_path: Path) -> None:
    with pytest.raises(ConfigError, match=r"cannot write .*arm.log: No such file or directory"):
        can_log(tmp_path / "nowhere" / "arm.log", bus=(PLACE,), seconds=0.1)


@pytest.mark.parametrize("name", ["arm.log", "arm.blf"])
def test_a_file_of_garbage_is_refused(tmp_path: Path, name: str) -> None:
    file = tmp_path / name
    file.write_bytes(b"garbage without end\n")
    with pytest.raises(ConfigError, match=r"is no \.(log|blf) file of CAN frames"):
        can_dump(file=file)


def test_a_dbc_of_a_bus_by_its_number(capsys: pytest.CaptureFixture[str]) -> None:
    assert can_dbc(bus="2") == 0
    assert "r_shoulder" in capsys.readouterr().out


def test_an_unknown_message_is_told_before_its_receiver_is_asked_for() -> None:
    with pytest.raises(ConfigError, match="no message 'GET_POS_PIT'"):
        can_send(PLACE, "GET_POS_PIT")


def test_looks_at_the_robot_of_the_running_stack(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.setenv("XDG_RUNTIME_DIR", str(tmp_path))
    claim = Claim("bench", "icub", "icub:right_arm@bench")
    claim.publish("tcp/127.0.0.1:1", "zenoh")
    assert set(robot_in_use("", "bench").buses) == {"right_arm"}
    claim.release()
    assert len(robot_in_use("", "").buses) == 10
