"""Polled commands of a STRAIN (can-protocol 5.1): every SET is acknowledged, every GET answered."""

from collections.abc import Callable
from enum import Enum
from typing import Protocol

from firmware_sim.boards.strain_calibration import Eeprom, calibrated_values, calibrated_words
from hal.wire import analog
from hal.wire.management import BoardType

BUILD = 5
PROTOCOL = (1, 0)


class Answer(Enum):
    """What a command leads to when it has no reply of its own."""

    ACKNOWLEDGED = "an empty frame"
    UNKNOWN = "BUG"


class Sensor(Protocol):
    """The board, as commands see it."""

    version: tuple[int, int]
    raw_adc: list[int]
    memory: Eeprom
    eeprom: Eeprom
    mode: int
    elapsed_ms: int


Values = tuple[int, ...]
Outcome = Values | Answer
Handler = Callable[[Sensor, Values], Outcome]


def answer(sensor: Sensor, code: int, request: Values) -> Outcome:
    """Act on a request of the right length."""
    handler = _HANDLERS.get(code)
    if handler is None:
        return Answer.UNKNOWN
    try:
        return handler(sensor, request)
    except IndexError:  # a channel, row or column that the sensor does not have
        return Answer.ACKNOWLEDGED


def _acknowledge(_sensor: Sensor, _request: Values) -> Outcome:
    """Test and filter commands: nothing that an emulated sensor shows depends on them."""
    return Answer.ACKNOWLEDGED


def _set_mode(sensor: Sensor, request: Values) -> Outcome:
    sensor.mode = request[0]
    sensor.elapsed_ms = 0
    return Answer.ACKNOWLEDGED


def _set_period(sensor: Sensor, request: Values) -> Outcome:
    sensor.memory.period_ms = max(request[0], 1)
    return Answer.ACKNOWLEDGED


def _save(sensor: Sensor, _request: Values) -> Outcome:
    sensor.eeprom = sensor.memory.copy()
    return (1,)


def _get_eeprom_status(sensor: Sensor, _request: Values) -> Outcome:
    return (int(sensor.memory.copy() == sensor.eeprom),)


def _set_matrix(sensor: Sensor, request: Values) -> Outcome:
    row, column, value = request
    sensor.memory.matrix[row][column] = value
    return Answer.ACKNOWLEDGED


def _get_matrix(sensor: Sensor, request: Values) -> Outcome:
    row, column = request
    return row, column, sensor.memory.matrix[row][column]


def _set_gain(sensor: Sensor, request: Values) -> Outcome:
    sensor.memory.gain = request[0]
    return Answer.ACKNOWLEDGED


def _get_gain(sensor: Sensor, _request: Values) -> Outcome:
    return (sensor.memory.gain,)


def _set_dac(sensor: Sensor, request: Values) -> Outcome:
    channel, word = request
    sensor.memory.dac[channel] = word
    return Answer.ACKNOWLEDGED


def _get_dac(sensor: Sensor, request: Values) -> Outcome:
    return request[0], sensor.memory.dac[request[0]]


def _get_adc(sensor: Sensor, request: Values) -> Outcome:
    channel, calibrated = request
    raw = sensor.raw_adc
    words = calibrated_words(sensor.memory, raw) if calibrated else raw
    return channel, calibrated, words[channel]


def _set_calibration_tare(sensor: Sensor, request: Values) -> Outcome:
    present = [analog.ZERO_WORD - word for word in sensor.raw_adc]
    return _set_tare(sensor.memory.calibration_tare, present, request)


def _set_present_tare(sensor: Sensor, request: Values) -> Outcome:
    present = [-value for value in calibrated_values(sensor.memory, sensor.raw_adc)]
    return _set_tare(sensor.memory.present_tare, present, request)


def _set_tare(tare: list[int], present: list[int], request: Values) -> Outcome:
    mode, channel, value = request
    if mode == analog.TareMode.CLEAR:
        tare[:] = [0] * analog.CHANNELS
    elif mode == analog.TareMode.PRESENT:
        tare[:] = [max(-0x8000, min(0x7FFF, each)) for each in present]
    elif mode == analog.TareMode.VALUE:
        tare[channel] = value
    return Answer.ACKNOWLEDGED


def _get_calibration_tare(sensor: Sensor, request: Values) -> Outcome:
    return request[0], sensor.memory.calibration_tare[request[0]]


def _get_present_tare(sensor: Sensor, request: Values) -> Outcome:
    return request[0], sensor.memory.present_tare[request[0]]


def _set_full_scale(sensor: Sensor, request: Values) -> Outcome:
    channel, value = request
    sensor.memory.full_scale[channel] = value
    return Answer.ACKNOWLEDGED


def _get_full_scale(sensor: Sensor, request: Values) -> Outcome:
    return request[0], sensor.memory.full_scale[request[0]]


def _set_serial(sensor: Sensor, request: Values) -> Outcome:
    sensor.memory.serial = bytes(request)
    return Answer.ACKNOWLEDGED


def _get_serial(sensor: Sensor, _request: Values) -> Outcome:
    return tuple(sensor.memory.serial)


def _handshake(sensor: Sensor, request: Values) -> Outcome:
    accepted = int(request == PROTOCOL)
    return int(BoardType.STRAIN), *sensor.version, BUILD, *PROTOCOL, accepted


_HANDLERS: dict[int, Handler] = {
    command.code: handler
    for command, handler in (
        (analog.SET_IIR, _acknowledge),
        (analog.SET_MATRIX_RC, _set_matrix),
        (analog.GET_MATRIX_RC, _get_matrix),
        (analog.SET_CH_DAC, _set_dac),
        (analog.GET_CH_DAC, _get_dac),
        (analog.SELECT_ACTIVE_CH, _acknowledge),
        (analog.SET_TXMODE, _set_mode),
        (analog.SET_CANDATARATE, _set_period),
        (analog.SAVE2EE, _save),
        (analog.GET_CH_ADC, _get_adc),
        (analog.FILTER_EN, _acknowledge),
        (analog.MUX_EN, _acknowledge),
        (analog.MUX_NUM, _acknowledge),
        (analog.SET_MATRIX_G, _set_gain),
        (analog.GET_MATRIX_G, _get_gain),
        (analog.SET_CALIB_TARE, _set_calibration_tare),
        (analog.GET_CALIB_TARE, _get_calibration_tare),
        (analog.SET_CURR_TARE, _set_present_tare),
        (analog.GET_CURR_TARE, _get_present_tare),
        (analog.SET_FULL_SCALES, _set_full_scale),
        (analog.GET_FULL_SCALES, _get_full_scale),
        (analog.SET_SERIAL_NO, _set_serial),
        (analog.GET_SERIAL_NO, _get_serial),
        (analog.GET_EEPROM_STATUS, _get_eeprom_status),
        (analog.GET_FW_VERSION, _handshake),
        (analog.SET_BOARD_ADX, _acknowledge),
    )
}
