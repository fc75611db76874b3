"""How well the model explains each FT sensor: mean and spread of measured minus predicted."""

import math
from collections import deque
from collections.abc import Sequence

import numpy as np

from dforc.arrays import Matrix
from dforc.contacts.location import SENSOR_NOISE, WrenchNoise
from services.messages import Floats
from services.wholebody.body import BodySensor
from services.wholebody.dynamics_messages import SensorHealth
from services.wholebody.sensor_bank import SensorBank
from services.wholebody.sensor_tasks import SensorTasks

MEMORY = 0.005  # share of the newest sample: two seconds at 100 Hz
HELD = 15  # looks: a step of force is past the filter


class HealthFigures:
    """Running figures of every sensor while nothing touches its limb, from when it can be used.

    A touch grows before it is noticed and leaves the filters after it has ended, so a sample
    counts that no touch follows or precedes within `HELD` looks.
    """

    def __init__(self, sensors: tuple[BodySensor, ...]) -> None:
        self._sensors = sensors
        # Of measured minus predicted, then of the same when the learner's correction is taken off.
        self._mean: Matrix = np.zeros((len(sensors), 12))
        self._square: Matrix = np.zeros((len(sensors), 12))
        self._count = np.zeros(len(sensors))
        self._quiet = np.zeros(len(sensors), dtype=np.int64)  # looks since use or touch began
        self._held: deque[Matrix] = deque(maxlen=HELD + 1)

    def add(
        self, excess: Matrix, left: Matrix, usable: Sequence[bool], touched: Sequence[bool]
    ) -> None:
        """One filtered look, arrays (m, 6).

        Args:
            excess: measured minus predicted.
            left: the same when the learner's correction is taken off.
            usable: sensors.
            touched: sensors that something touches the limb beyond.
        """
        used = np.array(usable)
        self._quiet = np.where(used, np.where(touched, -HELD, self._quiet + 1), 0)
        self._held.append(np.hstack([excess, left]))
        taken = self._quiet > HELD
        self._count = np.where(used, self._count + taken, 0.0)
        share = np.maximum(MEMORY, 1.0 / np.maximum(self._count, 1.0))[:, None]
        share = np.where(taken[:, None], share, 0.0)
        away = self._held[0] - self._mean
        self._mean += share * away
        self._square += share * ((1.0 - share) * away * away - self._square)

    def noise(self, sensor: int) -> WrenchNoise:
        """What an untouched sensor shows beside model and learner; the sensor's own at least."""
        return self._noise(sensor, slice(6, 12))

    def model_noise(self, sensor: int) -> WrenchNoise:
        """What an untouched sensor shows beside the model alone; the sensor's own at least."""
        return self._noise(sensor, slice(0, 6))

    def _noise(self, sensor: int, columns: slice) -> WrenchNoise:
        if not self._count[sensor]:
            return SENSOR_NOISE
        whole = self._square[sensor, columns] + self._mean[sensor, columns] ** 2
        return WrenchNoise(
            force_n=max(SENSOR_NOISE.force_n, math.sqrt(whole[:3].mean())),
            moment_nm=max(SENSOR_NOISE.moment_nm, math.sqrt(whole[3:].mean())),
        )

    def messages(self, bank: SensorBank, tasks: SensorTasks) -> tuple[SensorHealth, ...]:
        """What is to be said of every sensor."""
        return tuple(self._message(i, bank, tasks) for i in range(len(self._sensors)))

    def _message(self, sensor: int, bank: SensorBank, tasks: SensorTasks) -> SensorHealth:
        name = self._sensors[sensor].name
        task, samples, wanted = tasks.progress(sensor)
        channel = bank.channels[sensor]
        known = self._count[sensor] > 0
        flags = bank.flags(sensor)
        return SensorHealth(
            name=name,
            ok=not flags,
            flags=flags,
            offset=_floats(channel.offset) if bank.calibrated[sensor] else (),
            mean=_floats(self._mean[sensor, :6]) if known else (),
            std=_floats(np.sqrt(self._square[sensor, :6])) if known else (),
            task=task,
            samples=samples,
            wanted=wanted,
            gain=() if (channel.matrix == np.eye(6)).all() else _floats(channel.matrix.ravel()),
            reason=tasks.outcome[name],
        )


def _floats(values: "np.ndarray[tuple[int], np.dtype[np.float64]]") -> Floats:
    return tuple(values.tolist())
