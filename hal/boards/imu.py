"""Host side of the IMU board: quaternion, rates, acceleration and magnetic field in one sample."""

from collections import deque
from collections.abc import Iterable

from hal.boards.board import Parts, Pulse
from hal.boards.imu_reader import ImuReader
from hal.boards.sensor import KEPT_SAMPLES, Group, SensorBoard
from hal.line import Handler
from hal.readings import ImuSample
from hal.wire.can import Frame
from hal.wire.management import BoardType


class Imu(SensorBoard):
    """One IMU board (see firmware_sim/boards/imu.py on what it stands for)."""

    type_code = BoardType.RFE
    default_period_ms = 10

    def __init__(self, parts: Parts) -> None:
        super().__init__(parts)
        pulse = Pulse(parts.board.address, "IMU frames")
        self.pulses = (pulse,)
        self._samples: deque[ImuSample] = deque(maxlen=KEPT_SAMPLES)
        self.unit = ImuReader(parts, pulse, self._samples.append)

    def handlers(self) -> Iterable[tuple[int, Handler]]:
        """Those of the unit."""
        return self.unit.handlers()

    def quiesce(self) -> Iterable[Frame]:
        """Stop transmitting."""
        return [self.unit.silence()]

    def settings(self) -> Iterable[Group]:
        """What to measure, and how often."""
        return [self.unit.settings(self.period_ms)]

    def forget(self) -> None:
        """The board counts anew."""
        self.unit.forget()

    def take(self) -> list[ImuSample]:
        """Samples since the previous call, oldest first."""
        samples = list(self._samples)
        self._samples.clear()
        return samples
