"""MAIS: the 15 Hall sensors of a hand (can-protocol 5.4).

Details that the fact sheet leaves open (frames of the 16-bit mode, test waves of the 12-bit mode,
commands without an answer, what every class 7 frame stops) are those of robotology/icub-firmware,
sensorReaderDspic30f4013/mais/source_code/main.c (commit 052098e7).
"""

from firmware_sim.boards.sensor_board import SensorBoard, parsed
from firmware_sim.description import BoardSpec
from hal.wire import analog, mais
from hal.wire.can import CLASS_ANALOG_PERIODIC, Frame, frame_id
from hal.wire.mais import Resolution
from hal.wire.management import BoardType

TOP_HALL = 255
WORD_SHIFT = 4  # the converter has 12 bits, a hall value eight
_ON, _OFF = 0, 1  # modes of SET_TXMODE; any other one stops the acquisition too
_SQUARE_FIRST = (0xFF, 0xFA, 0xF5, 0xF0, 0xEB, 0xE6, 0xE1)
_SQUARE_SECOND = (0x82, 0x7D, 0x78, 0x73, 0x6E, 0x69, 0x64)

ACKNOWLEDGED = frozenset(
    row.code
    for row in (
        analog.SET_TXMODE,
        analog.SET_CANDATARATE,
        analog.SET_RESOLUTION,
        analog.SAVE2EE,
        analog.SET_BOARD_ADX,
    )
)
UNAVAILABLE = frozenset(
    row.code
    for row in (
        analog.SET_IIR,
        analog.SET_MATRIX_RC,
        analog.GET_MATRIX_RC,
        analog.SET_CH_DAC,
        analog.GET_CH_DAC,
        analog.SELECT_ACTIVE_CH,
        analog.FILTER_EN,
        analog.MUX_EN,
        analog.MUX_NUM,
        analog.SET_MATRIX_G,
        analog.GET_MATRIX_G,
        analog.SET_CALIB_TARE,
        analog.GET_CALIB_TARE,
        analog.SET_CURR_TARE,
        analog.GET_CURR_TARE,
        analog.SET_FULL_SCALES,
        analog.GET_FULL_SCALES,
        analog.SET_SERIAL_NO,
        analog.GET_SERIAL_NO,
    )
)
"""Commands that MAIS knows and takes no notice of."""


class Mais(SensorBoard):
    """One MAIS; input `hall`: 15 values, 0 to 255."""

    board_type = BoardType.MAIS
    build = 2
    any_management_stops = True
    overflow = analog.RECEIVE_OVERFLOW

    def __init__(self, spec: BoardSpec) -> None:
        super().__init__(spec)
        self.hall = [0] * mais.SENSORS
        self._kept_period_ms = mais.DEFAULT_PERIOD_MS
        self.boot()

    def boot(self) -> None:
        """8 bits, and the period of the EEPROM."""
        self.period_ms = self._kept_period_ms
        self.resolution = Resolution.EIGHT_BITS
        self.sending = False
        self._elapsed_ms = 0
        self._wave = 0  # samples of the test that were sent

    def stop(self) -> None:
        """Stop until the next SET_TXMODE."""
        self.sending = False

    def answer(self, code: int, data: bytes) -> list[Frame]:
        """Every SET that it heeds is acknowledged with an empty frame."""
        if code == analog.GET_FW_VERSION.code:
            return self.handshake(parsed(analog.GET_FW_VERSION, data))
        if code == analog.GET_CH_ADC.code:
            return self._tell_hall(*parsed(analog.GET_CH_ADC, data))
        if code in UNAVAILABLE:
            self.dropped["unavailable"] += 1
            return []
        if code not in ACKNOWLEDGED:
            return [analog.unknown_command(self._address, code)]
        argument = data[1] if len(data) > 1 else 0
        if code == analog.SET_TXMODE.code:
            self.sending = argument == _ON
            self._elapsed_ms = 0
        elif code == analog.SET_CANDATARATE.code:
            self.period_ms = max(argument, 1)
        elif code == analog.SET_RESOLUTION.code and argument in list(Resolution):
            self.resolution = Resolution(argument)
        elif code == analog.SAVE2EE.code:
            self._kept_period_ms = self.period_ms
        elif code == analog.SET_BOARD_ADX.code and not 1 <= argument <= 15:
            return []
        return [analog.ack(self._address)]

    def sample(self, sent: list[Frame]) -> None:
        """Send a sample each period."""
        if not self.sending:
            return
        self._elapsed_ms += 1
        if self._elapsed_ms < self.period_ms:
            return
        self._elapsed_ms = 0
        address = self._address
        if self.resolution == Resolution.EIGHT_BITS:
            hall = [min(max(value, 0), TOP_HALL) for value in self.hall]
            sent.append(mais.HALL_0_6.frame(address, *hall[: mais.FIRST]))
            sent.append(mais.HALL_7_14.frame(address, *hall[mais.FIRST :]))
        elif self.resolution == Resolution.SIXTEEN_BITS:
            words = [self._word(value) for value in self.hall]
            for first, message in zip((0, 4, 8, 12), mais.WORD_MESSAGES.values(), strict=True):
                sent.append(message.frame(address, *words[first : first + 4]))
        else:
            self._send_waves(sent)

    def _send_waves(self, sent: list[Frame]) -> None:
        """Square waves and a ramp, 8 bytes in each of the two frames of the 8-bit mode."""
        self._wave += 1
        flip = 0xFF if self._wave & 1 else 0
        ramp = self._wave % TOP_HALL
        for message, squares in (
            (mais.HALL_0_6, _SQUARE_FIRST),
            (mais.HALL_7_14, _SQUARE_SECOND),
        ):
            can_id = frame_id(CLASS_ANALOG_PERIODIC, self._address, message.type)
            sent.append((can_id, bytes((*(value ^ flip for value in squares), ramp))))

    def _tell_hall(self, channel: int, _calibrated: int) -> list[Frame]:
        # Four bytes, not STRAIN's five: there is no kind of reading to name.
        if channel >= mais.SENSORS:
            return [analog.ack(self._address)]
        word = self._word(self.hall[channel])
        head = bytes((analog.GET_CH_ADC.code, channel))
        return [(analog.reply_id(self._address), head + word.to_bytes(2, "big"))]

    def _word(self, value: int) -> int:
        return min(max(value, 0), TOP_HALL) << WORD_SHIFT
