"""Pushes of 20 N on compliant limbs: they must give way as their stiffness says, and come back.

What it says: q = q0 + K^-1 J(q)' F, in the joints that are springs, with the others where they are.
"""

from dataclasses import dataclass

import numpy as np

from dforc.arrays import Vector
from services.experiments.loops.limbs import Limb, Point
from services.experiments.loops.trial import LoopTrial
from services.messages import Vector3
from services.robotfile.robot_tables import RobotFile
from services.script import Script

SETTLED_S, PUSH_S, BACK_S = 1.5, 2.5, 2.0
MEAN_S = 0.1
REST_S, REST_MEAN_S = 0.5, 1.0
ROUNDS = 60


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class Deflection:
    """One push: how far the pushed point went, and how far it should have gone (m, base axes)."""

    limb: str
    place: str
    force_n: Vector3
    predicted_m: Vector
    moved_m: Vector
    back_m: float  # how far from where it was before, after the push
    rest_rad_s: float  # fastest compliant joint in the last REST_S, mean over 50 ms
    rest_mean_rad_s: float  # of the joint that went the longest way in the last REST_MEAN_S
    trace_m: Vector  # along the prediction, each millisecond from the beginning of the push

    @property
    def axis(self) -> str:
        """Of the base, with its sense, along which the push is."""
        along = int(np.argmax(np.abs(self.force_n)))
        return ("-" if self.force_n[along] < 0.0 else "+") + "xyz"[along]

    @property
    def ratio(self) -> float:
        """Along the predicted deflection, over it."""
        return float(self.moved_m @ self.predicted_m / (self.predicted_m @ self.predicted_m))


def pushes(trial: LoopTrial, found: list[Deflection], rounds: int) -> Script:
    """Push each limb at some places, all limbs at once."""
    yield from trial.make_compliant()
    yield from trial.wait(SETTLED_S)
    for k in range(rounds):
        trial.say(f"pushing, round {k + 1} of {rounds}")
        yield from _round(trial, k, found)


def _round(trial: LoopTrial, k: int, found: list[Deflection]) -> Script:
    world = trial.world
    pushed = [
        (limb, place, Point(trial.robot, limb, frame), force)
        for limb in trial.limbs
        for place, frame, force in (limb.pushes[k % len(limb.pushes)],)
    ]
    begin = world.ticks
    before = [world.mean(point.joints, MEAN_S) for _, _, point, _ in pushed]
    for _, _, point, force in pushed:
        world.rig.push(force, PUSH_S, point.frame)
    yield from trial.wait(PUSH_S)
    during = [world.mean(point.joints, MEAN_S) for _, _, point, _ in pushed]
    yield from trial.wait(BACK_S)
    for (limb, place, point, force), q0, q1 in zip(pushed, before, during, strict=True):
        still, bent = predicted(trial.robot, limb, point, (q0, q1), np.array(force))
        away = point.place_m(bent) - point.place_m(still)
        rows = world.angles(point.joints, begin, world.ticks)
        start = point.place_m(q0)
        along = away / np.linalg.norm(away)
        found.append(
            Deflection(
                limb=limb.part,
                place=place,
                force_n=force,
                predicted_m=away,
                moved_m=point.place_m(q1) - point.place_m(still),
                back_m=float(np.linalg.norm(point.place_m(rows[-100:].mean(0)) - start)),
                rest_rad_s=_rest(trial, limb),
                rest_mean_rad_s=_rest_mean(trial, limb),
                trace_m=np.array([(point.place_m(row) - start) @ along for row in rows]),
            )
        )


def predicted(
    robot: RobotFile, limb: Limb, point: Point, postures: tuple[Vector, Vector], force_n: Vector
) -> tuple[Vector, Vector]:
    """Postures that springs at rest, and pushed, would have.

    `postures` are those before and under the push: joints that are no springs are taken from it.
    """
    q0, q1 = postures
    springs = [point.joints.index(joint) for joint in limb.compliant]
    still = q1.copy()
    still[springs] = q0[springs]
    compliance = np.zeros(len(still))
    for joint in limb.compliant:
        impedance = robot.joints[joint].impedance
        assert impedance is not None, "compliant joints have a stiffness"
        compliance[point.joints.index(joint)] = 1.0 / np.degrees(impedance.stiffness_nm_deg)
    bent = still
    for _ in range(ROUNDS):
        bent = still + compliance * (point.jacobian(bent).T @ force_n)
    return still, bent


def _rest(trial: LoopTrial, limb: Limb) -> float:
    world = trial.world
    rows = world.angles(limb.compliant, world.ticks - round(REST_S * 1e3), world.ticks)
    speeds: Vector = np.abs(rows[50:] - rows[:-50]).max(0) / 0.05
    return float(speeds.max())


def _rest_mean(trial: LoopTrial, limb: Limb) -> float:
    world = trial.world
    rows = world.angles(limb.compliant, world.ticks - round(REST_MEAN_S * 1e3), world.ticks)
    return float(np.abs(np.diff(rows, axis=0)).sum(0).max() / REST_MEAN_S)
