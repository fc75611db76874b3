"""Hand guiding: no stiffness, gravity held. The limb stays where it is, and a person leads it."""

from dataclasses import dataclass

import numpy as np

from dforc.arrays import Vector
from services.experiments.loops.limbs import Point
from services.experiments.loops.trial import LoopTrial
from services.experiments.loops.world import Grip
from services.script import Script

SETTLED_S, DRIFT_S, GUIDED_S, LEFT_S = 1.0, 5.0, 0.5, 2.0
EASE_S = 0.4  # in which the hand takes up its speed, and lays it off
MEAN_S = 0.05


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class Guiding:
    """One limb in torque mode with gravity as its only set-point."""

    limb: str
    drift_rad: float  # of the joint that moved most, untouched
    force_n: float  # mean, while the hand moved at constant speed
    peak_n: float  # of the whole way
    led_m: float
    left_m: float  # how far the end moved by itself once it was let go
    trace: Vector  # each millisecond while being led: force (N), way (m)


def guiding(trial: LoopTrial, found: list[Guiding], drift_s: float = DRIFT_S) -> Script:
    """All limbs at once."""
    world = trial.world
    joints = trial.joints(lambda limb: limb.torque)
    trial.holds_gravity = True
    yield from trial.ask("torque mode for hand guiding", "mode", joints=joints, value="torque")
    yield from trial.wait(SETTLED_S)
    trial.say("nobody touches the limbs")
    first = world.ticks
    yield from trial.wait(drift_s)
    drift = {
        limb.part: float(
            np.abs(np.ptp(world.angles(limb.torque, first, world.ticks), axis=0)).max()
        )
        for limb in trial.limbs
    }
    points = [Point(trial.robot, limb, limb.end) for limb in trial.limbs]
    starts = [point.place_m(world.mean(point.joints, MEAN_S)) for point in points]
    grips = [world.grip(point) for point in points]
    traces: list[list[tuple[float, float]]] = [[] for _ in grips]
    trial.say("leading the limbs by the hand")
    yield from _lead(trial, grips, starts, traces)
    world.let_go()
    ends = [point.place_m(world.mean(point.joints, 0.002)) for point in points]
    yield from trial.wait(LEFT_S)
    trial.holds_gravity = False
    for limb, point, start, end, trace in zip(
        trial.limbs, points, starts, ends, traces, strict=True
    ):
        rows = np.array(trace)
        steady = slice(round(EASE_S * 1e3), round((EASE_S + GUIDED_S) * 1e3))
        left = point.place_m(world.mean(point.joints, MEAN_S))
        found.append(
            Guiding(
                limb=limb.part,
                drift_rad=drift[limb.part],
                force_n=float(rows[steady, 0].mean()),
                peak_n=float(rows[:, 0].max()),
                led_m=float(np.linalg.norm(end - start)),
                left_m=float(np.linalg.norm(left - end)),
                trace=rows,
            )
        )


def _lead(
    trial: LoopTrial,
    grips: list[Grip],
    starts: list[Vector],
    traces: list[list[tuple[float, float]]],
) -> Script:
    whole_s = GUIDED_S + 2.0 * EASE_S
    for tick in range(round(whole_s * 1e3)):
        at_s = tick * 1e-3
        share = min(at_s / EASE_S, (whole_s - at_s) / EASE_S, 1.0)
        for limb, grip, start, trace in zip(trial.limbs, grips, starts, traces, strict=True):
            grip.speed_m_s = share * np.array(limb.guided_m_s)
            place = grip.point.place_m(trial.world.mean(grip.point.joints, 0.001))
            trace.append(
                (float(np.linalg.norm(grip.force_n)), float(np.linalg.norm(place - start)))
            )
        yield from trial.wait(1e-3)
