"""Drives the virtual points of the limb in use: begins a mode, steps it, changes it on the way."""

import math
from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from dforc import rotation
from dforc.arrays import Vector
from dforc.ik.inverse_kinematics import InverseKinematics
from dforc.ik.problem import TipTarget
from services.fields.gains import changed_gains, initial_gains
from services.fields.goals import ActiveGoal
from services.fields.limbs import FieldLimb
from services.fields.messages import MODES, NamedFloats
from services.fields.mode import FieldMode, Goals, HandPoint, ModeOf, Motion, Start, Surroundings
from services.messages import VirtualPoint
from services.reaching.tip_poses import vector3

FITS_M = 0.001  # between a posture's hand and the point that it is to stand for


class PointDriver:
    """One goal of one limb by one mode."""

    def __init__(
        self, limbs: Mapping[str, FieldLimb], makers: Mapping[str, ModeOf], mode: str
    ) -> None:
        """`mode` is the one in use at first; `makers` make the modes there are."""
        self.mode = mode
        self.gains = {name: initial_gains(name) for name in MODES}
        self.goal: ActiveGoal | None = None
        self.motion: Motion | None = None  # of the newest period; None: no point is in motion
        self.asked: Goals | None = None  # in that period
        self.lag_m = math.nan
        self.held = 0  # periods so far that held the last safe velocity
        self._limbs = limbs
        self._makers = makers
        self._laws: dict[tuple[str, str], FieldMode] = {}
        self._begun: FieldMode | None = None
        self._sequence = 0

    @property
    def limb(self) -> FieldLimb | None:
        """Of the goal."""
        return None if self.goal is None else self._limbs[self.goal.limb]

    @property
    def law(self) -> FieldMode | None:
        """The mode that is in motion."""
        return self._begun

    def go(self, goal: ActiveGoal, *, moved_on: bool = False) -> None:
        """A goal, at once; another limb begins afresh.

        Args:
            goal: what is to be reached.
            moved_on: it is the one before, which has moved: what is known of that holds.

        Raises:
            ServiceError: the mode does not move such a limb; nothing has changed.
        """
        self.law_of(self.mode, self._limbs[goal.limb])
        if self.goal is not None and self.goal.limb != goal.limb:
            self.drop()
        self.goal = goal
        if self._begun is not None and not moved_on:
            self._begun.new_goal()

    def stop(self) -> None:
        """No goal: the points are gone, and the controller comes to rest."""
        self.goal = None
        self.drop()

    def drop(self) -> None:
        """The next point begins at the hand."""
        self._begun = None
        self.motion = None
        self.asked = None
        self.lag_m = math.nan

    def forget_laws(self, limb: str) -> None:
        """The limb is set up in another way: its modes are made again."""
        self._laws = {key: law for key, law in self._laws.items() if key[1] != limb}
        if self.goal is not None and self.goal.limb == limb:
            self.drop()

    def change(self, mode: str, changes: NamedFloats, preset: str, answer: Vector | None) -> None:
        """Another mode, other gains; points in motion go on where they are, as fast as they are.

        `answer` is the newest one of inverse kinematics to the limb's points.

        Raises:
            ServiceError: unknown, out of bounds, or no mode for the limb; nothing has changed.
        """
        wanted = mode or self.mode
        gains = self.changed(wanted, changes, preset)
        limb = self.limb
        if limb is not None and wanted != self.mode:
            law = self.law_of(wanted, limb)
            law.use(gains)
            if self.motion is not None:
                law.begin(start_from(limb, self.motion, answer))
                self._begun = law
        elif limb is not None:
            self.law_of(wanted, limb).use(gains)
        self.mode = wanted
        self.gains[wanted] = gains

    def changed(self, mode: str, changes: NamedFloats, preset: str) -> dict[str, float]:
        """The gains of a mode as they would be.

        Raises:
            ConfigError: unknown, or out of bounds.
        """
        return changed_gains(mode, self.gains.get(mode, {}), changes, preset)

    def law_of(self, mode: str, limb: FieldLimb) -> FieldMode:
        """The mode of a limb, made when it is first asked for, with the gains in use.

        Raises:
            ServiceError: the mode does not move such a limb.
        """
        key = (mode, limb.name)
        if key not in self._laws:
            self._laws[key] = self._makers[mode](limb, self.gains[mode])
        law = self._laws[key]
        if law is not self._begun:
            law.use(self.gains[mode])
        return law

    def step(self, q_rad: Vector, goals: Goals | None, around: Surroundings) -> Motion | None:
        """One period of the limb in use, whose measured posture is given; None without a goal.

        Raises:
            DforcError: hand and goal make no motion.
        """
        limb = self.limb
        if limb is None:
            return None
        if self._begun is None:
            law = self.law_of(self.mode, limb)
            law.begin(start_at(limb, q_rad))
            self._begun = law
        before = 0.0 if math.isnan(self.lag_m) else self.lag_m
        motion = self._begun.step(goals, around, before)
        self.lag_m = lag_m(limb, q_rad, motion)
        self.motion, self.asked = motion, goals
        self.held += motion.held
        return motion

    def point(self, now_ns: int, motion: Motion, goal: ActiveGoal) -> VirtualPoint:
        """The newest point as the others read it."""
        self._sequence += 1
        first, *others = motion.hands
        asked = goal.message
        second: HandPoint | None = others[0] if others else None
        if asked.second_position_m is None:
            second = None
        turned = second is not None and asked.second_rotation_rad is not None
        return VirtualPoint(
            stamp_ns=now_ns,
            sequence=self._sequence,
            position_m=vector3(first.position_m),
            velocity_m_s=vector3(first.velocity_m_s),
            rotation_rad=vector3(rotation.rotation_vector(first.rotation)),
            limb=goal.limb,
            position_only=asked.position_only,
            second_position_m=None if second is None else vector3(second.position_m),
            second_rotation_rad=vector3(rotation.rotation_vector(second.rotation))
            if second is not None and turned
            else None,
            second_velocity_m_s=(0.0, 0.0, 0.0) if second is None else vector3(second.velocity_m_s),
            q_rad=() if motion.q_rad is None else tuple(motion.q_rad.tolist()),
            dq_rad_s=() if motion.dq_rad_s is None else tuple(motion.dq_rad_s.tolist()),
            trajectory_time_s=self.gains[self.mode]["T"],
            mode=self.mode,
        )


