"""The emulated robot: boards on their buses, wired to the drives and sensors of one plant.

One `step` is one millisecond, in this order: frames of the buses reach the boards; encoders,
current sensors and gauges are read; every board runs its loop; the plant moves under the new PWM.
"""

import math
from collections.abc import Mapping, Sequence
from math import floor

import numpy as np
from numpy.typing import NDArray

from firmware_sim.boards.board import Board
from firmware_sim.description import AxisSpec, RigSpec
from firmware_sim.limits import LimitCounter
from firmware_sim.network import Network, RigError
from firmware_sim.plants.rigid import STEP_S, RigidPlant
from firmware_sim.transducer import Transducer
from hal.wire.can import Frame, Received

Vector = NDArray[np.float64]
Vector3 = tuple[float, float, float]

ENCODER_MASK = 0xFFF  # absolute encoders: 12 bits a turn
NO_MASK = -1  # incremental encoders count on
FULL_PWM_COUNTS = {"bll_ie": 800, "dc4": 1333}  # 100 % of the supply (can-protocol 9.3)
MA_PER_A = 1000.0


class Rig:
    """Boards, plant and sensors of one robot, and the truth about them."""

    def __init__(self, spec: RigSpec) -> None:
        self._network = Network(spec.boards, spec.sensors)
        for axis in spec.axes:
            self._network.axis(axis).port.raw_encoder = _counts(axis)
            self.board(axis.bus, axis.address).power_cycle()  # wakes where the joint stands
        moved = [axis for axis in spec.axes if axis.joint is not None]
        self._axes = [self._network.axis(axis) for axis in moved]
        self._every_axis = self._network.axes()
        self._ports = [axis.port for axis in self._axes]
        self._encoders = [_encoder(axis) for axis in moved]
        self.plant = RigidPlant(
            spec.plant, moved, spec.sensors, [self._full_pwm(axis) for axis in moved]
        )
        self.joints = self.plant.joints
        self._gauges = [
            (self.board(sensor.bus, sensor.address), Transducer(sensor, spec.plant.seed, index))
            for index, sensor in enumerate(spec.sensors)
        ]
        self._limits = LimitCounter([axis.limit_deg for axis in moved])
        self._push_n: Vector = np.zeros(3)
        self._push_ticks = 0

    def step(self, received: Mapping[int, Sequence[Received]]) -> dict[int, list[Frame]]:
        """Run one millisecond: frames that arrived on each bus in, frames sent on each bus out."""
        self._network.deliver(received)
        self._read_sensors()
        sent = self._network.tick()
        self._move()
        angles = self.plant.q_rad.tolist()
        if self._limits.waiting:
            calibrated = [axis.calibrated for axis in self._axes]
            self._limits.admit(angles, self.plant.dq_rad_s.tolist(), calibrated)
        self._limits.step(angles)
        return sent

    def push(self, force_n: Sequence[float], duration_s: float) -> None:
        """Push the tip's origin with a force (3, N, base frame) from the next step on.

        Raises:
            RigError: a value is not finite, or the duration is not positive.
        """
        if not (math.isfinite(sum(force_n)) and math.isfinite(duration_s) and duration_s > 0.0):
            raise RigError(f"cannot push with {tuple(force_n)} N for {duration_s} s")
        self._push_n = np.array(force_n, dtype=np.float64)
        self._push_ticks = max(1, round(duration_s / STEP_S))

    def board(self, bus: int, address: int) -> Board:
        """The board that owns an address.

        Raises:
            RigError: there is none.
        """
        return self._network.board(bus, address)

    @property
    def q_rad(self) -> tuple[float, ...]:
        """True joint angles, in the order of `joints`."""
        return tuple(self.plant.q_rad.tolist())

    @property
    def dq_rad_s(self) -> tuple[float, ...]:
        """True joint speeds."""
        return tuple(self.plant.dq_rad_s.tolist())

    @property
    def motor_torque_nm(self) -> tuple[float, ...]:
        """Torques that the motors exert on the joints, before friction."""
        return tuple(self.plant.motor_torque_nm().tolist())

    @property
    def limit_violations(self) -> int:
        """Ticks, summed over the joints, in which one was outside its limits (see limits.py)."""
        return sum(self._limits.ticks)

    @property
    def board_faults(self) -> int:
        """Times that an axis of any board went into hardware fault."""
        return sum(axis.fault_entries for axis in self._every_axis)

    def tip_pose(self) -> tuple[Vector3, Vector3]:
        """True position (m) and rotation vector (rad) of the tip frame in the base frame."""
        (x, y, z), (a, b, c) = (part.tolist() for part in self.plant.tip_pose())
        return (x, y, z), (a, b, c)

    def _full_pwm(self, axis: AxisSpec) -> int:
        board_type = self._network.board_type(axis)
        if axis.motor is None or board_type not in FULL_PWM_COUNTS:
            raise RigError(f"{axis.joint} has no motor, or {board_type} is no motor board")
        return FULL_PWM_COUNTS[board_type]

    def _read_sensors(self) -> None:
        angles = self.plant.q_rad.tolist()
        currents = self.plant.current_a().tolist()
        for port, (per_rad, zero, offset, mask), angle, current in zip(
            self._ports, self._encoders, angles, currents, strict=True
        ):
            port.raw_encoder = floor(angle * per_rad + zero) + offset & mask
            port.current_ma = int(current * MA_PER_A)
        for (board, gauge), wrench in zip(self._gauges, self.plant.wrenches, strict=True):
            board.raw_adc[:] = gauge.words(wrench)

    def _move(self) -> None:
        pwm = [port.pwm if port.enabled else 0 for port in self._ports]
        enabled = tuple([port.enabled for port in self._ports])
        if self._push_ticks:
            self._push_ticks -= 1
            self.plant.step_pushed(pwm, enabled, self._push_n)
        else:
            self.plant.step(pwm, enabled)


def _encoder(axis: AxisSpec) -> tuple[float, float, int, int]:
    """Ticks per radian, ticks at zero radians, ticks added, and the mask of the encoder's width."""
    per_rad = math.degrees(axis.ticks_per_deg)
    # Half a tick: whoever calibrated zero_deg centred it, so that readings err to both sides alike.
    zero = axis.zero_deg * axis.ticks_per_deg + 0.5
    if axis.absolute_offset is not None:
        return per_rad, zero, axis.absolute_offset, ENCODER_MASK
    at_power_up = floor(math.radians(axis.start_deg) * per_rad + zero)
    return per_rad, zero, -at_power_up, NO_MASK


def _counts(axis: AxisSpec) -> int:
    """What the axis's encoder shows at power-up."""
    per_rad, zero, offset, mask = _encoder(axis)
    return floor(math.radians(axis.start_deg) * per_rad + zero) + offset & mask
