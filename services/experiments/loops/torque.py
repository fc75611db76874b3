"""Torque steps: one joint of each limb in torque mode, its end held by a hand, others stiff."""

import math
from dataclasses import dataclass

import numpy as np

from dforc.arrays import Vector
from services.experiments.loops.limbs import ORIGIN, Limb, Point
from services.experiments.loops.trial import LoopTrial
from services.messages import Vector3
from services.script import Script

BEFORE_S, STEP_S = 0.4, 0.6
STEADY_S = 0.2  # at the end of either
GRIP_M = 0.08  # off the link's origin, for a lever on every joint
RISES = (0.1, 0.9)
SMOOTH_MS = 5  # ripple is no overshoot, and does not unsettle
BAND = 0.15  # of the step, about where the answer ends


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class TorqueStep:
    """One joint's answer: the torque its board hears (Nm) each millisecond, step at `at_s` = 0."""

    joint: str
    at_s: Vector
    tau_nm: Vector
    wanted_nm: Vector

    @property
    def amplitude_nm(self) -> float:
        """What was asked for."""
        return float(self.wanted_nm[-1] - self.wanted_nm[0])

    @property
    def _before_nm(self) -> float:
        return float(self.tau_nm[(self.at_s >= -STEADY_S) & (self.at_s < 0.0)].mean())

    @property
    def _end(self) -> Vector:
        end: Vector = self.tau_nm[self.at_s >= STEP_S - STEADY_S]
        return end

    def _first_s(self, share: float) -> float:
        """From the step until the answer first gets this far, of what came in the end."""
        way = (self.tau_nm - self._before_nm) / (self._end.mean() - self._before_nm)
        reached = self.at_s[(self.at_s >= 0.0) & (way >= share)]
        return float(reached[0]) if len(reached) else math.inf

    @property
    def dead_s(self) -> float:
        """From the command until a tenth of what came in the end: buses, estimate, and board."""
        return self._first_s(RISES[0])

    @property
    def first_crossing_s(self) -> float:
        """From a tenth to nine tenths, first crossing of either: the answer may fall back after."""
        return self._first_s(RISES[1]) - self._first_s(RISES[0])

    @property
    def _smooth_nm(self) -> Vector:
        """After the step; each value the mean of the milliseconds that begin with it."""
        window = np.full(SMOOTH_MS, 1.0 / SMOOTH_MS)
        smooth: Vector = np.convolve(self.tau_nm[self.at_s >= 0.0], window, mode="valid")
        return smooth

    @property
    def settling_s(self) -> float:
        """From the command until the answer is within BAND of its end and stays.

        Infinite when it leaves the band in the time that says where it ends.
        """
        smooth, at_s = self._smooth_nm, self.at_s[self.at_s >= 0.0]
        if not np.isfinite(smooth).all():
            return math.nan
        outside = np.abs(smooth - self._end.mean()) > BAND * abs(self.amplitude_nm)
        if not outside.any():
            return 0.0
        last = int(np.flatnonzero(outside)[-1])
        return float(at_s[last + 1]) if at_s[last] < STEP_S - STEADY_S else math.inf

    @property
    def overshoot(self) -> float:
        """Highest value over the final one, as a share of the step; of means over 5 ms."""
        sign = np.sign(self.amplitude_nm)
        above = (sign * self._smooth_nm).max() - sign * self._end.mean()
        return float(np.maximum(above, 0.0) / abs(self.amplitude_nm))

    @property
    def change_error(self) -> float:
        """Steady error of the change alone, as a share of the step."""
        change = float(self._end.mean()) - self._before_nm
        return abs(change - self.amplitude_nm) / abs(self.amplitude_nm)

    @property
    def absolute_error_nm(self) -> float:
        """Steady torque off the commanded one, before the step or after it: the larger."""
        before = abs(self._before_nm - self.wanted_nm[0])
        return float(np.maximum(before, abs(self._end.mean() - self.wanted_nm[-1])))

    @property
    def absolute_error(self) -> float:
        """The same as a share of the step."""
        return self.absolute_error_nm / abs(self.amplitude_nm)

    @property
    def ripple_nm(self) -> float:
        """Standard deviation at the end."""
        return float(self._end.std())


def torque_steps(trial: LoopTrial, found: list[TorqueStep], only: int | None = None) -> Script:
    """Every joint with a torque loop, or only the first ones of each limb."""
    most = max(len(limb.torque) for limb in trial.limbs)
    for k in range(most if only is None else min(only, most)):
        chosen = [(limb, limb.torque[k]) for limb in trial.limbs if k < len(limb.torque)]
        for limb, joint in chosen:
            trial.world.grip(_held(trial, limb, joint))
        joints = tuple(joint for _, joint in chosen)
        yield from trial.ask(
            f"torque mode: {', '.join(joints)}", "mode", joints=joints, value="torque"
        )
        yield from _step(trial, chosen, k, found)
        yield from trial.go_back()


def _step(
    trial: LoopTrial, chosen: list[tuple[Limb, str]], k: int, found: list[TorqueStep]
) -> Script:
    gravity = {joint: trial.gravity(limb)[joint] for limb, joint in chosen}

    def command(step: bool) -> None:
        for limb, joint in chosen:
            added = limb.steps_nm[k] if step else 0.0
            trial.command_torques(limb, {joint: gravity[joint] + added})

    trial.listen()
    yield from trial.wait(BEFORE_S, lambda _: command(step=False))
    stepped_ns = trial.now_ns
    yield from trial.wait(STEP_S, lambda _: command(step=True))
    trial.deafen()
    for limb, joint in chosen:
        estimates = trial.estimates[limb.part]
        at_s = np.array([(one.stamp_ns - stepped_ns) * 1e-9 for one in estimates])
        place = trial.robot.parts[limb.part].index(joint)
        wanted = np.where(at_s >= 0.0, gravity[joint] + limb.steps_nm[k], gravity[joint])
        tau = np.array([one.tau_nm[place] for one in estimates])
        found.append(TorqueStep(joint=joint, at_s=at_s, tau_nm=tau, wanted_nm=wanted))


def _held(trial: LoopTrial, limb: Limb, joint: str) -> Point:
    """Where a hand holds the end of a limb so that the joint has a lever on it."""
    places: tuple[Vector3, ...] = (ORIGIN, (GRIP_M, 0, 0), (0, GRIP_M, 0), (0, 0, GRIP_M))
    points = [Point(trial.robot, limb, limb.end, place) for place in places]

    def lever(point: Point) -> float:
        q = trial.world.mean(point.joints, 0.01)
        return float(np.linalg.norm(point.jacobian(q)[:, point.joints.index(joint)]))

    return max(points, key=lever)
