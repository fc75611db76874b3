"""Angles and speeds of all joints of the model, from the parts' states."""

import math

import numpy as np

from dforc.arrays import Vector
from services.core.service import Inputs
from services.messages import JointState
from services.wholebody.body import BodyPart

STATE_AGE_NS = 30_000_000  # a few joint states
ELSEWHERE_RAD = 0.01  # a filter takes more, after a silence, for a jerk
ABSURD = 1000.0  # rad, rad/s, of all joints of a part together: no joint turns so far or so fast


class JointBank:
    """Keeps the newest good state of each part; what is bad is refused and counted.

    A part that falls silent keeps its last angles, for whom they do not matter.
    """

    def __init__(self, parts: tuple[BodyPart, ...], joints: int) -> None:
        self.q_rad: Vector = np.zeros(joints)
        self.dq_rad_s: Vector = np.zeros(joints)
        self.refused = 0
        self.fresh = (False,) * len(parts)
        self.elsewhere = False  # a part came back in this step, and not where it fell silent
        self._parts = parts
        self._arrival_ns = [-STATE_AGE_NS - 1] * len(parts)
        self._index = {part.name: i for i, part in enumerate(parts)}
        self._related = [[self._index[name] for name in part.related] for part in parts]

    def take(self, now_ns: int, inputs: Inputs) -> bool:
        """Look at what has arrived; whether some part's state is new."""
        new = False
        self.elsewhere = False
        for i, part in enumerate(self._parts):
            state = inputs.new(part.state)
            if state is None:
                continue
            last_rad = None if self.fresh[i] else self.q_rad[part.start : part.stop].copy()
            if self._accept(part, state):
                if last_rad is not None:
                    moved_rad = self.q_rad[part.start : part.stop] - last_rad
                    self.elsewhere |= bool((np.abs(moved_rad) > ELSEWHERE_RAD).any())
                self._arrival_ns[i] = now_ns
                new = True
        oldest_ns = now_ns - STATE_AGE_NS
        fresh = tuple([arrival_ns >= oldest_ns for arrival_ns in self._arrival_ns])
        if fresh != self.fresh:
            self.fresh = fresh
        return new

    def missing_for(self, part: BodyPart) -> tuple[str, ...]:
        """Parts whose angles its torques need and that are not heard."""
        related = self._related[self._index[part.name]]
        return tuple(self._parts[i].name for i in related if not self.fresh[i])

    def is_heard(self, part: str) -> bool:
        """Whether a part's angles are known now."""
        return self.fresh[self._index[part]]

    def _accept(self, part: BodyPart, state: JointState) -> bool:
        if not state.valid:
            return False
        count = part.size
        q, dq = state.q_rad, state.dq_rad_s
        # The comparison also fails for what is not finite.
        if len(q) != count or len(dq) != count or not math.hypot(*q, *dq) < ABSURD:
            self.refused += 1
            return False
        self.q_rad[part.start : part.stop] = part.from_stream(q)
        self.dq_rad_s[part.start : part.stop] = part.from_stream(dq)
        return True
