"""Random states of a bank, gains and references at the ends of their words.

They run compiled, and in an interpreter without a compiler on integers of any size: see
test_kernel.py.
"""

import json
import sys

import numpy as np

from firmware_sim.boards import fields as f
from firmware_sim.boards import modes
from firmware_sim.boards.bank import AxisBank
from firmware_sim.boards.view import Row

BOARDS = (2, 4)  # axes
TICKS = 400
COMMAND_PERIOD = 8  # ticks between commands

Range = tuple[int, int]
I16: Range = (-0x8000, 0x7FFF)
I32: Range = (-0x8000_0000, 0x7FFF_FFFF)
U8: Range = (0, 0xFF)
SETTINGS: dict[int, Range] = {
    **{
        pid + gain: I16
        for pid in (f.POSITION_PID, f.TORQUE_PID)
        for gain in (f.KP, f.KD, f.KI, f.OFFSET, f.INTEGRAL_LIMIT, f.OUTPUT_LIMIT)
    },
    f.POSITION_PID + f.SHIFT: (0, 31),
    f.TORQUE_PID + f.SHIFT: (0, 31),
    **dict.fromkeys((f.STIFFNESS, f.DAMPING, f.IMPEDANCE_OFFSET, f.KFF, f.BEMF), I16),
    **dict.fromkeys((f.STICTION_UP, f.STICTION_DOWN), I16),
    **dict.fromkeys((f.TORQUE_STICTION_UP, f.TORQUE_STICTION_DOWN), I16),
    **dict.fromkeys((f.OPENLOOP_PWM, f.VELOCITY_TARGET, f.ACCELERATION), I16),
    **dict.fromkeys((f.BEMF_SHIFT, f.SPEED_SHIFT), U8),
    **dict.fromkeys((f.DESIRED_TORQUE, f.LOW, f.HIGH, f.REFERENCE, f.ENCODER_OFFSET), I32),
    f.VELOCITY_SHIFT: (0, 16),
    f.VELOCITY_TIMEOUT: I16,
    f.DUTY_LIMIT: (0, 1333),
    f.CURRENT_LIMIT_MA: (1, 7000),
    f.FILTER: (0, 3),
}
"""What commands may write, and how far."""

INPUTS: dict[int, tuple[Range, float, Range]] = {
    f.RAW_ENCODER: ((-3000, 3000), 0.1, (-(1 << 40), 1 << 40)),
    f.CURRENT_MA: ((-7100, 7100), 0.005, I32),
}
"""What the wires carry as a rule, how likely it is something else, and what that is."""

SELDOM = 0.005
FAULTS = (f.EXTERNAL_FAULT, f.ENCODER_FAULT, f.HALL_FAULT, f.OVERHEATED)
MODES = sorted(modes.COMPILED)


