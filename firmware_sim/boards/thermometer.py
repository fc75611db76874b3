"""The thermometer of STRAIN2: one sensor, a frame each so many seconds (can-protocol 5.1, 5.2)."""

from hal.wire import analog, analog_setup
from hal.wire.can import Frame
from hal.wire.numbers import saturate_i16

MS_PER_S = 1000
PER_DEGC = 10


class Thermometer:
    """Bit 0 of the mask is the one sensor that there is."""

    def __init__(self, address: int) -> None:
        self.temperature_degc = 25.0
        self._address = address
        self.boot()

    def boot(self) -> None:
        """Nothing is configured."""
        self.mask = 0
        self.stop()

    def stop(self) -> None:
        """Send nothing until the next THERMOMETER_TRANSMIT."""
        self._period_ms = 0
        self._elapsed_ms = 0

    def answer(self, code: int, data: bytes) -> list[Frame] | None:
        """Act on a command; None when it is none of the thermometer's."""
        if code == analog_setup.THERMOMETER_CONFIG_SET.code:
            self.stop()
            (self.mask,) = analog_setup.THERMOMETER_CONFIG_SET.parse_request(data) or (0,)
        elif code == analog_setup.THERMOMETER_CONFIG_GET.code:
            return [analog_setup.THERMOMETER_CONFIG_GET.reply(self._address, self.mask)]
        elif code == analog_setup.THERMOMETER_TRANSMIT.code:
            self.stop()
            (period_s,) = analog_setup.THERMOMETER_TRANSMIT.parse_request(data) or (0,)
            self._period_ms = period_s * MS_PER_S
        else:
            return None
        return []

    def tick(self, sent: list[Frame]) -> None:
        """Append a frame when its time has come."""
        if not (self._period_ms and self.mask & 1):
            return
        self._elapsed_ms += 1
        if self._elapsed_ms >= self._period_ms:
            self._elapsed_ms = 0
            reading = saturate_i16(self.temperature_degc * PER_DEGC)
            sent.append(analog.THERMOMETER.frame(self._address, 1, reading, 0))
