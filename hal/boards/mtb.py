"""Host side of the MTB: up to 16 triangles of skin, accelerometer and gyroscope."""

import math
from collections import deque
from collections.abc import Iterable

from hal.boards.board import SILENCE_NS, Parts, Pulse
from hal.boards.sensor import KEPT_SAMPLES, MS, Group, SensorBoard
from hal.boards.skin_reader import NO_LOAD, SkinReader
from hal.line import Handler
from hal.readings import InertialSample, SkinSample
from hal.wire import analog, analog_setup, inertial, skin
from hal.wire.analog import TxMode
from hal.wire.analog_setup import MtbSensor, SkinType
from hal.wire.can import CLASS_INERTIAL_PERIODIC, Frame, frame_id
from hal.wire.management import BoardType

INERTIAL_PERIOD_MS = 10
SHIFT = 2
ENABLED = 1
INERTIAL = MtbSensor.EXTERNAL_ACCELEROMETER | MtbSensor.EXTERNAL_GYROSCOPE
NO_INERTIAL = MtbSensor(0)
G_M_S2 = 9.80665
RAD_S_PER_COUNT = math.radians(1.0 / inertial.MTB_COUNTS_PER_DEG_S)
M_S2_PER_COUNT = G_M_S2 / inertial.MTB_COUNTS_PER_G


class Mtb(SensorBoard):
    """One MTB; its inertial sensors are used when the robot file says where they sit."""

    type_code = BoardType.SKIN
    overflow = skin.RECEIVE_OVERFLOW
    default_period_ms = skin.DEFAULT_PERIOD_MS

    def __init__(self, parts: Parts) -> None:
        super().__init__(parts)
        address = parts.board.address
        limit_ns = max(SILENCE_NS, 3 * self.period_ms * MS)
        skin_pulse = Pulse(address, "skin frames", limit_ns)
        self._inertial_pulse = Pulse(address, "accelerometer and gyroscope frames")
        self._has_inertial = bool(parts.board.frame)
        self.pulses = (skin_pulse, self._inertial_pulse) if self._has_inertial else (skin_pulse,)
        self._samples: deque[SkinSample | InertialSample] = deque(maxlen=KEPT_SAMPLES)
        self.skin = SkinReader(parts, self.period_ms, skin_pulse, self._samples.append)
        self._gyro: tuple[int, ...] | None = None
        self._gyro_ns = 0

    def handlers(self) -> Iterable[tuple[int, Handler]]:
        """Skin frames of both classes, gyroscope and accelerometer."""
        address = self.board.address
        gyroscope = frame_id(CLASS_INERTIAL_PERIODIC, address, inertial.GYROSCOPE.type)
        accelerometer = frame_id(CLASS_INERTIAL_PERIODIC, address, inertial.ACCELEROMETER.type)
        return [
            *self.skin.handlers(address),
            (gyroscope, self.on_gyroscope),
            (accelerometer, self.on_accelerometer),
        ]

    def quiesce(self) -> Iterable[Frame]:
        """Stop skin and inertial sensors."""
        return [*super().quiesce(), self._inertial_setting(NO_INERTIAL)]

    def settings(self) -> Iterable[Group]:
        """Skin, inertial sensors, stream."""
        address = self.board.address
        kind = SkinType.TEMPERATURE_COMPENSATED
        last, cdc_offset = skin.TRIANGLES - 1, skin.DEFAULT_CDC_OFFSET
        return [
            (analog_setup.SET_BRD_CFG.request(address, kind, self.period_ms, NO_LOAD),),
            (analog_setup.SET_TRIANG_CFG.request(address, 0, last, SHIFT, ENABLED, cdc_offset),),
            (self._inertial_setting(INERTIAL if self._has_inertial else NO_INERTIAL),),
            (analog.SET_TXMODE.request(address, TxMode.CALIBRATED),),
        ]

    def forget(self) -> None:
        """Drop half triangles and a lone gyroscope frame."""
        self.skin.forget()
        self._gyro = None

    def take(self) -> list[SkinSample | InertialSample]:
        """Samples of skin and inertial sensors since the previous call, oldest first."""
        samples = list(self._samples)
        self._samples.clear()
        return samples

    def on_gyroscope(self, data: bytes, stamp_ns: int) -> None:
        """First half of an inertial sample."""
        if self._gyro is not None:
            self._faults.drop("gyroscope frame without its accelerometer frame")
        self._gyro = inertial.GYROSCOPE.parse(data)
        self._gyro_ns = stamp_ns
        if self._gyro is None:
            self._faults.drop("GYROSCOPE of wrong length")

    def on_accelerometer(self, data: bytes, stamp_ns: int) -> None:
        """Second half: the pair is a sample, if both arrived within one period."""
        gyro, self._gyro = self._gyro, None
        acceleration = inertial.ACCELEROMETER.parse(data)
        if acceleration is None:
            self._faults.drop("ACCELEROMETER of wrong length")
            return
        if gyro is None or stamp_ns - self._gyro_ns > INERTIAL_PERIOD_MS * MS:
            self._faults.drop("accelerometer frame without its gyroscope frame")
            return
        self._inertial_pulse.heard_ns = stamp_ns
        a, b, c = gyro
        x, y, z = acceleration
        self._samples.append(
            InertialSample(
                (a * RAD_S_PER_COUNT, b * RAD_S_PER_COUNT, c * RAD_S_PER_COUNT),
                (x * M_S2_PER_COUNT, y * M_S2_PER_COUNT, z * M_S2_PER_COUNT),
                stamp_ns,
            )
        )

    def _inertial_setting(self, mask: MtbSensor) -> Frame:
        address = self.board.address
        return analog_setup.ACC_GYRO_SETUP.request(address, mask, INERTIAL_PERIOD_MS)
