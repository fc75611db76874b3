"""MTB: skin board with accelerometer and gyroscope (can-protocol 7.1, 7.3).

No command is acknowledged; an unknown one gets no answer.
DELIBERATE: the firmware sends all triangles in one burst at the end of a period; here they are
spread over it, as they are on a bus that seven boards share.
"""

from firmware_sim.boards.sensor_board import SensorBoard, Values, parsed
from firmware_sim.boards.skin_patch import PAUSE_PERIODS, REST, SkinPatch
from firmware_sim.description import BoardSpec
from hal.wire import analog, analog_setup, inertial, skin
from hal.wire.analog_setup import MtbSensor
from hal.wire.can import CLASS_ANALOG_PERIODIC, CLASS_SKIN_PERIODIC, Frame
from hal.wire.management import BoardType
from hal.wire.numbers import saturate_i16

_ON = 0  # mode of SET_TXMODE that starts the skin
ANALOG_COUNTS_PER_G = 16000.0  # DELIBERATE: assumed as the digital one's; no source tells it
_DIGITAL = MtbSensor.INTERNAL_ACCELEROMETER | MtbSensor.EXTERNAL_ACCELEROMETER


class Mtb(SensorBoard):
    """One MTB.

    Inputs: `taxels` (192; 240 untouched, less under pressure), `triangle_errors` (16), `gyro_deg_s`
    and `acceleration_g`, three floats each in the sensors' axes.
    """

    board_type = BoardType.SKIN
    build = 0
    overflow = skin.RECEIVE_OVERFLOW

    def __init__(self, spec: BoardSpec) -> None:
        super().__init__(spec)
        self.taxels = [REST] * skin.BOARD_TAXELS
        self.triangle_errors: list[int] = [skin.TriangleError.OK] * skin.TRIANGLES
        self.gyro_deg_s = [0.0, 0.0, 0.0]
        self.acceleration_g = [0.0, 0.0, 1.0]
        self.patch = SkinPatch(spec.address, self)
        self.boot()

    def boot(self) -> None:
        """Skin and inertial sensors are silent."""
        self.patch.boot()
        self._set_period(skin.DEFAULT_PERIOD_MS)
        self.stop()

    def stop(self) -> None:
        """Stop skin and inertial sensors."""
        self.sending = False
        self.inertial_mask = 0
        self._ms = -1
        self._pause_ms = 0
        self._inertial_period_ms = 0
        self._inertial_ms = 0

    def answer(self, code: int, data: bytes) -> list[Frame]:
        """Take a set-up; only the handshake is answered."""
        if code == analog.GET_FW_VERSION.code:
            return self.handshake(parsed(analog.GET_FW_VERSION, data))
        if code == analog.SET_TXMODE.code:
            (mode,) = parsed(analog.SET_TXMODE, data)
            self.sending = mode == _ON
            self._ms = -1
        elif code == analog_setup.ACC_GYRO_SETUP.code:
            self.inertial_mask, self._inertial_period_ms = parsed(analog_setup.ACC_GYRO_SETUP, data)
            self._inertial_ms = 0
        elif code == analog_setup.SET_BRD_CFG.code:
            _, period_ms, no_load = parsed(analog_setup.SET_BRD_CFG, data)
            self._set_period(period_ms)
            self.patch.set_up(CLASS_SKIN_PERIODIC, no_load)
        elif code == analog_setup.SET_TRIANG_CFG.code:
            self.patch.set_triangles(*parsed(analog_setup.SET_TRIANG_CFG, data))
        elif code in (analog_setup.TACT_SETUP.code, analog_setup.TACT_SETUP2.code):
            self._set_up_old_style(code, data)
        elif code != analog.SET_BOARD_ADX.code:  # DELIBERATE: the address stays, as of STRAIN
            self.dropped["unknown"] += 1
        return []

    def sample(self, sent: list[Frame]) -> None:
        """Send the triangles and the inertial readings whose time has come."""
        if self.sending:
            if self._pause_ms:
                self._pause_ms -= 1
            else:
                self._ms += 1
                if self._ms >= self.period_ms:
                    self._ms = 0
                for triangle in self._slots[self._ms]:
                    self._read(triangle, sent)
        if self.inertial_mask and self._inertial_period_ms:
            self._inertial_ms += 1
            if self._inertial_ms >= self._inertial_period_ms:
                self._inertial_ms = 0
                self._feel(sent)

    def _read(self, triangle: int, sent: list[Frame]) -> None:
        patch = self.patch
        sent += patch.pair(triangle)
        if patch.must_recalibrate(triangle):
            patch.recalibrate()
            self._pause_ms = PAUSE_PERIODS * self.period_ms

    def _feel(self, sent: list[Frame]) -> None:
        address, mask = self._address, self.inertial_mask
        if mask & MtbSensor.EXTERNAL_GYROSCOPE:
            counts = _counts(self.gyro_deg_s, inertial.MTB_COUNTS_PER_DEG_S)
            sent.append(inertial.GYROSCOPE.frame(address, *counts))
        if mask & _DIGITAL:
            counts = _counts(self.acceleration_g, inertial.MTB_COUNTS_PER_G)
            sent.append(inertial.ACCELEROMETER.frame(address, *counts))
        if mask & MtbSensor.ANALOG_ACCELEROMETER:
            counts = _counts(self.acceleration_g, ANALOG_COUNTS_PER_G)
            sent.append(inertial.ANALOG_ACCELEROMETER.frame(address, *counts))

    def _set_period(self, period_ms: int) -> None:
        self.period_ms = period_ms or skin.DEFAULT_PERIOD_MS
        self._slots: list[list[int]] = [[] for _ in range(self.period_ms)]
        # Boards of one bus are never in step: the address shifts them against each other.
        for triangle in range(skin.TRIANGLES):
            slot = triangle * self.period_ms // skin.TRIANGLES + self._address
            self._slots[slot % self.period_ms].append(triangle)
        self._ms = -1

    def _set_up_old_style(self, code: int, data: bytes) -> None:
        """DELIBERATE: the time fields are kept at the default period: their unit is unknown."""
        no_load = self.patch.no_load
        if code == analog_setup.TACT_SETUP2.code:
            shift, _, no_load, _, enable, _ = parsed(analog_setup.TACT_SETUP2, data)
            self.patch.set_old_triangles(enable, shift)
        self.patch.set_up(CLASS_ANALOG_PERIODIC, no_load)


def _counts(values: list[float], scale: float) -> Values:
    return tuple(saturate_i16(value * scale) for value in values)
