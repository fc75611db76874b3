"""What the sensor boards feel of the plant: gauges, Hall sensors, accelerometers, gyroscopes, skin.

Gauges and Hall sensors are read every millisecond; inertial sensors every tenth.
"""

import numpy as np
from numpy.typing import NDArray

from firmware_sim.boards.board import Board
from firmware_sim.boards.imu import Imu
from firmware_sim.boards.inertial_unit import Motion
from firmware_sim.boards.mais import Mais
from firmware_sim.boards.mtb import Mtb
from firmware_sim.boards.strain2 import Strain2
from firmware_sim.description import RigSpec
from firmware_sim.network import Network, RigError
from firmware_sim.plants.plant import Plant
from firmware_sim.transducer import Transducers
from hal.wire import skin

Matrix = NDArray[np.float64]

INERTIAL_PERIOD_MS = 10
G_M_S2 = 9.80665
EARTH_UT = np.array([22.0, 0.0, -42.0])  # assumed: x of the base is north, at 45 degrees latitude
IMU_FROM_GAUGES = np.array([[0.0, -1.0, 0.0], [-1.0, 0.0, 0.0], [0.0, 0.0, -1.0]])  # STRAIN2, 7.2
AS_THE_FRAME = np.eye(3)
TAXELS_OF_TRIANGLE = 12
UNTOUCHED = 240  # and 0 under full pressure


class Senses:
    """The sensor boards of a robot, wired to its plant."""

    def __init__(self, spec: RigSpec, network: Network, plant: Plant) -> None:
        self._plant = plant
        self._gauges = Transducers(spec.sensors, spec.plant.seed)
        self._strain = [network.board(sensor.bus, sensor.address) for sensor in spec.sensors]
        halls = {b.bus: network.board(b.bus, b.address) for b in spec.boards if b.type == "mais"}
        self._halls = [
            (board, channel) if isinstance(board := halls.get(bus), Mais) else None
            for bus, channel in plant.mechanisms.halls.places
        ]
        self._feels_hands = any(place is not None for place in self._halls)
        placed = [
            (board, frame, turn)
            for board, frame, turn in _inertial(spec, network)
            if isinstance(board, (Mtb, Imu, Strain2))
        ]
        self._inertial = [board for board, _, _ in placed]
        self._turns = [turn for _, _, turn in placed]
        self._points = plant.rigid.inertial_points([frame for _, frame, _ in placed])
        self._ms = 0

    def feel(self) -> None:
        """Set the inputs of the sensor boards for this millisecond."""
        for board, words in zip(
            self._strain, self._gauges.words(self._plant.wrenches), strict=True
        ):
            board.raw_adc[:] = words
        if self._feels_hands:
            for place, value in zip(
                self._halls, self._plant.mechanisms.hall_bytes(self._plant.pull_nm), strict=True
            ):
                if place is not None:
                    board, channel = place
                    board.hall[channel] = value
        if self._inertial and self._ms % INERTIAL_PERIOD_MS == 0:
            self._feel_motion()
        self._ms += 1

    def _feel_motion(self) -> None:
        forces, turns = self._points.read()
        for i, (board, mounted) in enumerate(zip(self._inertial, self._turns, strict=True)):
            force, gyro_deg_s = mounted @ forces[i], np.degrees(mounted @ turns[i])
            if isinstance(board, Mtb):
                board.acceleration_g = (force / G_M_S2).tolist()
                board.gyro_deg_s = gyro_deg_s.tolist()
                continue
            motion: Motion = board.motion if isinstance(board, Strain2) else board
            to_base, quaternion = self._points.orientation(i, mounted)
            motion.acceleration_m_s2 = force.tolist()
            motion.gyro_deg_s = gyro_deg_s.tolist()
            motion.magnetic_ut = (to_base.T @ EARTH_UT).tolist()
            motion.quaternion = quaternion


def touch(board: Board, triangle: int, pressure: float) -> None:
    """Press all taxels of a triangle: 0 lets go, 1 is as hard as it can feel.

    Raises:
        RigError: the board has no skin, or no such triangle, or the pressure is outside 0 to 1.
    """
    if not isinstance(board, Mtb):
        raise RigError(f"the board at address {board.addresses[0]} has no skin")
    if not (0 <= triangle < skin.TRIANGLES and 0.0 <= pressure <= 1.0):
        raise RigError(f"cannot touch triangle {triangle} with a pressure of {pressure}")
    first = triangle * TAXELS_OF_TRIANGLE
    level = round(UNTOUCHED * (1.0 - pressure))
    board.taxels[first : first + TAXELS_OF_TRIANGLE] = [level] * TAXELS_OF_TRIANGLE


def _inertial(spec: RigSpec, network: Network) -> list[tuple[Board, str, Matrix]]:
    """Boards that feel motion, the frame they sit in and how they are mounted there."""
    placed = [
        (network.board(board.bus, board.address), board.frame, AS_THE_FRAME)
        for board in spec.boards
        if board.frame
    ]
    return placed + [
        (network.board(sensor.bus, sensor.address), sensor.frame, IMU_FROM_GAUGES)
        for sensor in spec.sensors
    ]