def start_at(limb: FieldLimb, q_rad: Vector) -> Start:
    """At rest at a measured posture."""
    hands = tuple(HandPoint(position_m=p, rotation=R) for R, p in limb.poses(q_rad))
    return Start(q_rad=q_rad, dq_rad_s=np.zeros(len(q_rad)), hands=hands)


def start_from(limb: FieldLimb, motion: Motion, answer: Vector | None) -> Start:
    """Where another mode's motion is: with its posture, or one that has the same hands."""
    if motion.q_rad is not None and motion.dq_rad_s is not None:
        return Start(q_rad=motion.q_rad, dq_rad_s=motion.dq_rad_s, hands=motion.hands)
    begin = limb.problem.rest_rad if answer is None else answer
    q_rad = fitting_posture(limb, motion.hands, begin)
    speeds = limb.speeds_for(q_rad, tuple(hand.velocity_m_s for hand in motion.hands))
    return Start(q_rad=q_rad, dq_rad_s=speeds, hands=motion.hands)


def fitting_posture(limb: FieldLimb, hands: tuple[HandPoint, ...], begin: Vector) -> Vector:
    """A posture whose hands are at the points: `begin` where that will do, or one near it."""
    poses = limb.poses(begin)
    away = (math.dist(p, hand.position_m) for (_, p), hand in zip(poses, hands, strict=True))
    if max(away) <= FITS_M:
        return begin
    search = InverseKinematics(replace(limb.problem, rest_rad=begin))
    targets = [TipTarget.checked(hand.position_m, hand.rotation) for hand in hands]
    found: Vector = search.solve(targets, begin, starts=1).q_rad
    return found


def lag_m(limb: FieldLimb, q_rad: Vector, motion: Motion) -> float:
    """Distance of the measured hand from its point; of the worst hand."""
    pairs = zip(limb.poses(q_rad), motion.hands, strict=True)
    return max(math.dist(p, hand.position_m) for (_, p), hand in pairs)
