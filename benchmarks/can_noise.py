"""Seeded random frames: commands with random arguments, commands that make no sense, any bytes.

Some episodes withhold one thing that a motor needs before it may run, so that the gate is met with
everything but that.
"""

import random
from collections.abc import Sequence

from benchmarks.can_oracle import CALIBRATE, FLAG_GROUPS, FLAGS, HANDSHAKE, SET_MODE
from hal.wire import analog, management, motor
from hal.wire.can import (
    CLASS_ANALOG_POLLING,
    CLASS_MANAGEMENT,
    CLASS_MOTOR_POLLING,
    EVERYBODY,
    HOST,
    Frame,
    frame_id,
)

EPISODE = 2000  # frames between two power-ups
STANDARD_IDS = 0x800
EXTENDED_IDS = 1 << 29
HEARD = (0x3CA, 0x3CB, 0x3BA, 0x3BB, 0x111, 0x112, 0x122, 0x3EC, 0x3ED)
"""Torques, a shoulder's partner, Hall sensors."""
BOARD = management.BOARD.code  # the jump to the boot loader
GAIN_COMMANDS = (*FLAGS, *FLAG_GROUPS)
MODES = (0x00, 0x01, 0x02, 0x03, 0x04, 0x05, 0x07, 0x08, 0x09, 0x50)
CALIBRATION_TYPES = (0, 2, 3, 4, 6, 7)


class Noise:
    """Frames for one motor board."""

    def __init__(self, draw: random.Random, axes: int) -> None:
        self._draw = draw
        self._axes = axes
        self._lengths = {code: row.request_layout.dlc for code, row in motor.COMMANDS.items()}
        self._codes = tuple(motor.COMMANDS)
        self._episodes = 0
        self._withheld: tuple[int, ...] = ()
        self._opening: list[tuple[int, bytes]] = []
        self._axis_bit = 0

    def new_episode(self) -> None:
        """Choose what is withheld: nothing, the handshake, some gain of an axis, its mode."""
        draw = self._draw
        self._axis_bit = draw.choice((0x00, 0x80))
        gain = draw.choice(tuple(FLAGS))
        choices: tuple[tuple[int, ...], ...] = (
            (),
            (),
            (HANDSHAKE,),
            (gain, *FLAG_GROUPS),
            (SET_MODE, CALIBRATE),
        )
        is_first = not self._episodes  # nothing is withheld: even a short run gets axes running
        self._episodes += 1
        self._withheld = () if is_first else draw.choice(choices)
        self._opening = self._prologue() if is_first or draw.random() < 0.5 else []

    def frame(self, addresses: Sequence[int]) -> Frame:
        """The next one, for a board that owns these addresses now."""
        while True:
            can_id, data = self._next(addresses)
            if not data or data[0] & 0x7F not in self._withheld:
                return can_id, data
            if data[0] & 0x80 != self._axis_bit and data[0] & 0x7F != HANDSHAKE:
                return can_id, data

    def _next(self, addresses: Sequence[int]) -> Frame:
        if self._opening:
            number, data = self._opening.pop()
            return frame_id(CLASS_MOTOR_POLLING, HOST, addresses[number] & 0xF), data
        return self._any(addresses)

    def _prologue(self) -> list[tuple[int, bytes]]:
        """Everything that gets every axis running, last frame first; which address, and what.

        In any order at first, which leads to faults; then in the order that works.
        """
        steps: list[list[tuple[int, bytes]]] = [[(0, bytes((HANDSHAKE, 1, 6)))], [], [], [], []]
        for axis in range(self._axes):
            bit = 0x80 if axis % 2 else 0x00
            calibration = motor.CALIBRATE_ENCODER.request(1, axis % 2, 3, 2000, 10, 0)[1]
            steps[1].append((axis // 2, bytes((0x52 | bit, 100, 0, 0, 0, 0, 0, 6))))
            steps[1].append((axis // 2, bytes((0x54 | bit, 0, 0, 0, 2, 0, 2, 0))))
            steps[2].append((axis // 2, bytes((SET_MODE | bit, 0x09))))
            steps[3].append((axis // 2, calibration))
            steps[4].append((axis // 2, bytes((SET_MODE | bit, 0x01))))
        ordered = [frame for step in steps for frame in step]
        anyhow = self._draw.sample(ordered, len(ordered))
        return [*reversed(ordered), *anyhow]

    def _any(self, addresses: Sequence[int]) -> Frame:
        draw = self._draw
        chance = draw.random()
        polled = frame_id(CLASS_MOTOR_POLLING, HOST, draw.choice(addresses) & 0xF)
        axis = draw.choice((0x00, 0x80))
        if chance < 0.35:
            return polled, self._opener(axis)
        if chance < 0.6:
            code = draw.choice(self._codes)
            return polled, bytes((code | axis,)) + draw.randbytes(self._lengths[code] - 1)
        if chance < 0.72:
            return polled, draw.randbytes(draw.randrange(9))
        if chance < 0.87:
            return draw.choice(HEARD), draw.randbytes(draw.choice((6, 7, 8, 8, 8)))
        return _elsewhere(draw, addresses[0])

    def _opener(self, axis: int) -> bytes:
        """A command that brings an axis nearer to running, with arguments that may do."""
        draw = self._draw
        kind = draw.randrange(4)
        if kind == 0:
            return bytes((HANDSHAKE, 1, draw.choice((0, 5, 6, 6, 6, 7))))
        if kind == 1:
            return bytes((SET_MODE | axis, draw.choice(MODES)))
        if kind == 2:
            code = draw.choice(GAIN_COMMANDS)
            return bytes((code | axis,)) + draw.randbytes(self._lengths[code] - 1)
        target, speed = draw.randrange(-300, 4000), draw.choice((0, 10, 100))
        return motor.CALIBRATE_ENCODER.request(
            1, axis >> 7, draw.choice(CALIBRATION_TYPES), target, speed, draw.randrange(4096)
        )[1]


class SensorNoise:
    """Frames for one sensor board."""

    def __init__(self, draw: random.Random) -> None:
        self._draw = draw
        self._codes = tuple(analog.COMMANDS)

    def frame(self, address: int) -> Frame:
        """The next one."""
        draw = self._draw
        chance = draw.random()
        polled = frame_id(CLASS_ANALOG_POLLING, HOST, address)
        if chance < 0.7:
            return polled, bytes((draw.choice(self._codes),)) + draw.randbytes(draw.randrange(8))
        if chance < 0.85:
            return polled, draw.randbytes(draw.randrange(9))
        return _elsewhere(draw, address)


def _elsewhere(draw: random.Random, address: int) -> Frame:
    """Management, where the boot loader is rare, or any identifier, of 29 bits too."""
    chance = draw.random()
    if chance < 0.5:
        can_id = frame_id(CLASS_MANAGEMENT, HOST, draw.choice((address & 0xF, EVERYBODY)))
        data = draw.randbytes(draw.randrange(9))
        if data[:1] == bytes((BOARD,)) and draw.random() < 0.98:
            data = bytes((management.END.code,))
        return can_id, data
    ids = STANDARD_IDS if chance < 0.9 else EXTENDED_IDS
    return draw.randrange(ids), draw.randbytes(draw.randrange(9))
