"""Host side of STRAIN2: STRAIN's force and torque, and a thermometer.

Its IMU stays off: the frames would come at the identifiers of an IMU board, and nobody reads them.
"""

from collections.abc import Iterable

from hal.boards.board import Parts
from hal.boards.sensor import Group
from hal.boards.strain import Strain
from hal.line import Handler
from hal.wire import analog, analog_setup
from hal.wire.can import CLASS_ANALOG_PERIODIC, Frame, frame_id
from hal.wire.management import BoardType

THERMOMETER = 1  # the mask of the one sensor
THERMOMETER_PERIOD_S = 5
DEGC_PER_COUNT = 0.1


class Strain2(Strain):
    """One sensor; `temperature_degc` is None until it was told."""

    type_code = BoardType.STRAIN2
    overflow = None

    def __init__(self, parts: Parts) -> None:
        super().__init__(parts)
        self.temperature_degc: float | None = None

    def handlers(self) -> Iterable[tuple[int, Handler]]:
        """Force, torque and temperature."""
        kind = analog.THERMOMETER.type
        can_id = frame_id(CLASS_ANALOG_PERIODIC, self.board.address, kind)
        return [*super().handlers(), (can_id, self.on_temperature)]

    def quiesce(self) -> Iterable[Frame]:
        """Stop every stream."""
        address = self.board.address
        return [
            *super().quiesce(),
            analog_setup.IMU_TRANSMIT.request(address, 0),
            analog_setup.THERMOMETER_TRANSMIT.request(address, 0),
        ]

    def settings(self) -> Iterable[Group]:
        """Thermometer, rate and stream."""
        address = self.board.address
        return [
            (
                analog_setup.THERMOMETER_CONFIG_SET.request(address, THERMOMETER),
                analog_setup.THERMOMETER_TRANSMIT.request(address, THERMOMETER_PERIOD_S),
            ),
            *super().settings(),
        ]

    def on_temperature(self, data: bytes, stamp_ns: int) -> None:  # noqa: ARG002  (a handler)
        """A reading of the first thermometer."""
        values = analog.THERMOMETER.parse(data)
        if values is None:
            self._faults.drop("THERMOMETER of wrong length")
        elif values[0] & THERMOMETER:
            self.temperature_degc = values[1] * DEGC_PER_COUNT
