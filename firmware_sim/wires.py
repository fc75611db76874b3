"""The wires between motor boards and plant: encoders and currents in, duties and bridges out."""

import math
from collections.abc import Mapping, Sequence
from math import floor

import numpy as np
from numpy.typing import NDArray

from firmware_sim.boards.axis_state import Axis
from firmware_sim.boards.bank import AxisBank
from firmware_sim.boards.fields import CALIBRATED
from firmware_sim.description import AxisSpec
from firmware_sim.motor import Switches
from firmware_sim.plants import kernel
from firmware_sim.plants.couplings import Readout
from firmware_sim.plants.plant import Plant

Vector = NDArray[np.float64]
Matrix = NDArray[np.float64]
Ticks = NDArray[np.int64]

ENCODER_MASK = 0xFFF  # absolute encoders: 12 bits a turn
NO_MASK = -1  # incremental encoders count on


class Gauges:
    """What encoders and current sensors of all axes show."""

    def __init__(self, axes: Sequence[AxisSpec], readout: Readout, plant: Plant) -> None:
        """Incremental encoders count from where the plant stands now, at power-up."""
        self._plant = plant
        places = np.nonzero(readout.per_rad)
        self._sights = np.array(places, dtype=np.int64)
        self._per_rad: Vector = readout.per_rad[places]
        # Half a tick: whoever calibrated zero_deg centred it: readings err to both sides alike.
        self._level: Vector = readout.level + 0.5
        self._width: Ticks = np.zeros((2, len(axes)), dtype=np.int64)  # added, and mask
        self._width[1] = NO_MASK
        self._shown: Ticks = np.zeros((2, len(axes)), dtype=np.int64)
        at_power_up = self.read()[0].copy()
        for i, axis in enumerate(axes):
            if axis.absolute_offset is None:
                self._width[0, i] = -at_power_up[i]
            else:
                self._width[:, i] = axis.absolute_offset, ENCODER_MASK

    def read(self) -> Ticks:
        """Two rows: ticks of every encoder, milliamperes of every motor."""
        plant, drives = self._plant, self._plant.drives
        kernel.show(
            plant.state,
            plant.constants,
            drives.links,
            drives.shares,
            self._sights,
            self._per_rad,
            self._level,
            self._width,
            self._shown,
        )
        return self._shown


class Wires:
    """The wires of some axes: most are rows of a bank, those of foreign boards are objects."""

    def __init__(
        self, bank: AxisBank, rows: Mapping[int, int], foreign: Mapping[int, Axis], axes: int
    ) -> None:
        """`rows` and `foreign` have the axis's number, one of `axes`, as their key."""
        self._bank = bank
        self._at = np.array(list(rows), dtype=np.intp)
        self._rows = np.array(list(rows.values()), dtype=np.intp)
        self._foreign = foreign
        self._calibrated: Switches = np.zeros(axes, dtype=np.bool_)
        self._pwm: Vector = np.zeros(axes)
        self._enabled: Switches = np.zeros(axes, dtype=np.bool_)

    def show(self, shown: Ticks) -> None:
        """Set what encoders (first row) and current sensors (second) read."""
        counts, milliamperes = shown
        self._bank.raw_encoder[self._rows] = counts[self._at]
        self._bank.current_ma[self._rows] = milliamperes[self._at]
        for i, axis in self._foreign.items():
            axis.port.raw_encoder = int(counts[i])
            axis.port.current_ma = int(milliamperes[i])

    def command(self) -> tuple[Vector, Switches]:
        """PWM counts of the motors, zero where the bridge is off, and which bridges are on."""
        pwm, enabled = self._pwm, self._enabled
        pwm[self._at] = self._bank.port_pwm[self._rows]
        enabled[self._at] = self._bank.port_enabled[self._rows]
        for i, axis in self._foreign.items():
            pwm[i], enabled[i] = axis.port.pwm, axis.port.enabled
        pwm *= enabled
        return pwm, enabled

    def calibrated(self) -> Switches:
        """Axes that their boards call calibrated."""
        calibrated = self._calibrated
        calibrated[self._at] = self._bank.rows[self._rows, CALIBRATED]
        for i, axis in self._foreign.items():
            calibrated[i] = axis.calibrated
        return calibrated


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
