"""The emulated robot: boards on their buses, wired to the drives and sensors of one plant.

One `step` is one millisecond, in this order: frames of the buses reach the boards; encoders,
current sensors and the sensor boards are read; every board runs its loop; the plant moves under the
new PWM.
"""

import math
from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from firmware_sim.boards.board import Board
from firmware_sim.boards.motor_board import MotorBoard
from firmware_sim.description import AxisSpec, RigSpec
from firmware_sim.limits import LimitCounter
from firmware_sim.network import Network, RigError
from firmware_sim.plants.couplings import (
    CoupledBoard,
    coupled_board,
    encoder_readout,
    motor_speeds,
)
from firmware_sim.plants.plant import Plant
from firmware_sim.pushes import Pushes
from firmware_sim.senses import Senses, touch
from firmware_sim.switches import Switches
from firmware_sim.wires import Gauges, Wires, resting_counts, with_motor_encoders
from hal.wire.can import Frame, Received

Vector = NDArray[np.float64]
Vector3 = tuple[float, float, float]

FULL_PWM_COUNTS = {"bll": 1333, "bll_ie": 800, "bll_dc": 800, "dc4": 1333}
"""100 % of the supply (can-protocol 9.3)."""


class Rig:
    """Boards, plant and sensors of one robot, and the truth about them."""

    def __init__(self, spec: RigSpec) -> None:
        self._network = Network(spec.boards, spec.sensors)
        self.switches = Switches(self._network, sorted({board.bus for board in spec.boards}))
        moved = [axis for axis in spec.axes if axis.joint is not None]
        boards = [_coupling(axis, spec.axes, self._network) for axis in moved]
        speeds = motor_speeds(moved, boards)
        full_pwm = [self._full_pwm(axis) for axis in moved]
        self.plant = Plant(spec.plant, moved, spec.sensors, full_pwm, speeds)
        self.joints = self.plant.joints
        readout = with_motor_encoders(encoder_readout(moved, boards), moved, speeds)
        self._gauges = Gauges(moved, readout, self.plant)
        own = [(i, axis) for i, axis in enumerate(moved) if not axis.driven]
        self._own = np.array([i for i, _ in own], dtype=np.intp)
        self._every_axis = self._network.axes()
        self._wires = self._wire(own, len(moved))
        self._senses = Senses(spec, self._network, self.plant)
        self._limits = LimitCounter([axis.limit_deg for _, axis in own])
        self._pushes = Pushes(self.plant.rigid, spec.plant.tip_frame)
        self._wake(spec)

    def step(self, received: Mapping[int, Sequence[Received]]) -> dict[int, list[Frame]]:
        """Run one millisecond: frames that arrived on each bus in, frames sent on each bus out."""
        switches = self.switches
        if switches.active:
            received = switches.before(received)
        self._network.deliver(received)
        if self.plant.driven.buses:
            self.plant.driven.listen(received)
        self._wires.show(self._gauges.read())
        self._senses.feel()
        if switches.active:
            switches.hold()
        sent = self._network.tick()
        if switches.active:
            sent = switches.after(sent)
        self._move()
        self._watch_limits()
        return sent

    def push(
        self,
        force_n: Sequence[float],
        duration_s: float,
        frame: str = "",
        point_m: Sequence[float] = (0.0, 0.0, 0.0),
    ) -> None:
        """Push with a force (3, N, base frame) from the next step on.

        Args:
            force_n: the force; it ends what still pushes at the same frame.
            duration_s: for how long.
            frame: a link or joint of the URDF, the tip where it is empty.
            point_m: where, in the axes of that frame.

        Raises:
            RigError: a value is not finite, the duration not positive, or the frame not there.
        """
        self._pushes.begin(force_n, duration_s, frame, point_m)

    def touch(self, bus: int, address: int, triangle: int, pressure: float) -> None:
        """Press a triangle of the skin: 0 lets go, 1 is as hard as it can feel.

        Raises:
            RigError: there is no such triangle, or the pressure is outside 0 to 1.
        """
        touch(self.board(bus, address), triangle, pressure)

    def grasp(self, finger: str, angle_deg: float | None) -> None:
        """Put something into a hand that one finger joint cannot close beyond; None takes it away.

        Raises:
            RigError: there is no such finger joint.
        """
        tendons = self.plant.mechanisms.tendons
        known = [spec.name for spec in tendons.fingers]
        if finger not in known:
            raise RigError(f"no finger joint {finger!r}; there are {', '.join(known) or 'none'}")
        tendons.block(finger, None if angle_deg is None else math.radians(angle_deg))

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
    def limits_waiting(self) -> tuple[str, ...]:
        """Joints that are not yet held to their limits; driven ones never are."""
        return tuple(self.joints[self._own[k]] for k in self._limits.waiting)

    @property
    def board_faults(self) -> int:
        """Times that an axis of any board went into hardware fault."""
        return sum(axis.fault_entries for axis in self._every_axis)

    def tip_pose(self) -> tuple[Vector3, Vector3]:
        """True position (m) and rotation vector (rad) of the tip frame in the base frame."""
        (x, y, z), (a, b, c) = (part.tolist() for part in self.plant.tip_pose())
        return (x, y, z), (a, b, c)

    def _wire(self, own: Sequence[tuple[int, AxisSpec]], axes: int) -> Wires:
        rows, foreign = {}, {}
        for i, axis in own:
            if isinstance(self.board(axis.bus, axis.address), MotorBoard):
                rows[i] = self._network.row(axis)
            else:
                foreign[i] = self._network.axis(axis)
        return Wires(self._network.bank, rows, foreign, axes)

    def _wake(self, spec: RigSpec) -> None:
        """Let the boards boot where the joints stand."""
        for axis in spec.axes:
            if axis.joint is None:
                self._network.axis(axis).port.raw_encoder = resting_counts(axis)
        self._wires.show(self._gauges.read())
        for axis in spec.axes:
            if not axis.driven:
                self.board(axis.bus, axis.address).power_cycle()

    def _full_pwm(self, axis: AxisSpec) -> int:
        if axis.driven:
            return 1  # of no use: its motor is elsewhere
        board_type = self._network.board_type(axis)
        if axis.motor is None or board_type not in FULL_PWM_COUNTS:
            raise RigError(f"{axis.joint} has no motor, or {board_type} is no motor board")
        return FULL_PWM_COUNTS[board_type]

    def _move(self) -> None:
        pwm, enabled = self._wires.command()
        self.plant.step(pwm, enabled, self._pushes.step())

    def _watch_limits(self) -> None:
        angles = self.plant.q_rad
        if len(self._own) < len(angles):
            angles = angles[self._own]
        if not self._limits.all_held:
            self._limits.admit(angles, self._wires.calibrated()[self._own])
        self._limits.step(angles)


def _coupling(axis: AxisSpec, axes: Sequence[AxisSpec], network: Network) -> CoupledBoard | None:
    """What the firmware of an axis's board couples; None for a board elsewhere."""
    if axis.driven:
        return None
    board = network.board(axis.bus, axis.address)
    if not isinstance(board, MotorBoard):
        return None
    place = (axis.bus, board.addresses[0], 0)
    first = next((a for a in axes if (a.bus, a.address, a.axis) == place), None)
    return coupled_board(board.firmware, board.addresses, first)
