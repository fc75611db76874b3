"""A robot of two motor boards and one FT sensor, whose frames are written by hand."""

from collections.abc import Mapping, Sequence

import can
from can.typechecking import CanFilters

from hal.boards.verify import getter_of
from hal.description import RobotDescription
from hal.robot import Robot
from hal.tasks import Task
from hal.wire import motor
from hal.wire.can import Frame, Received
from tests.hal.arm import BUS, DESCRIPTION, PITCH, ROLL

MS = 1_000_000
FORCE_ID = 0x3DA
MODES = (motor.GET_CONTROL_MODE, motor.GET_INTERACTION_MODE)  # answered as a test says

ANSWERS = {
    "001 5B0106": "010 5B04025057010601",  # BLL, firmware 2.50 build 87, protocol 1.6, accepted
    "003 5B0106": "030 5B03021957010601",  # 4DC, firmware 2.19
    "20D 1C0100": "2D0 1C06030005010001",  # STRAIN, firmware 3.0 build 5, protocol 1.0, accepted
    "001 38": "010 38000000",  # not calibrated, idle, stiff
    "001 B8": "010 B8000000",
    "003 38": "030 38000000",
    "004 38": "040 38000000",
    "20D 1800": "2D0 180005F1",  # 1521 N
    "20D 1801": "2D0 1801067A",
    "20D 1802": "2D0 180207AE",
    "20D 1803": "2D0 18030022",  # 34 Nm
    "20D 1804": "2D0 18040023",
    "20D 1805": "2D0 18050016",
    "20D 0801": "2D0 ",  # STRAIN acknowledges every SET with an empty frame
    "20D 0700": "2D0 ",
}

POSITIONS = {
    0x111: "D107 0000 9803 0000",  # 2001 ticks = -1.09 deg; 920 ticks = 43.88 deg
    0x131: "00000000 00000000",
    0x141: "C8070000 00000000",  # 1992 ticks = 4.88 deg
}


def frame(text: str) -> Frame:
    """Frame written as `ID bytes`, in hex."""
    can_id, _, data = text.partition(" ")
    return int(can_id, 16), bytes.fromhex(data)


def text(sent: Frame) -> str:
    """The reverse of `frame`."""
    return f"{sent[0]:03X} {sent[1].hex().upper()}"


class ScriptedBus:
    """A FrameBus whose other end is a table of answers and a list of periodic frames."""

    def __init__(self) -> None:
        self.answers = {frame(question): frame(answer) for question, answer in ANSWERS.items()}
        self._settings: set[Frame] = set()
        self.positions = {can_id: bytes.fromhex(data) for can_id, data in POSITIONS.items()}
        self.wrench: list[Frame] = [frame("3DA 008000800080"), frame("3DB 008000800080")]
        self.inbox: list[Frame] = []
        self.sent: list[Frame] = []
        self.ms = 0
        self.lost = 0
        self.bus_state = can.BusState.ACTIVE
        self.filters: CanFilters | None = None

    @property
    def frames_lost(self) -> int:
        return self.lost

    @property
    def state(self) -> can.BusState:
        return self.bus_state

    def send_frames(self, frames: Sequence[Frame]) -> None:
        self.sent += frames
        for sent in frames:
            if sent in self.answers:
                self.inbox.append(self.answers[sent])
            elif sent[0] < 0x100:
                self._remember(*sent)

    def _remember(self, can_id: int, data: bytes) -> None:
        """Keep a setting and answer the question for it, unless the test answers that itself."""
        row, axis = motor.command_of(data), motor.axis_of(data)
        values = None if row is None else row.parse_request(data)
        asked = None if row is None else getter_of(row)
        if asked is None or values is None or asked in MODES:
            return
        if asked is motor.GET_IMPEDANCE_PARAMS:
            values = (*values, 0)
        question = asked.request(can_id, axis)
        if question not in self.answers or question in self._settings:
            self._settings.add(question)
            self.answers[question] = asked.reply(can_id, axis, *values)

    def receive_frames(self) -> list[Received]:
        self.ms += 1
        frames, self.inbox = self.inbox, []
        if self.ms % 4 == 0:
            frames += list(self.positions.items())
        frames += [self._noisy(*one) for one in self.wrench]
        return [(can_id, data, self.ms * MS) for can_id, data in frames]

    def _noisy(self, can_id: int, data: bytes) -> Frame:
        """A gauge is never still: the last bit of Fx flips with every sample."""
        if can_id == FORCE_ID and self.ms & 1:
            return can_id, bytes((data[0] ^ 1, *data[1:]))
        return can_id, data

    def set_filters(self, filters: CanFilters | None = None) -> None:
        self.filters = filters

    def shutdown(self) -> None:
        pass


class Script:
    """A Robot on a ScriptedBus, and its time."""

    def __init__(
        self,
        description: RobotDescription = DESCRIPTION,
        others: Mapping[int, ScriptedBus] | None = None,
    ) -> None:
        self.bus = ScriptedBus()
        self.robot = Robot(description, {BUS: self.bus, **(others or {})})

    @property
    def now_ns(self) -> int:
        return self.bus.ms * MS

    def tick(self, count: int = 1) -> list[str]:
        """Pass milliseconds; what was sent in them."""
        self.bus.sent.clear()
        for _ in range(count):
            self.robot.step(self.now_ns + MS)
        return [text(sent) for sent in self.bus.sent]

    def say(self, *frames: str) -> None:
        """Let the boards send something that arrives with the next millisecond."""
        self.bus.inbox += [frame(said) for said in frames]

    def open(self) -> None:
        """Pass the start-up."""
        for _ in range(12_000):  # a missing board is waited for
            if self.robot.phase in ("idle", "failed"):
                return
            self.tick()
        raise AssertionError(self.robot.phase)

    def ready(self, mode: int = 0x01) -> None:
        """Everything open, calibrated, and in a control mode (position unless told)."""
        for question in ("001 38", "001 B8", "003 38", "004 38"):
            asked, (can_id, reply) = frame(question), self.bus.answers[frame(question)]
            self.bus.answers[asked] = (can_id, bytes((reply[0], 1, 0, 0)))
        self.open()
        self.status(0x113, mode, mode)
        self.status(0x133, mode, mode)
        self.status(0x143, mode, mode)
        self.tick()

    def status(self, can_id: int, mode0: int, mode1: int, fault0: int = 0, fault1: int = 0) -> None:
        """A STATUS frame arrives with the next millisecond."""
        self.bus.inbox.append((can_id, bytes((fault0, mode0, fault1, mode1, 0, 0, 0, 0))))

    def torques(self) -> None:
        """Fresh joint torques of zero."""
        assert self.robot.set_joint_torques([PITCH, ROLL], [0.0, 0.0], self.now_ns)

    def finish(self, task: Task, limit_ms: int = 5000) -> int:
        """Pass milliseconds until a task is done; how many."""
        for passed in range(limit_ms):
            if task.done:
                return passed
            self.tick()
        raise AssertionError(f"{task.action} not done after {limit_ms} ms")
