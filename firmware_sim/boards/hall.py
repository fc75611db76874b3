"""Hand boards read the fingers' Hall sensors from the MAIS frames on their bus (can-protocol 5.4).

A joint's position is a sum of Hall bytes. The encoder of its motor counts beside it: calibration 4
gives those counts a zero and two limits, which SET_MIN_MOTOR_POS and SET_MAX_MOTOR_POS change.
"""

from firmware_sim.boards.axis_state import Axis
from firmware_sim.boards.modes import CALIB_INCREMENTAL, POSITION
from hal.wire.can import CLASS_ANALOG_PERIODIC, frame_id
from hal.wire.mais import FIRST, HALL_0_6, HALL_7_14, SENSORS

MAIS_ADDRESS = 14
WATCHDOG_MS = 100
UNLIMITED_COUNTS = 0x7FFF_FFFF
_FIRST_ID = frame_id(CLASS_ANALOG_PERIODIC, MAIS_ADDRESS, HALL_0_6.type)
_SECOND_ID = frame_id(CLASS_ANALOG_PERIODIC, MAIS_ADDRESS, HALL_7_14.type)


class Tendon:
    """One axis whose position is Hall bytes and whose motor counts beside it.

    The limits of those counts are kept as raw ones, where the bridge looks at them.
    """

    __slots__ = ("_zero", "axis", "hall", "target")

    def __init__(self, axis: Axis) -> None:
        self.axis = axis
        self.hall = axis.wiring.hall
        self.boot()

    def boot(self) -> None:
        """State at power-up: the motor may go where it likes."""
        self._zero = self.axis.port.raw_encoder
        self.target = 0  # p3 of the calibration that runs

    def set_low(self, counts: int) -> None:
        """Lower limit of the motor's counts, from where calibration put their zero."""
        self.axis.motor_low = self._zero + counts

    def set_high(self, counts: int) -> None:
        """Upper limit of the motor's counts."""
        self.axis.motor_high = self._zero + counts

    def begin_calibration(self, target: int) -> None:
        """Type 4 begins: no limits until it ends."""
        self.set_low(-UNLIMITED_COUNTS)
        self.set_high(UNLIMITED_COUNTS)
        self.target = target

    def end_calibration(self) -> None:
        """Type 4 has come to the end of its trajectory.

        The motor's counts begin here and run from p3 to the firmware's fixed limit.
        """
        self._zero = self.axis.port.raw_encoder
        opposite = self.axis.wiring.opposite_limit
        if self.target >= 0:
            self.set_low(opposite)
            self.set_high(self.target)
        else:
            self.set_low(self.target)
            self.set_high(-opposite)
        self.axis.enter(POSITION)
        self.axis.calibrated = True


class HallLink:
    """The MAIS as a hand board hears it."""

    __slots__ = ("_values", "silent_ms", "tendons")

    def __init__(self, axes: tuple[Axis, ...]) -> None:
        self.tendons = {id(axis): Tendon(axis) for axis in axes if axis.wiring.hall}
        self.boot()

    def boot(self) -> None:
        """Nothing heard yet."""
        self._values = [0] * SENSORS
        self.silent_ms = 0
        for tendon in self.tendons.values():
            tendon.boot()

    def of(self, axis: Axis) -> Tendon | None:
        """The tendon of an axis, None when its position comes from an encoder."""
        return self.tendons.get(id(axis))

    def on_frame(self, can_id: int, data: bytes) -> bool | None:
        """Take a MAIS frame in; False when its length is wrong, None when it is another's."""
        if can_id == _FIRST_ID:
            values = HALL_0_6.parse(data)
            place = slice(0, FIRST)
        elif can_id == _SECOND_ID:
            values = HALL_7_14.parse(data)
            place = slice(FIRST, SENSORS)
        else:
            return None
        if values is None:
            return False
        self._values[place] = values
        self.silent_ms = 0
        for tendon in self.tendons.values():
            tendon.axis.hall_ticks = sum(self._values[one] for one in tendon.hall)
        return True

    def advance(self) -> None:
        """One millisecond: the watchdog, and calibrations that have come to their end."""
        if self.silent_ms < WATCHDOG_MS:
            self.silent_ms += 1
        for tendon in self.tendons.values():
            axis = tendon.axis
            if axis.mode == CALIB_INCREMENTAL and not axis.reference.active:
                tendon.end_calibration()

    @property
    def silent(self) -> bool:
        """True when no MAIS frame came for 100 ms."""
        return self.silent_ms >= WATCHDOG_MS
