"""The six programmable amplifiers (PGA308) in front of a STRAIN2's converter.

DELIBERATE: settings are kept and told, but the words of the gauges do not depend on them, and an
automatic offset calibration reports success: the rig hands over the words behind the amplifiers.
"""

from hal.wire import analog_setup
from hal.wire.analog import CHANNELS
from hal.wire.can import Frame
from hal.wire.message import Command

ALL_CHANNELS = 15
EVERY_CHANNEL_OK = (1 << CHANNELS) - 1

Values = tuple[int, ...]

GAIN, OFFSET = 1600, 0x8000  # defaults: 16.00, half scale
GAIN_RANGE = (800, 3200)  # DELIBERATE: assumed, the amplifier's fine gain spans a factor of four
OFFSET_RANGE = (0, 0xFFFF)
CONFIGURATION: Values = (0x8000, 0x44, 0x00, 0x8000)  # fine gain, gains, coarse offset, zero DAC


class Amplifiers:
    """Gain, offset and registers per regulation set and channel."""

    def __init__(self, address: int, sets: int) -> None:
        self._address = address
        self._kept = _factory(sets)
        self.boot()

    def boot(self) -> None:
        """Take what the EEPROM has."""
        self._settings = [list(row) for row in self._kept]

    def save(self) -> None:
        """Write the EEPROM."""
        self._kept = [list(row) for row in self._settings]

    def answer(self, code: int, data: bytes, in_use: int) -> list[Frame] | None:
        """Act on a command; None when it is none of the amplifiers'."""
        row = _ROWS.get(code)
        if row is None:
            return None
        values = row.parse_request(data) or ()
        chosen, channel = values[0] >> 4, values[0] & 0xF
        index = chosen - 1 if chosen else in_use
        if index >= len(self._settings) or (channel >= CHANNELS and channel != ALL_CHANNELS):
            return []
        if row is analog_setup.AMPLIFIER_OFFSET_AUTOCALIB:
            result = (0, EVERY_CHANNEL_OK, EVERY_CHANNEL_OK, 0, 0)
            return [row.reply(self._address, values[0], *result)]
        if row.reply_layout is None:
            channels = range(CHANNELS) if channel == ALL_CHANNELS else (channel,)
            for each in channels:
                self._settings[index][each] = _changed(row, self._settings[index][each], values)
            return []
        if channel == ALL_CHANNELS:
            return []
        told = _told(row, self._settings[index][channel])
        return [row.reply(self._address, values[0], *told)]


def _factory(sets: int) -> list[list[Values]]:
    return [[(GAIN, OFFSET, *CONFIGURATION)] * CHANNELS for _ in range(sets)]


def _changed(row: Command, setting: Values, request: Values) -> Values:
    if row is analog_setup.AMPLIFIER_PGA308_CFG1_SET:
        return (*setting[:2], *request[1:])
    if row is analog_setup.AMPLIFIER_GAINOFFSET_SET and not request[1]:
        return (*request[2:], *setting[2:])
    return (GAIN, OFFSET, *CONFIGURATION)  # a reset, or the default asked for


def _told(row: Command, setting: Values) -> Values:
    if row is analog_setup.AMPLIFIER_RANGE_OF_GAIN_GET:
        return GAIN_RANGE
    if row is analog_setup.AMPLIFIER_RANGE_OF_OFFSET_GET:
        return OFFSET_RANGE
    return setting[:2] if row is analog_setup.AMPLIFIER_GAINOFFSET_GET else setting[2:]


_ROWS: dict[int, Command] = {
    row.code: row
    for row in (
        analog_setup.AMPLIFIER_RESET,
        analog_setup.AMPLIFIER_RANGE_OF_GAIN_GET,
        analog_setup.AMPLIFIER_RANGE_OF_OFFSET_GET,
        analog_setup.AMPLIFIER_GAINOFFSET_GET,
        analog_setup.AMPLIFIER_GAINOFFSET_SET,
        analog_setup.AMPLIFIER_OFFSET_AUTOCALIB,
        analog_setup.AMPLIFIER_PGA308_CFG1_GET,
        analog_setup.AMPLIFIER_PGA308_CFG1_SET,
    )
}
