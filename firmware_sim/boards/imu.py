"""The head's IMU as a class 5 board: IMU commands and frames of STRAIN2, nothing else.

DELIBERATE: the head IMU of a CAN iCub is an XSens on a serial port (can-protocol 11.1). This board
stands in for it and reports the type of RFE, a board of the head that carries the same BNO055.
"""

from firmware_sim.boards.inertial_unit import AtRest, InertialUnit
from firmware_sim.boards.sensor_board import SensorBoard, parsed
from firmware_sim.description import BoardSpec
from hal.wire import analog
from hal.wire.can import Frame
from hal.wire.management import BoardType


class Imu(SensorBoard):
    """One IMU board.

    Inputs in the sensor's axes: `acceleration_m_s2`, `gyro_deg_s`, `magnetic_ut`, `quaternion` (w,
    x, y, z, from sensor to earth).
    """

    board_type = BoardType.RFE
    build = 0

    def __init__(self, spec: BoardSpec) -> None:
        super().__init__(spec)
        at_rest = AtRest()
        self.acceleration_m_s2 = at_rest.acceleration_m_s2
        self.gyro_deg_s = at_rest.gyro_deg_s
        self.magnetic_ut = at_rest.magnetic_ut
        self.quaternion = at_rest.quaternion
        self.unit = InertialUnit(spec.address, self)

    def boot(self) -> None:
        """Nothing is configured."""
        self.unit.boot()

    def stop(self) -> None:
        """Stop until the next IMU_TRANSMIT."""
        self.unit.stop()

    def answer(self, code: int, data: bytes) -> list[Frame]:
        """Settings are not acknowledged; an unknown command gets no answer."""
        if code == analog.GET_FW_VERSION.code:
            return self.handshake(parsed(analog.GET_FW_VERSION, data))
        frames = self.unit.answer(code, data)
        if frames is None:
            self.dropped["unknown"] += 1
            return []
        return frames

    def sample(self, sent: list[Frame]) -> None:
        """Send an acquisition each period."""
        self.unit.tick(sent)
