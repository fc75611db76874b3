"""How well the model explains each FT sensor: mean and spread of measured minus predicted."""

import numpy as np

from dforc.arrays import Matrix
from services.body import BodySensor
from services.dynamics_messages import SensorHealth
from services.messages import Floats
from services.sensor_bank import SensorBank
from services.sensor_tasks import SensorTasks

MEMORY = 0.005  # share of the newest sample: two seconds at 100 Hz


class HealthFigures:
    """Running figures of every sensor, forgotten when a sensor cannot be used."""

    def __init__(self, sensors: tuple[BodySensor, ...]) -> None:
        self._sensors = sensors
        self._mean: Matrix = np.zeros((len(sensors), 6))
        self._square: Matrix = np.zeros((len(sensors), 6))
        self._count = np.zeros(len(sensors))

    def add(self, excess: Matrix, usable: tuple[bool, ...]) -> None:
        """One filtered sample (m, 6) of measured minus predicted."""
        used = np.array(usable)
        self._count = np.where(used, self._count + 1.0, 0.0)
        share = np.maximum(MEMORY, 1.0 / np.maximum(self._count, 1.0))[:, None]
        share = np.where(used[:, None], share, 0.0)
        away = excess - self._mean
        self._mean += share * away
        self._square += share * ((1.0 - share) * away * away - self._square)

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
            mean=_floats(self._mean[sensor]) if known else (),
            std=_floats(np.sqrt(self._square[sensor])) if known else (),
            task=task,
            samples=samples,
            wanted=wanted,
            gain=() if (channel.matrix == np.eye(6)).all() else _floats(channel.matrix.ravel()),
            reason=tasks.outcome[name],
        )


def _floats(values: "np.ndarray[tuple[int], np.dtype[np.float64]]") -> Floats:
    return tuple(values.tolist())
