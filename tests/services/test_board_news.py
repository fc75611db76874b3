"""What `ulna up` says of boards and buses."""

from hal.readings import BoardReport
from services.board_news import BoardNews, Reports
from services.robot_messages import BoardStatus, BusStatus, RobotStatus


def board(name: str, state: str, reason: str = "") -> BoardStatus:
    return BoardStatus(name=name, bus=2, address=1, state=state, reason=reason, since_ns=0)


def status(*boards: BoardStatus, phase: str = "idle", bus: str = "active") -> RobotStatus:
    return RobotStatus(
        stamp_ns=0,
        phase=phase,
        calibrated=False,
        compliant=(),
        faults=("board b is of type 3",),
        fault_count=1,
        frames_received=0,
        frames_sent=0,
        frames_lost=0,
        frames_dropped=0,
        boards=boards,
        buses=(
            BusStatus(
                number=2,
                state=bus,
                frames_received=0,
                frames_sent=0,
                frames_lost=0,
                errors=0,
                load_percent=0.0,
            ),
        ),
    )


def test_nothing_is_said_while_the_hal_looks_for_boards() -> None:
    assert BoardNews().lines(status(board("a", "missing"), phase="handshake")) == []


def test_boards_that_are_well_are_counted_and_the_others_named() -> None:
    reason = "board b (bus 2, address 1) does not answer the handshake"
    boards = (board("a", "needs calibration", "pitch"), board("b", "missing", reason))
    assert BoardNews().lines(status(*boards)) == [
        "1 of 2 boards found and configured",
        "board b (bus 2, address 1): missing, does not answer the handshake",
    ]


def test_each_change_is_one_line() -> None:
    news = BoardNews()
    news.lines(status(board("a", "ok")))
    assert news.lines(status(board("a", "ok"))) == []
    assert news.lines(status(board("a", "silent", "no POSITION"))) == [
        "board a (bus 2, address 1): silent, no POSITION"
    ]
    assert news.lines(status(board("a", "restarted"))) == [
        "board a (bus 2, address 1): restarted, configured again, idle, needs calibration"
    ]
    assert news.lines(status(board("a", "ok"))) == ["board a (bus 2, address 1): ok"]


def test_a_bus_that_is_off_and_back_is_said() -> None:
    news = BoardNews()
    news.lines(status())
    assert news.lines(status(bus="off")) == ["bus 2: off"]
    assert news.lines(status()) == ["bus 2: active"]


def test_a_failed_start_says_why() -> None:
    assert BoardNews().lines(status(phase="failed"))[1] == (
        "the robot has failed: board b is of type 3"
    )


def test_reports_that_stay_are_not_made_again() -> None:
    report = BoardReport(
        name="a",
        bus=2,
        address=1,
        type="bll",
        found_type=4,
        firmware=(2, 0x50),
        found_firmware=(2, 0x50),
        build=87,
        protocol=(1, 6),
        state="ok",
        reason="",
        since_ns=5,
    )
    reports = Reports()
    first = reports.boards((report,))
    assert first == (BoardStatus(name="a", bus=2, address=1, state="ok", reason="", since_ns=5),)
    assert reports.boards((report,)) is first
