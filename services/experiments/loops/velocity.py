"""Velocity on top of impedance: compliant joints whose boards move the spring's reference.

There, back, and there again; the third time somebody pushes meanwhile. The reference is where the
joint was plus velocity times time (force control paper, eq. 7): the boards integrate it.
"""

from dataclasses import dataclass
from functools import partial

import numpy as np

from dforc.arrays import Vector
from services.experiments.loops.impedance import predicted
from services.experiments.loops.limbs import Limb, Point
from services.experiments.loops.trial import LoopTrial
from services.script import Script

SETTLED_S, MOVE_S, STOP_S, TICK_S = 1.5, 1.5, 1.0, 0.001
PUSHED_S = 1.2  # from the beginning of the third move, and judged before its end
COUNTS = 30.0  # of VELOCITY_MOVE, for a velocity that the boards can represent
MEAN_S = 0.05


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class Turn:
    """One joint over the three moves, rad and rad/s; traces each millisecond."""

    limb: str
    joint: str
    speed_rad_s: float
    q_rad: Vector
    reference_rad: Vector
    lag_s: float  # distance behind the reference over its speed, at the end of the first move
    stop_error_rad: float  # after the second stop
    push_ratio: float  # of what the limb gives way while it moves, over what its stiffness says


def turns(trial: LoopTrial, found: list[Turn]) -> Script:
    """Two joints of each limb."""
    yield from trial.make_compliant()
    joints = trial.joints(lambda limb: limb.turned)
    yield from trial.ask("velocity mode", "mode", joints=joints, value="velocity")
    yield from trial.wait(SETTLED_S)
    world = trial.world
    first = world.ticks
    points = [Point(trial.robot, limb, limb.middle) for limb in trial.limbs]
    for number, sign in enumerate((1.0, -1.0, 1.0)):
        trial.say(f"constant velocity, move {number + 1} of 3")
        if number == 2:
            for limb, point in zip(trial.limbs, points, strict=True):
                world.rig.push(_force(limb).tolist(), PUSHED_S, point.frame)
        yield from trial.wait(MOVE_S, partial(_command, trial, sign))
        yield from trial.wait(STOP_S, partial(_command, trial, 0.0))
    for limb, point in zip(trial.limbs, points, strict=True):
        found += _judged(trial, limb, point, first)


def speed_rad_s(trial: LoopTrial, joint: str) -> float:
    """A whole number of the boards' counts, in the joint's sense."""
    table = trial.robot.joints[joint]
    ticks_s = COUNTS * 1000.0 / 2**trial.robot.host.velocity_shift
    return float(np.radians(ticks_s / abs(table.ticks_per_deg)))


def _command(trial: LoopTrial, sign: float, _at_s: float) -> None:
    for limb in trial.limbs:
        speeds = {joint: sign * speed_rad_s(trial, joint) for joint in limb.turned}
        trial.command_velocities(limb, speeds)


def _force(limb: Limb) -> Vector:
    return np.array(limb.pushes[0][2])


def _judged(trial: LoopTrial, limb: Limb, point: Point, first: int) -> list[Turn]:
    """Compares the third move with the first, at the same time of either."""
    whole, move = round((MOVE_S + STOP_S) * 1e3), round(MOVE_S * 1e3)
    rows = trial.world.angles(point.joints, first, first + 3 * whole)
    at = slice(round((PUSHED_S - MEAN_S) * 1e3), round(PUSHED_S * 1e3))
    alone, pushed = rows[:whole][at].mean(0), rows[2 * whole :][at].mean(0)
    still, bent = predicted(trial.robot, limb, point, (alone, pushed), _force(limb))
    away = point.place_m(bent) - point.place_m(still)
    moved = point.place_m(pushed) - point.place_m(still)
    ratio = float(moved @ away / (away @ away))
    made = []
    for joint in limb.turned:
        q, speed = rows[:, point.joints.index(joint)], speed_rad_s(trial, joint)
        way = np.minimum(np.arange(whole), move) * TICK_S * speed
        reference = q[:20].mean() + np.concatenate([way, way[-1] - way, way])
        made.append(
            Turn(
                limb=limb.part,
                joint=joint,
                speed_rad_s=speed,
                q_rad=q,
                reference_rad=reference,
                lag_s=float((reference - q)[move - 200 : move].mean() / speed),
                stop_error_rad=float(abs((q - reference)[2 * whole - 100 : 2 * whole].mean())),
                push_ratio=ratio,
            )
        )
    return made