class Hostile:
    """A bank whose inputs and settings jump about."""

    def __init__(self, seed: int, *, exact: bool) -> None:
        """`exact` keeps the words as integers of any size."""
        self._draws = np.random.default_rng(seed)
        self.bank = bank = AxisBank(sum(BOARDS), len(BOARDS))
        places = [bank.take_in(self, axes) for axes in BOARDS]
        weights = (0.0, 0.5, -1.6455, 1.0)
        bank.mixing[:] = self._draws.choice(weights, bank.mixing.shape)
        if exact:
            bank.rows, bank.boards = bank.rows.astype(object), bank.boards.astype(object)
            bank.alive_ms = bank.alive_ms.astype(object)
            bank.torque_words = bank.torque_words.astype(object)
        for axes, (board, first) in zip(BOARDS, places, strict=True):
            bank.boards[board, f.RUNNING] = 1
            bank.boards[board, f.MOTORS_COUPLED] = bank.boards[board, f.ENCODERS_COUPLED] = board
            for number in range(axes):
                self._wire(bank.rows[first + number], board, first)

    def run_laws(self) -> None:
        """Every mode here is compiled."""

    def watch_temperature(self) -> None:
        """There is no board to print."""

    def tick(self, now_ms: int) -> None:
        """One millisecond."""
        bank = self.bank
        bank.boards[:, f.MS] = now_ms
        bank.boards[:, f.PARTNER_SILENT] = self._seldom()
        for word in range(f.PARTNER_DUTY_0, f.PARTNER_POSITION_1 + 1):
            bank.boards[:, word] = self._draw(I16)
        for row in bank.rows:
            for word, (usual, likelihood, far) in INPUTS.items():
                row[word] = self._draw(far if self._draws.random() < likelihood else usual)
            for word in FAULTS:
                row[word] = self._seldom()
            if now_ms % COMMAND_PERIOD == 0:
                self._command(row)
        if now_ms % COMMAND_PERIOD == 0:
            bank.alive_ms[:] = int(self._draws.integers(1, 200))
            bank.torque_words[:] = self._draws.integers(0, 0x10000, bank.torque_words.shape)
        bank.control()
        bank.supervise()

    def _command(self, row: Row) -> None:
        """New settings, another mode, a move that begins."""
        for word, span in SETTINGS.items():
            if self._draws.random() < 0.3:
                row[word] = self._draw(span)
        if self._draws.random() < 0.5:
            row[f.I2T] = 0  # else a bridge that once was hot would stay so
        row[f.MODE] = int(self._draws.choice(MODES))
        row[f.ENABLED] = 1
        row[f.COMPLIANT] = int(self._draws.integers(0, 2))
        always = row[f.MODE] in modes.ALWAYS_TORQUE
        switched = row[f.MODE] in modes.TORQUE_WHEN_COMPLIANT and row[f.COMPLIANT]
        row[f.FORCE_CONTROLLED] = int(always or bool(switched))
        delta = int(max(row[f.LOW], min(row[f.HIGH], self._draw(I32))) - row[f.REFERENCE])
        row[f.DELTA], row[f.PROGRESS], row[f.ELAPSED] = delta, 0, 0
        row[f.DURATION] = 100 * abs(delta) // int(self._draws.choice((1, 10, 0x7FFF)))
        row[f.ACTIVE] = 1

    def _wire(self, row: Row, board: int, first: int) -> None:
        """Constants of a BLL for the first board, of a 4DC for the second."""
        fine = board == 0
        row[f.BOARD], row[f.BOARD_FIRST] = board, first
        row[f.MAX_DUTY] = 1250
        row[f.DUTY_STEP] = 10 if fine else 2666
        row[f.SAMPLES] = 10 if fine else 1
        row[f.SPEED_WINDOW] = 29 if fine else 1
        row[f.SCALES_SPEED], row[f.DAMPS_SPEED], row[f.PULSES_STICTION] = fine, fine, not fine
        row[f.I2T_SHIFT], row[f.I2T_TRIP], row[f.TRIP_MA] = 4 * fine, 2_000_000_000, 25_000
        row[f.ENCODER_MASK] = -1
        row[f.PEERS], row[f.WATCHES_PARTNER] = 0b11, 1
        row[f.TORQUE_SOURCE], row[f.TORQUE_CHANNEL] = board * f.SOURCES + 12, 3
        row[f.MOTOR_LOW], row[f.MOTOR_HIGH] = -(1 << 39), 1 << 39

    def _seldom(self) -> int:
        return int(self._draws.random() < SELDOM)

    def _draw(self, span: Range) -> int:
        """A number within a range, half the time at one of its ends."""
        if self._draws.random() < 0.5:
            return int(self._draws.choice(span))
        return int(self._draws.integers(span[0], span[1] + 1))


def outcome(seed: int, *, exact: bool) -> list[list[int]]:
    """Sum over the ticks of every word of every axis, weighed by the tick; the last words."""
    hostile = Hostile(seed, exact=exact)
    words: list[int] = []
    sums = [0] * hostile.bank.rows.size
    for now_ms in range(1, TICKS + 1):
        hostile.tick(now_ms)
        words = hostile.bank.rows.ravel().tolist()
        sums = [total + word * now_ms for total, word in zip(sums, words, strict=True)]
    return [sums, words]


def print_outcomes() -> None:
    """Write exact outcomes and those of 64-bit words, for the seeds on the command line."""
    seeds = [int(seed) for seed in sys.argv[1:]]
    json.dump(
        [[outcome(seed, exact=exact) for exact in (True, False)] for seed in seeds], sys.stdout
    )
