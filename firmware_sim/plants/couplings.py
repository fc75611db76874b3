"""How the motors and encoders of all boards hang on the joints (can-protocol 9.4).

The firmware says what it takes its motors for, and that is how they are built in here: the motor
that is fed a * u0 + b * u1 turns by a * q0 + b * q1, and pulls both joints in the same proportion.
A differential halves the sum of two duties, so that neither joint alone can ask for more than full
PWM; its motors turn by the whole sum. With S the matrix of motor speeds over joint speeds,

    motor speed = S dq        joint torque = S' motor torque        rotors at the joints: S' J S

The matrices are in the sense of the PWM: a joint counts as its polarity says, so that one matrix
serves both arms. What a board's encoders show is the inverse of its firmware's read-out, in ticks.
"""

import math
from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from firmware_sim.boards.hardware import Coupling, Firmware
from firmware_sim.description import AxisSpec

Vector = NDArray[np.float64]
Matrix = NDArray[np.float64]


class CoupledBoard(NamedTuple):
    """A board's coupling, and the address of the board whose duties and positions it adds."""

    coupling: Coupling
    addresses: tuple[int, ...]
    partner: int | None


def coupled_board(
    firmware: Firmware, addresses: tuple[int, ...], first: AxisSpec | None
) -> CoupledBoard:
    """What `firmware` couples; `first` is the board's axis 0, whose gain tells a thumb's hand."""
    coupling = firmware.coupling
    if firmware.thumb is not None and first is not None:
        coupling = firmware.thumb[first.pwm_polarity * first.ticks_per_deg > 0.0]
    partner = None if firmware.partner is None else firmware.partner.address
    return CoupledBoard(coupling, addresses, partner)


class Readout(NamedTuple):
    """Ticks of the encoders: per_rad @ joint angles + level."""

    per_rad: Matrix
    level: Vector


def motor_speeds(axes: Sequence[AxisSpec], boards: Sequence[CoupledBoard | None]) -> Matrix:
    """Speed of each motor (row, sense of its PWM) per speed of each axis's joint (column).

    `boards` has the board of each axis; None where every motor turns its own joint.
    """
    own, partner = _columns(axes, boards)
    S: Matrix = np.zeros((len(axes), len(axes)))
    for i, (axis, board) in enumerate(zip(axes, boards, strict=True)):
        if board is None:
            S[i, i] = axis.pwm_polarity
            continue
        row = board.coupling.motors[_index(axis, board)]
        added = board.coupling.partner_motors[_index(axis, board)]
        largest = max(abs(share) for share in (*row, *added))
        whole = 1.0 / min(largest, 1.0)
        for columns, shares in ((own[i], row), (partner[i], added)):
            for j, share in enumerate(shares):
                if j in columns:
                    S[i, columns[j]] = whole * share * axes[columns[j]].pwm_polarity
    return _in_degrees(S, axes, boards)


def encoder_readout(axes: Sequence[AxisSpec], boards: Sequence[CoupledBoard | None]) -> Readout:
    """What the encoders behind each axis show, before offset and width."""
    own, partner = _columns(axes, boards)
    per_rad: Matrix = np.zeros((len(axes), len(axes)))
    level: Vector = np.zeros(len(axes))
    for i, (axis, board) in enumerate(zip(axes, boards, strict=True)):
        shares = {i: 1.0} if board is None else _encoder_shares(axis, board, own[i], partner[i])
        for j, share in shares.items():
            per_rad[i, j] = share * math.degrees(axes[j].ticks_per_deg)
            level[i] += share * axes[j].zero_deg * axes[j].ticks_per_deg
    return Readout(per_rad, level)


def _encoder_shares(
    axis: AxisSpec, board: CoupledBoard, own: Mapping[int, int], partner: Mapping[int, int]
) -> dict[int, float]:
    """Ticks of an axis's encoder as a sum over the ticks of joints."""
    inverse = np.linalg.inv(np.array(board.coupling.encoders))[_index(axis, board)]
    shares: dict[int, float] = {}
    for j, share in enumerate(inverse.tolist()):
        if share == 0.0:
            continue
        if j in own:
            shares[own[j]] = share
        for k, added in enumerate(board.coupling.partner_positions[j]):
            if added and k in partner:
                shares[partner[k]] = -share * added
    return shares


def _in_degrees(
    S: Matrix, axes: Sequence[AxisSpec], boards: Sequence[CoupledBoard | None]
) -> Matrix:
    """Matrices of boards with encoders on their motors add ticks: make them add angles.

    The eyes' version has twice the ticks of their vergence, so that each eye's own encoder counts
    as the vergence does: an eye turns by the version and half the vergence.
    """
    for i, board in enumerate(boards):
        if board is None or board.coupling.encoders == _unit(len(board.coupling.encoders)):
            continue
        joints = np.flatnonzero(S[i]).tolist()
        densest = max(abs(axes[j].ticks_per_deg) for j in joints)
        for j in joints:
            S[i, j] *= abs(axes[j].ticks_per_deg) / densest
    return S


def _unit(axes: int) -> tuple[tuple[float, ...], ...]:
    return tuple(tuple(float(row == column) for column in range(axes)) for row in range(axes))


def _index(axis: AxisSpec, board: CoupledBoard) -> int:
    return board.addresses.index(axis.address) * 2 + axis.axis


def _columns(
    axes: Sequence[AxisSpec], boards: Sequence[CoupledBoard | None]
) -> tuple[list[dict[int, int]], list[dict[int, int]]]:
    """Per axis, where the joints of its board and of the partner stand, by axis of the board."""
    at = {(axis.bus, axis.address, axis.axis): i for i, axis in enumerate(axes)}
    own, partner = [], []
    for axis, board in zip(axes, boards, strict=True):
        addresses = () if board is None else board.addresses
        beside = () if board is None or board.partner is None else (board.partner,)
        own.append(_found(at, axis.bus, addresses))
        partner.append(_found(at, axis.bus, beside))
    return own, partner


def _found(
    at: Mapping[tuple[int, int, int], int], bus: int, addresses: Sequence[int]
) -> dict[int, int]:
    wires = [(address, axis) for address in addresses for axis in (0, 1)]
    return {
        k: at[bus, address, axis]
        for k, (address, axis) in enumerate(wires)
        if (bus, address, axis) in at
    }
