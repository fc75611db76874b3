"""Puts the frames of one acquisition of a BNO055 together (can-protocol 7.2)."""

import math
from collections.abc import Callable

from hal.boards.board import Parts, Pulse, board_name
from hal.line import Handler
from hal.readings import ImuSample, Triple
from hal.wire import analog_setup, inertial
from hal.wire.analog_setup import ImuSensor
from hal.wire.can import CLASS_INERTIAL_PERIODIC, Frame, frame_id
from hal.wire.inertial import ImuKind

SENSORS = (
    ImuSensor.ACCELEROMETER
    | ImuSensor.MAGNETOMETER
    | ImuSensor.GYROSCOPE
    | ImuSensor.QUATERNION
    | ImuSensor.STATUS
)
FUSION = 1  # quaternion from all three sensors
M_S2_PER_COUNT = 1.0 / inertial.IMU_COUNTS_PER_M_S2
T_PER_COUNT = 1e-6 / inertial.IMU_COUNTS_PER_MICROTESLA
RAD_S_PER_COUNT = math.radians(1.0 / inertial.IMU_COUNTS_PER_DEG_S)
PER_COUNT = 1.0 / inertial.IMU_COUNTS_PER_UNIT
SEQUENCE_MASK = 0xFF
_UNKNOWN = -1


class ImuReader:
    """Of one board; `lost` counts the acquisitions that the sequence numbers say are missing."""

    def __init__(self, parts: Parts, pulse: Pulse, ready: Callable[[ImuSample], None]) -> None:
        self.lost = 0
        self._name = board_name(parts.board)
        self._faults = parts.faults
        self._pulse = pulse
        self._ready = ready
        self._address = parts.board.address
        self.forget()

    def forget(self) -> None:
        """The board starts to count anew."""
        self._sequence = _UNKNOWN
        self._sent_sequence = _UNKNOWN
        self._triples: dict[int, tuple[int, ...]] = {}
        self._quaternion: tuple[int, ...] | None = None

    def handlers(self) -> list[tuple[int, Handler]]:
        """The three messages of an acquisition; the status comes last."""
        table: list[tuple[int, Handler]] = [
            (inertial.IMU_TRIPLE.type, self.on_triple),
            (inertial.IMU_QUATERNION.type, self.on_quaternion),
            (inertial.IMU_STATUS.type, self.on_status),
        ]
        return [
            (frame_id(CLASS_INERTIAL_PERIODIC, self._address, kind), handler)
            for kind, handler in table
        ]

    def settings(self, period_ms: int) -> tuple[Frame, ...]:
        """What to measure, and how often."""
        return (
            analog_setup.IMU_CONFIG_SET.request(self._address, SENSORS, FUSION, 0, 0, 0),
            analog_setup.IMU_TRANSMIT.request(self._address, period_ms),
        )

    def silence(self) -> Frame:
        """Stop transmitting."""
        return analog_setup.IMU_TRANSMIT.request(self._address, 0)

    def on_triple(self, data: bytes, stamp_ns: int) -> None:  # noqa: ARG002  (a handler)
        """One of the sensors."""
        values = inertial.IMU_TRIPLE.parse(data)
        if values is None:
            self._faults.drop("IMU_TRIPLE of wrong length")
            return
        sequence, sensor, *triple = values
        if sequence != self._sequence:
            if self._triples or self._quaternion:
                self._faults.drop("incomplete acquisition of an IMU")
            self._sequence = sequence
            self._triples.clear()
            self._quaternion = None
        self._triples[sensor] = tuple(triple)

    def on_quaternion(self, data: bytes, stamp_ns: int) -> None:  # noqa: ARG002  (a handler)
        """It carries no number and belongs to the acquisition under way."""
        self._quaternion = inertial.IMU_QUATERNION.parse(data)
        if self._quaternion is None:
            self._faults.drop("IMU_QUATERNION of wrong length")

    def on_status(self, data: bytes, stamp_ns: int) -> None:
        """The last frame of an acquisition makes a sample of it, if it is complete."""
        values = inertial.IMU_STATUS.parse(data)
        if values is None:
            self._faults.drop("IMU_STATUS of wrong length")
            return
        sequence, gyroscope, accelerometer, magnetometer, _ = values
        parts, quaternion = self._triples, self._quaternion
        self._triples, self._quaternion = {}, None
        acceleration = parts.get(ImuKind.ACCELEROMETER)
        magnetic = parts.get(ImuKind.MAGNETOMETER)
        gyro = parts.get(ImuKind.GYROSCOPE)
        is_one = sequence == self._sequence
        if not (is_one and quaternion and acceleration and magnetic and gyro):
            self._faults.drop("incomplete acquisition of an IMU")
            return
        self._pulse.heard_ns = stamp_ns
        w, x, y, z = quaternion
        self._ready(
            ImuSample(
                (w * PER_COUNT, x * PER_COUNT, y * PER_COUNT, z * PER_COUNT),
                _scaled(gyro, RAD_S_PER_COUNT),
                _scaled(acceleration, M_S2_PER_COUNT),
                _scaled(magnetic, T_PER_COUNT),
                (gyroscope, accelerometer, magnetometer),
                sequence,
                self._gap(sequence, stamp_ns),
                stamp_ns,
            )
        )

    def _gap(self, sequence: int, stamp_ns: int) -> int:
        before, self._sent_sequence = self._sent_sequence, sequence
        if before == _UNKNOWN:
            return 0
        gap = sequence - before - 1 & SEQUENCE_MASK
        if gap:
            self.lost += gap
            text = f"{self._name} lost {gap} IMU acquisitions ({self.lost} in all)"
            self._faults.report(stamp_ns, text, f"{self._name} lost")
        return gap


def _scaled(counts: tuple[int, ...], per_count: float) -> Triple:
    x, y, z = counts
    return x * per_count, y * per_count, z * per_count
