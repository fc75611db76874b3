"""Readings of all FT sensors: compensated, and which of them can be used.

Two paths. The unfiltered one is for torques: every good reading, gain and offset removed. The
filtered one has the delay of dforc.signals, as the joints' filter: for contacts, health, learning.
A sensor is valid while its offset is known and its readings can be believed.
"""

import numpy as np

from dforc.arrays import Matrix, Vector
from dforc.signals.ft_channel import FtChannel
from dforc.signals.sensor_watch import SensorWatch
from services.core.service import Inputs
from services.messages import Wrench
from services.wholebody.body import BodySensor

LATE_PERIODS = 1.9  # without a reading: the sensor is lost
NEVER_NS = -(1 << 62)
NS_TO_S = 1e-9


class SensorBank:
    """State of every sensor, one row each."""

    def __init__(self, sensors: tuple[BodySensor, ...], period_s: float) -> None:
        """`period_s` is how often each sensor's reading is published."""
        count = len(sensors)
        self.raw: Matrix = np.zeros((count, 6))
        self.calibrated = [False] * count
        self.valid = (False,) * count
        self.mask = np.zeros(count, dtype=np.bool_)  # the same, for numerics
        self.new = (False,) * count  # a good reading came in this step
        self.refused = 0  # readings that were not taken in
        self.arrival_ns = [NEVER_NS] * count  # of the frames behind the last good reading
        self.channels = tuple(FtChannel() for _ in sensors)
        self._streams = tuple(sensor.wrench for sensor in sensors)
        self._watches = tuple(
            SensorWatch(
                full_scale=sensor.full_scale,
                late_s=LATE_PERIODS * period_s,
                missing_s=LATE_PERIODS * period_s,
            )
            for sensor in sensors
        )
        self._heard_ns = [NEVER_NS] * count
        self._first_gains = tuple(sensor.gain for sensor in sensors)
        for channel, gain in zip(self.channels, self._first_gains, strict=True):
            channel.set_matrix(gain)
        self._compensate()
        self._sum: Matrix = np.zeros((count, 6))  # of the good readings since the last filtered()
        self._count = [0] * count
        self._instants_s = [0.0] * count

    def take(self, now_ns: int, inputs: Inputs) -> bool:
        """Look at what has arrived; whether some good reading did."""
        new = []
        valid = []
        for i, stream in enumerate(self._streams):
            reading = inputs.new(stream)
            good = self._watch(i, now_ns, reading)
            new.append(good and reading is not None)
            valid.append(good and self.calibrated[i])
        self.new = tuple(new)
        if tuple(valid) != self.valid:
            self.valid = tuple(valid)
            self.mask = np.array(valid)
        return True in new

    def flags(self, sensor: int) -> tuple[str, ...]:
        """What is wrong with a sensor now."""
        flags: tuple[str, ...] = self._watches[sensor].flags
        return flags if self.calibrated[sensor] else (*flags, "uncalibrated")

    def is_heard(self, sensor: int) -> bool:
        """Whether it gives readings that can be believed, calibrated or not."""
        return self._watches[sensor].valid

    def is_filtered(self, sensor: int) -> bool:
        """Whether it gives readings that fill its filter's memory, calibrated or not."""
        return self.is_heard(sensor) and self.channels[sensor].settled

    def compensated(self) -> Matrix:
        """The newest good readings (m, 6)."""
        if self._plain:
            return self.raw - self._offset
        wrenches: Matrix = np.matmul(self._gain, self.raw[:, :, None])[:, :, 0] - self._offset
        return wrenches

    def without_offset(self, sensor: int) -> Vector:
        """The newest good reading (6,) of one sensor as a calibration wants it."""
        return self.channels[sensor].without_offset(self.raw[sensor])

    def filter_readings(self) -> None:
        """Pass the mean of the readings since the last call to the filters, at its mean instant."""
        for i, channel in enumerate(self.channels):
            count = self._count[i]
            if count:
                channel.push(self._sum[i] / count, self._instants_s[i] / count)
        self._sum[:] = 0.0
        self._count = [0] * len(self._count)
        self._instants_s = [0.0] * len(self._count)

    def filtered(self, now_ns: int) -> tuple[Matrix, tuple[bool, ...]]:
        """Wrenches (m, 6) of the filtered path, zero where there is none, and which can be used."""
        wrenches: Matrix = np.zeros_like(self.raw)
        ready = []
        for i, channel in enumerate(self.channels):
            usable = self.valid[i] and channel.settled
            ready.append(usable)
            if usable:
                wrenches[i] = channel.filtered(now_ns * NS_TO_S)
        return wrenches, tuple(ready)

    def set_offset(self, sensor: int, offset: Vector) -> None:
        """From now on, and the sensor counts as calibrated."""
        self.channels[sensor].set_offset(offset)
        self.calibrated[sensor] = True
        self._compensate()

    def set_gain(self, sensor: int, gain: Matrix) -> None:
        """Secondary matrix of one sensor; the offset that fits it comes with it."""
        self.channels[sensor].set_matrix(gain)
        self._compensate()

    def forget(self, sensor: int) -> None:
        """The offset is not known any more, and the gain is the robot file's again."""
        self.channels[sensor].set_offset(np.zeros(6))
        self.channels[sensor].set_matrix(self._first_gains[sensor])
        self.calibrated[sensor] = False
        self._compensate()

    def _compensate(self) -> None:
        self._offset: Matrix = np.array([channel.offset for channel in self.channels])
        self._gain: Matrix = np.array([channel.matrix for channel in self.channels])
        self._plain = bool(  # every gain is the identity
            (self._gain == np.eye(6)).all()
        )

    def _watch(self, sensor: int, now_ns: int, reading: Wrench | None) -> bool:
        """Judge the newest reading and take it in if it is good; whether the sensor is."""
        watch = self._watches[sensor]
        if reading is None:
            watch.check(None, (now_ns - self._heard_ns[sensor]) * NS_TO_S)
            return watch.valid
        self._heard_ns[sensor] = now_ns
        row = reading.force_n + reading.torque_nm
        if (
            watch.check(row, 0.0, reading.saturated, reading.frozen, reading.stamp_ns * NS_TO_S)
            or not watch.valid
        ):
            self.refused += 1
            return False
        self.raw[sensor] = row
        self.arrival_ns[sensor] = reading.arrival_ns
        self._sum[sensor] += self.raw[sensor]
        self._count[sensor] += 1
        self._instants_s[sensor] += now_ns * NS_TO_S
        return True
