"""STRAIN2: STRAIN's frames without its acknowledgements, three calibration sets, IMU, thermometer.

The high half of a channel byte names the regulation set: 0 the one in use, 1 to 3 (can-protocol
5.1). Settings are not acknowledged, an unknown command gets no answer, nothing is sent at boot.
"""

from collections.abc import Sequence

from firmware_sim.boards.amplifiers import Amplifiers
from firmware_sim.boards.inertial_unit import AtRest, InertialUnit
from firmware_sim.boards.sensor_board import parsed
from firmware_sim.boards.strain import Strain
from firmware_sim.boards.strain_calibration import Eeprom, is_factory
from firmware_sim.boards.strain_commands import Answer, answer
from firmware_sim.boards.thermometer import Thermometer
from firmware_sim.description import BoardSpec
from hal.wire import analog, analog_setup
from hal.wire.analog_setup import RegulationMode
from hal.wire.can import Frame
from hal.wire.management import BoardType
from hal.wire.message import Command

SETS = 3
_SET_PLACE = {  # which value of a request, and of its reply, carries the regulation set
    analog.SET_MATRIX_RC.code: 0,
    analog.GET_MATRIX_RC.code: 0,
    analog.SET_CH_DAC.code: 0,
    analog.GET_CH_DAC.code: 0,
    analog.SET_CALIB_TARE.code: 1,
    analog.GET_CALIB_TARE.code: 0,
    analog.SET_FULL_SCALES.code: 0,
    analog.GET_FULL_SCALES.code: 0,
}
_GETS_WITH_SET = frozenset(
    (
        analog.GET_MATRIX_RC.code,
        analog.GET_CH_DAC.code,
        analog.GET_CALIB_TARE.code,
        analog.GET_FULL_SCALES.code,
    )
)


class Strain2(Strain):
    """One STRAIN2; inputs as of STRAIN, `motion` (see Motion) and `temperature_degc`."""

    board_type = BoardType.STRAIN2
    build = 0
    overflow = None

    def __init__(self, spec: BoardSpec, full_scale: Sequence[float]) -> None:
        """`full_scale` in N, N, N, Nm, Nm, Nm; all three sets have them at first."""
        self.motion = AtRest()
        self.imu = InertialUnit(spec.address, self.motion)
        self.thermometer = Thermometer(spec.address)
        self.amplifiers = Amplifiers(spec.address, SETS)
        self._permanent = 0
        self._kept: list[Eeprom] = []
        super().__init__(spec, full_scale)

    @property
    def temperature_degc(self) -> float:
        """What the thermometer feels."""
        return self.thermometer.temperature_degc

    @temperature_degc.setter
    def temperature_degc(self, value: float) -> None:
        self.thermometer.temperature_degc = value

    def boot(self) -> None:
        """Take every set from the EEPROM, and use the permanent one."""
        if not self._kept:
            self._kept = [self.eeprom.copy() for _ in range(SETS)]
        self.sets = [kept.copy() for kept in self._kept]
        self.eeprom = self._kept[self._permanent]
        super().boot()
        self.memory = self.sets[self._permanent]
        self.in_use = self._permanent
        self.imu.boot()
        self.thermometer.boot()
        self.amplifiers.boot()

    def stop(self) -> None:
        """Stop every stream."""
        super().stop()
        self.imu.stop()
        self.thermometer.stop()

    def wake(self) -> list[Frame]:
        """Nothing is sent at boot."""
        return []

    def answer(self, code: int, data: bytes) -> list[Frame]:
        """Look for whom a command is: set in use, IMU, thermometer, amplifiers, the sensor."""
        if code == analog_setup.REGULATIONSET_SET.code:
            self._use(*parsed(analog_setup.REGULATIONSET_SET, data))
            return []
        if code == analog_setup.REGULATIONSET_GET.code:
            return self._tell_set(*parsed(analog_setup.REGULATIONSET_GET, data))
        if code == analog.GET_FW_VERSION.code:
            return self.handshake(parsed(analog.GET_FW_VERSION, data))
        for part in (self.imu.answer, self.thermometer.answer):
            frames = part(code, data)
            if frames is not None:
                return frames
        frames = self.amplifiers.answer(code, data, self.in_use)
        return self._sensor(code, data) if frames is None else frames

    def reply(self, row: Command, outcome: tuple[int, ...] | Answer) -> list[Frame]:
        """Only a GET is answered."""
        if isinstance(outcome, Answer):
            if outcome is Answer.UNKNOWN:
                self.dropped["unknown"] += 1
            return []
        return [row.reply(self._address, *outcome)]

    def sample(self, sent: list[Frame]) -> None:
        """Send what is due of the sensor, the IMU and the thermometer."""
        super().sample(sent)
        self.imu.tick(sent)
        self.thermometer.tick(sent)

    def _sensor(self, code: int, data: bytes) -> list[Frame]:
        row = analog.COMMANDS.get(code)
        if row is None:
            self.dropped["unknown"] += 1
            return []
        values = list(row.parse_request(data) or ())
        chosen, place = 0, _SET_PLACE.get(code)
        if place is not None:
            chosen, values[place] = values[place] >> 4, values[place] & 0xF
        if chosen > SETS:
            self.dropped["regulation set"] += 1
            return []
        in_use = self.memory
        if chosen:
            self.memory = self.sets[chosen - 1]
        outcome = answer(self, code, tuple(values))
        self.memory = in_use
        if code == analog.SAVE2EE.code:
            self._kept = [memory.copy() for memory in self.sets]
            self.eeprom = self._kept[self._permanent]
            self.amplifiers.save()
        elif code == analog.GET_EEPROM_STATUS.code:
            outcome = (int([memory.copy() for memory in self.sets] == self._kept),)
        self.factory = is_factory(self.memory)
        if chosen and code in _GETS_WITH_SET and not isinstance(outcome, Answer):
            outcome = (outcome[0] | chosen << 4, *outcome[1:])
        return self.reply(row, outcome)

    def _use(self, set_mode: int) -> None:
        chosen, mode = set_mode >> 4, set_mode & 0xF
        if chosen > SETS:
            self.dropped["regulation set"] += 1
            return
        index = self.in_use if chosen == 0 else chosen - 1
        self.in_use = index
        self.memory = self.sets[index]
        self.factory = is_factory(self.memory)
        if mode == RegulationMode.PERMANENT:
            self._permanent = index

    def _tell_set(self, mode: int) -> list[Frame]:
        index = self._permanent if mode == RegulationMode.PERMANENT else self.in_use
        values = index + 1 << 4 | mode & 0xF
        return [analog_setup.REGULATIONSET_GET.reply(self._address, values)]
