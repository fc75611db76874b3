"""Boards and buses as the HAL reports them: in messages, and in words when one changes."""

from hal.readings import BoardReport, BusReport
from services.robot_messages import BoardStatus, BusStatus, RobotStatus

LOOKING = ("opening", "handshake", "configuring")  # phases in which boards are not yet known
FOUND = ("ok", "needs calibration")
ACTIVE = "active"
RESTARTED = "restarted"  # it stays so until its axes are calibrated


class Reports:
    """Turns the HAL's reports of its boards into a message's; those that stay are kept."""

    def __init__(self) -> None:
        self._known: tuple[BoardReport, ...] = ()
        self._boards: tuple[BoardStatus, ...] = ()

    def boards(self, reports: tuple[BoardReport, ...]) -> tuple[BoardStatus, ...]:
        """What a message says of the boards."""
        if reports != self._known:
            self._known = reports
            self._boards = tuple(
                BoardStatus(
                    name=report.name,
                    bus=report.bus,
                    address=report.address,
                    state=report.state,
                    reason=report.reason,
                    since_ns=report.since_ns,
                )
                for report in reports
            )
        return self._boards


def bus_statuses(reports: tuple[BusReport, ...]) -> tuple[BusStatus, ...]:
    """What a message says of the buses."""
    return tuple(
        BusStatus(
            number=report.number,
            state=report.state,
            frames_received=report.frames_received,
            frames_sent=report.frames_sent,
            frames_lost=report.frames_lost,
            errors=report.errors,
            load_percent=report.load_percent,
        )
        for report in reports
    )


class BoardNews:
    """Says once of each board and bus what has become of it; nothing before the HAL has looked."""

    def __init__(self) -> None:
        self._told: dict[str, tuple[str, str]] = {}
        self._buses: dict[int, str] = {}
        self._has_begun = False

    def lines(self, status: RobotStatus) -> list[str]:
        """A line for each state that was not told yet; what is well at first is only counted."""
        if status.phase in LOOKING:
            return []
        found: list[str] = []
        if not self._has_begun:
            self._has_begun = True
            found = self._first_lines(status)
        for bus in status.buses:
            if self._buses.setdefault(bus.number, ACTIVE) != bus.state:
                self._buses[bus.number] = bus.state
                found.append(f"bus {bus.number}: {bus.state}")
        for board in status.boards:
            now = board.state, board.reason
            if now != self._told.get(board.name):
                self._told[board.name] = now
                found.append(f"board {board.name} {_text(board)}")
        return found

    def _first_lines(self, status: RobotStatus) -> list[str]:
        """How many boards were found, and why the HAL has given up if it has."""
        well = {b.name: (b.state, b.reason) for b in status.boards if b.state in FOUND}
        self._told.update(well)
        lines = [f"{len(well)} of {len(status.boards)} boards found and configured"]
        if status.phase == "failed":
            lines.append(f"the robot has failed: {', '.join(status.faults[-1:])}")
        return lines


def _text(board: BoardStatus) -> str:
    """The reason often names the board and where it is by itself."""
    where = f"(bus {board.bus}, address {board.address})"
    reason = board.reason.removeprefix(f"board {board.name} {where}").strip(" :")
    if board.state == RESTARTED and not reason:
        reason = "configured again, idle, needs calibration"
    return f"{where}: {board.state}" + (f", {reason}" if reason else "")
