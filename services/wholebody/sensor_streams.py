"""Streams of the sensors beside force/torque: Hall sensors, skin, inertial sensors and IMUs.

They are looked at a hundred times a second; of several samples since then the newest goes out, and
of the skin, which must not lose a touch, each.
"""

from collections.abc import Callable, Iterator

from hal.readings import HallSample, ImuSample, InertialSample, SkinSample
from hal.robot import Robot
from services.core.service import Outputs
from services.core.stream import AnyStream
from services.messages import Hall, Imu, Inertial, Skin
from services.streams import HALL, IMU, INERTIAL, SKIN

LOOK_HZ = 100


class SensorStreams:
    """What one robot's sensors publish, in the order of the robot file."""

    def __init__(self, hal: Robot) -> None:
        self._hal = hal
        self.streams = tuple(self._declared())

    def publish(self, now_ns: int, outputs: Outputs) -> None:
        """Send what has come since the last look."""
        for kind, names in self._hal.sensors.items():
            publish = PUBLISHERS.get(kind)
            if publish is not None:
                for name in names:
                    publish(self._hal, name, now_ns, outputs)

    def _declared(self) -> Iterator[AnyStream]:
        for kind, names in self._hal.sensors.items():
            stream_at = STREAM_AT.get(kind)
            if stream_at is not None:
                yield from map(stream_at, names)


STREAM_AT: dict[str, Callable[[str], AnyStream]] = {
    "hall": HALL.__getitem__,
    "skin": SKIN.__getitem__,
    "inertial": INERTIAL.__getitem__,
    "imu": IMU.__getitem__,
}


def _hall(hal: Robot, name: str, now_ns: int, outputs: Outputs) -> None:
    samples = hal.take_samples(name, HallSample)
    if samples:
        newest = samples[-1]
        outputs.put(
            HALL[name],
            Hall(stamp_ns=now_ns, counts=newest.hall_counts, arrival_ns=newest.arrival_ns),
        )


def _skin(hal: Robot, name: str, now_ns: int, outputs: Outputs) -> None:
    for sample in hal.take_samples(name, SkinSample):
        outputs.put(
            SKIN[name],
            Skin(
                stamp_ns=now_ns,
                taxels=sample.taxels,
                errors=sample.errors,
                heard=sample.heard,
                no_load=sample.no_load,
                arrival_ns=sample.arrival_ns,
            ),
        )


def _inertial(hal: Robot, name: str, now_ns: int, outputs: Outputs) -> None:
    samples = hal.take_samples(name, InertialSample)
    if samples:
        newest = samples[-1]
        outputs.put(
            INERTIAL[name],
            Inertial(
                stamp_ns=now_ns,
                gyro_rad_s=newest.gyro_rad_s,
                acceleration_m_s2=newest.acceleration_m_s2,
                arrival_ns=newest.arrival_ns,
            ),
        )


def _imu(hal: Robot, name: str, now_ns: int, outputs: Outputs) -> None:
    samples = hal.take_samples(name, ImuSample)
    if samples:
        newest = samples[-1]
        outputs.put(
            IMU[name],
            Imu(
                stamp_ns=now_ns,
                quaternion=newest.quaternion,
                gyro_rad_s=newest.gyro_rad_s,
                acceleration_m_s2=newest.acceleration_m_s2,
                magnetic_t=newest.magnetic_t,
                arrival_ns=newest.arrival_ns,
                lost=sum(sample.lost for sample in samples),
            ),
        )


PUBLISHERS: dict[str, Callable[[Robot, str, int, Outputs], None]] = {
    "hall": _hall,
    "skin": _skin,
    "inertial": _inertial,
    "imu": _imu,
}
