"""The verbs of `ulna can` on a bus that really is one, and a board at its other end."""

import threading
from pathlib import Path

import pytest

from hal.buses.bus import FrameBus
from hal.wire import motor
from hal.wire.motor_periodic import POSITION
from services.cli.can_dump import can_dump
from services.cli.can_log import can_log, can_replay
from services.cli.can_send import can_send
from services.cli.can_stats import can_stats

QUESTION = motor.GET_BOARD_ID.request(1, 0)
ANSWER = motor.GET_BOARD_ID.reply(1, 0, 1)
MOVING = POSITION.frame(1, 2104, 3526)
SECONDS = 20.0  # at most: the verbs end after so many frames
LOOKS, LOOK_S = 400, 0.01  # until frames that are still on their way have arrived


class Board:
    """Broadcasts its position each 2 ms and answers one question, in a thread."""

    def __init__(self, bus: FrameBus) -> None:
        self.received: list[tuple[int, bytes]] = []
        self._bus = bus
        self._stop = threading.Event()
        self._thread = threading.Thread(target=self._run)

    def _run(self) -> None:
        while not self._stop.wait(0.002):
            self._bus.send_frames((MOVING,))
            for can_id, data, _ in self._bus.receive_frames():
                self.received.append((can_id, data))
                if (can_id, data) == QUESTION:
                    self._bus.send_frames((ANSWER,))

    def moving_since(self, first: int) -> list[tuple[int, bytes]]:
        """Frames like its own that others have sent, from the `first` received on."""
        return [frame for frame in self.received[first:] if frame == MOVING]

    def wait_for(self, count: int, first: int) -> None:
        """Until so many of those have arrived; not for ever."""
        for _ in range(LOOKS):
            if len(self.moving_since(first)) >= count or self._stop.wait(LOOK_S):
                return

    def __enter__(self) -> "Board":
        self._thread.start()
        return self

    def __exit__(self, *_: object) -> None:
        self._stop.set()
        self._thread.join()


def exercise(
    bus: FrameBus, name: str, stack: str, folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Dump, send, count, log and replay; `name` is what the user calls the bus."""
    with Board(bus) as board:
        assert can_dump(bus=(name,), stack=stack, count=3, seconds=SECONDS) == 0
        dumped = capsys.readouterr()
        assert dumped.out.count("r_shoulder       POSITION position0=2104 tick") == 3
        assert ", 0 lost, 0 unknown, 0 of wrong length" in dumped.err

        assert can_send(name, "GET_BOARD_ID", to="r_shoulder", stack=stack, wait=1.0) == 0
        assert "GET_BOARD_ID r_shoulder_pitch address=1" in capsys.readouterr().out

        assert can_stats(bus=(name,), stack=stack, seconds=0.5) == 0
        assert "right_arm" in capsys.readouterr().out

        log = folder / "arm.blf"
        assert can_log(log, bus=(name,), stack=stack, seconds=0.5) == 0
        assert "0 lost" in capsys.readouterr().err

        before = len(board.received)
        assert can_replay(log, bus=(f"2={name}",), stack=stack, speed=10.0) == 0
        sent = int(capsys.readouterr().err.split()[0])
        assert sent > 20
        board.wait_for(sent, before)
    replayed = board.moving_since(before)
    replayed += [frame[:2] for frame in bus.receive_frames() if frame[:2] == MOVING]
    assert len(replayed) == sent
