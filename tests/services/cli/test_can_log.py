from collections import Counter
from pathlib import Path

import can
import pytest

from hal.wire.can import Frame
from services.cli.can_dump import can_dump
from services.cli.can_files import Logged, read, writer_of
from services.cli.can_log import bus_map, log, refuse_danger, replay
from services.core.clock import VirtualClock
from services.core.errors import ConfigError
from tests.services.cli.can_bench import ROBOT, MakeWires, Wires, frame_of_text

DAY_NS = 1_700_000_000 * 10**9  # the day's clock at the origin of ours


class HostClock(VirtualClock):
    def since_day_clock_ns(self) -> int:
        return -DAY_NS


POSITION = frame_of_text("111#38080000C60D0000")
STATUS = frame_of_text("123#0000000100000000")
ACKNOWLEDGE = frame_of_text("2D0#")


def recorded(wires: Wires, path: Path) -> int:
    """Two frames of the right arm and 4 ms later one of the left arm."""
    wires.boards["right_arm"].send_frames((POSITION, ACKNOWLEDGE))
    wires.clock.advance_ns(4_000_000)
    wires.boards["left_arm"].send_frames((STATUS,))
    with writer_of(path) as writer:
        return log(wires.taps, HostClock(), writer, wires.clock, wires.after(10))


@pytest.mark.parametrize("suffix", [".log", ".asc", ".blf"])
def test_every_format_gives_back_frames_buses_and_times(
    make_wires: MakeWires, tmp_path: Path, suffix: str
) -> None:
    path = tmp_path / f"arms{suffix}"
    assert recorded(make_wires("right_arm", "left_arm"), path) == 3

    foreign: Counter[str] = Counter()
    logged = list(read(path, foreign))

    assert [(one.channel, one.frame) for one in logged] == [
        (2, POSITION),
        (2, ACKNOWLEDGE),
        (1, STATUS),
    ]
    assert logged[2].time_s - logged[0].time_s == pytest.approx(0.004, abs=1e-5)
    assert not foreign


def test_times_are_those_of_the_day(make_wires: MakeWires, tmp_path: Path) -> None:
    recorded(make_wires("right_arm", "left_arm"), tmp_path / "arms.log")
    assert (tmp_path / "arms.log").read_text().splitlines() == [
        "(1700000000.000000) can2 111#38080000C60D0000 R",
        "(1700000000.000000) can2 2D0# R",
        "(1700000000.004000) can1 123#0000000100000000 R",
    ]


class Spy(VirtualClock):
    """Notes when it is slept for."""

    def __init__(self) -> None:
        super().__init__()
        self.slept_ms: list[float] = []

    def sleep_until(self, deadline_ns: int) -> None:
        super().sleep_until(deadline_ns)
        self.slept_ms.append(deadline_ns / 1e6)


@pytest.mark.parametrize(("speed", "slept_ms"), [(1.0, [4.0, 10.0]), (2.0, [2.0, 5.0])])
def test_replay_keeps_the_time_between_frames(
    make_wires: MakeWires, speed: float, slept_ms: list[float]
) -> None:
    wires = make_wires("right_arm")
    logged = [
        Logged(2, POSITION, 100.0),
        Logged(2, STATUS, 100.0),
        Logged(2, POSITION, 100.004),
        Logged(2, STATUS, 100.010),
    ]
    clock = Spy()

    outcome = replay(logged, {2: wires.taps[0]}, clock, speed)

    assert clock.slept_ms == pytest.approx(slept_ms)
    assert outcome == Counter(sent=4)
    sent = [frame[:2] for frame in wires.boards["right_arm"].receive_frames()]
    assert sent == [POSITION, STATUS, POSITION, STATUS]


def test_replay_maps_buses_and_skips_the_others(make_wires: MakeWires) -> None:
    wires = make_wires("left_arm", "right_arm")
    logged = [Logged(2, POSITION, 0.0), Logged(7, STATUS, 0.0), Logged(1, STATUS, 0.001)]
    outcome = replay(logged, {2: wires.taps[0], 1: wires.taps[1]}, VirtualClock())
    assert outcome == Counter(sent=2, skipped=1)
    frames: dict[str, list[Frame]] = {
        name: [frame[:2] for frame in bus.receive_frames()] for name, bus in wires.boards.items()
    }
    assert frames == {"left_arm": [POSITION], "right_arm": [STATUS]}


def test_a_file_goes_to_the_robots_buses_of_its_numbers_unless_told() -> None:
    assert bus_map((), ROBOT, {1, 2, 40}) == {1: "left_arm", 2: "right_arm"}
    assert bus_map(("2=vcan7", "40=slcan:/dev/ttyACM0"), ROBOT, {1, 2}) == {
        2: "vcan7",
        40: "slcan:/dev/ttyACM0",
    }
    with pytest.raises(ConfigError, match="write number of the file = bus"):
        bus_map(("right_arm",), ROBOT, {2})


def test_a_file_with_a_discovery_is_refused_for_the_buses_it_goes_to() -> None:
    logged = [Logged(2, POSITION, 0.0), Logged(3, frame_of_text("70F#FF"), 0.0)]
    refuse_danger(logged, {2})
    with pytest.raises(ConfigError, match="not sent: 70F#FF a discovery switches off"):
        refuse_danger(logged, {2, 3})


def test_frames_that_the_icub_has_not_are_counted(tmp_path: Path) -> None:
    path = tmp_path / "odd.log"
    with can.Logger(str(path)) as writer:
        writer.on_message_received(can.Message(arbitration_id=0x12345, channel=2))
        writer.on_message_received(can.Message(is_error_frame=True, channel=2))
        writer.on_message_received(
            can.Message(arbitration_id=0x115, is_extended_id=False, channel=2)
        )
    foreign: Counter[str] = Counter()
    assert [one.frame for one in read(path, foreign)] == [(0x115, b"")]
    assert foreign == Counter(foreign=2)


def test_files_that_cannot_be_read_are_one_sentence(tmp_path: Path) -> None:
    with pytest.raises(ConfigError, match=r"end in one of \.log, \.asc, \.blf"):
        list(read(tmp_path / "arm.csv", Counter()))
    with pytest.raises(ConfigError, match="cannot read"):
        list(read(tmp_path / "missing.log", Counter()))
    (tmp_path / "broken.log").write_text("(1.0) can0 zz#00\n")
    with pytest.raises(ConfigError, match=r"no \.log file of CAN frames"):
        list(read(tmp_path / "broken.log", Counter()))


def test_a_file_is_dumped_with_the_names_of_its_buses(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / "arms.log"
    path.write_text(
        "(5.000000) can2 123#0000000100000000\n"
        "(5.004000) can1 111#38080000C60D0000\n"
        "(5.005000) can2 11E#00\n"
        "(5.006000) can40 111#38080000C60D0000\n"
    )
    assert can_dump(file=path, bus=("right_arm", "40")) == 0
    output = capsys.readouterr()
    lines = output.out.splitlines()
    assert [line[:33].split() for line in lines] == [
        ["0.000000", "right_arm", "123", "00"],
        ["0.005000", "right_arm", "11E", "00"],
        ["0.006000", "can40", "111", "38"],
    ]
    assert "r_elbow          STATUS" in lines[0]
    assert "board 1          POSITION position0=2104 tick, position1" in lines[2]
    assert output.err == "3 shown, 1 unknown, 0 of wrong length\n"

    assert can_dump(file=path, joint=("l_shoulder_pitch",), count=1) == 0
    assert "POSITION position0=2104 tick (l_shoulder_pitch 0.03 deg)" in capsys.readouterr().out
