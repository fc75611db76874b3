"""The wires between motor boards and plant: encoders and currents in, duties and bridges out."""

import math
from collections.abc import Mapping, Sequence
from math import floor

import numpy as np
from numpy.typing import NDArray

from firmware_sim.boards.axis import AxisPort
from firmware_sim.boards.bank import AxisBank
from firmware_sim.description import AxisSpec
from firmware_sim.motor import Switches
from firmware_sim.plants.couplings import Readout

Vector = NDArray[np.float64]
Matrix = NDArray[np.float64]
Ticks = NDArray[np.int64]

ENCODER_MASK = 0xFFF  # absolute encoders: 12 bits a turn
NO_MASK = -1  # incremental encoders count on
MA_PER_A = 1000.0


class Encoders:
    """What the encoders of n axes show."""

    def __init__(self, axes: Sequence[AxisSpec], readout: Readout, start_rad: Vector) -> None:
        """Incremental encoders count from `start_rad`, the axes' coordinates at power-up."""
        self._per_rad = np.ascontiguousarray(readout.per_rad)
        # Half a tick: whoever calibrated zero_deg centred it: readings err to both sides alike.
        self._level = readout.level + 0.5
        n = len(axes)
        self._added: Ticks = np.zeros(n, dtype=np.int64)
        self._mask: Ticks = np.full(n, NO_MASK, dtype=np.int64)
        at_power_up = self.read(start_rad)
        for i, axis in enumerate(axes):
            if axis.absolute_offset is None:
                self._added[i] = -at_power_up[i]
            else:
                self._added[i], self._mask[i] = axis.absolute_offset, ENCODER_MASK

    def read(self, x_rad: Vector) -> Ticks:
        """Ticks of every encoder."""
        ticks = self._per_rad @ x_rad
        ticks += self._level
        np.floor(ticks, out=ticks)
        counts: Ticks = ticks.astype(np.int64)
        counts += self._added
        counts &= self._mask
        return counts


class Wires:
    """The wires of some axes. Most boards keep theirs in a bank; one that does not has ports."""

    def __init__(
        self, bank: AxisBank, rows: Mapping[int, int], ports: Mapping[int, AxisPort], axes: int
    ) -> None:
        """`rows` and `ports` have the axis's number, one of `axes`, as their key."""
        self._bank = bank
        self._at = np.array(list(rows), dtype=np.intp)
        self._rows = np.array(list(rows.values()), dtype=np.intp)
        self._ports = ports
        self._pwm: Vector = np.zeros(axes)
        self._enabled: Switches = np.zeros(axes, dtype=np.bool_)

    def show(self, counts: Ticks, current_a: Vector) -> None:
        """Set what encoders and current sensors read."""
        milliamperes = (current_a * MA_PER_A).astype(np.int64)
        self._bank.raw_encoder[self._rows] = counts[self._at]
        self._bank.current_ma[self._rows] = milliamperes[self._at]
        for i, port in self._ports.items():
            port.raw_encoder = int(counts[i])
            port.current_ma = int(milliamperes[i])

    def command(self) -> tuple[Vector, Switches]:
        """PWM counts of the motors, zero where the bridge is off, and which bridges are on."""
        pwm, enabled = self._pwm, self._enabled
        pwm[self._at] = self._bank.port_pwm[self._rows]
        enabled[self._at] = self._bank.port_enabled[self._rows]
        for i, port in self._ports.items():
            pwm[i], enabled[i] = port.pwm, port.enabled
        pwm *= enabled
        return pwm, enabled


def resting_counts(axis: AxisSpec) -> int:
    """What the encoder of an axis shows that turns nothing in this plant."""
    if axis.absolute_offset is None:
        return 0
    ticks = (axis.start_deg + axis.zero_deg) * axis.ticks_per_deg
    return floor(ticks + 0.5) + axis.absolute_offset & ENCODER_MASK


def with_motor_encoders(
    readout: Readout, axes: Sequence[AxisSpec], motor_speeds: Matrix
) -> Readout:
    """Tendon axes have their encoder on the motor: it counts what the motor winds."""
    for i, axis in enumerate(axes):
        if axis.mechanism == "tendon":
            per_rad = math.degrees(axis.motor_ticks_per_deg) * axis.pwm_polarity
            readout.per_rad[i] = motor_speeds[i] * per_rad
            readout.level[i] = 0.0
    return readout
