"""Torque set-points of a shoulder whose motors turn several joints at once.

The firmware mixes the duties that its axes want into those of three motors, and each motor pulls
all the joints that it turns (can-protocol 9.4; the counterpart for torques exists in the firmware
but is disabled). With S the motor speeds per joint speed, T the mixing of duties and K the torque
per duty of each motor, the joints get S' K T u where their loops ask for u. A loop asks for kff
tau + kp (tau - measured): its feed-forward is right for no more than one joint by itself. So where
u ought to be, the set-points are bent such that the loops ask for just that:

    (kp + kff) sent = (S' K T)^-1 tau + kp tau

Without this, a limb that floats against gravity coasts away: nothing but feed-forward holds it.
"""

from collections.abc import Sequence
from typing import Final

import numpy as np
from numpy.typing import NDArray

from hal.axis import Axis
from hal.couplings import board_axis
from hal.description import Board

Matrix = NDArray[np.float64]

UPPER, LOWER = 0x50, 0x57  # firmwares of the shoulder's boards
RATIO: Final = 1.6455
JOINTS = 3
# Motor speeds per joint speed, in the sense of the PWM. The third motor's board adds the duties
# that are applied to the other two.
SPEEDS: Matrix = np.array([[1.0, 0.0, 0.0], [-RATIO, RATIO, 0.0], [-RATIO, RATIO, RATIO]])
DUTIES: Matrix = np.array(
    [[1.0, 0.0, 0.0], [-RATIO, RATIO, 0.0], [-RATIO - RATIO**2, RATIO**2, RATIO]]
)


class Shoulder:
    """Pitch, roll and yaw of one arm. `joints` are their places in the robot description."""

    def __init__(self, axes: Sequence[Axis]) -> None:
        """`axes` in that order, each with torque gains and a known motor."""
        self.joints = tuple(axis.index for axis in axes)
        self._axes = tuple(axes)
        self._joints = tuple(axis.joint for axis in axes)
        self._map = self._made()

    def bent(self, tau_nm: Sequence[float]) -> list[float]:
        """Set-points (3, Nm) under which the drives exert these torques (3, Nm)."""
        joints = tuple(axis.joint for axis in self._axes)
        if any(now is not before for now, before in zip(joints, self._joints, strict=True)):
            self._joints = joints  # gains were tuned
            self._map = self._made()
        sent: list[float] = (self._map @ np.array(tau_nm)).tolist()
        return sent

    def _made(self) -> Matrix:
        kp, kff, nm_per_count, sense = (np.zeros(JOINTS) for _ in range(4))
        for i, axis in enumerate(self._axes):
            pid = axis.joint.torque_pid
            assert pid is not None, "is_known has been asked"
            scale = axis.units.torque_counts_per_nm / 2.0**pid.shift
            kp[i], kff[i] = pid.kp * scale, pid.kff * scale
            nm_per_count[i] = axis.joint.motor_nm / axis.full_pwm
            sense[i] = np.sign(pid.kp)
        if not (kp.all() and (kp + kff).all()):  # tuned to nothing: no set-point means anything
            return np.eye(JOINTS)
        inverse = np.linalg.inv(SPEEDS.T @ np.diag(nm_per_count) @ DUTIES)
        wanted: Matrix = inverse * sense + np.diag(kp)
        made: Matrix = wanted / (kp + kff)[:, None]
        return made


def shoulders(boards: Sequence[tuple[Board, Sequence[Axis]]]) -> tuple[Shoulder, ...]:
    """Those of the robot whose motors are coupled and known."""
    found = []
    for board, axes in boards:
        if board.firmware[1] != UPPER or not board.coupled:
            continue
        for other, lower in boards:
            if other.bus == board.bus and other.firmware[1] == LOWER and other.coupled:
                placed = {board_axis(board, axis): axis for axis in axes}
                placed |= {2 + board_axis(other, axis): axis for axis in lower}
                three = [placed[i] for i in range(JOINTS) if i in placed]
                if len(three) == JOINTS and all(map(is_known, three)):
                    found.append(Shoulder(three))
    return tuple(found)


def is_known(axis: Axis) -> bool:
    """Whether the description says how the torque loop and the motor of an axis work."""
    pid, joint = axis.joint.torque_pid, axis.joint
    return pid is not None and pid.kp != 0 and joint.motor_nm > 0.0
