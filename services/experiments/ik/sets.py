"""Seeded targets for inverse kinematics, each with what an independent solver knows about it."""

from collections.abc import Callable
from dataclasses import dataclass, fields

import numpy as np
import pinocchio as pin

from services.experiments.ik.arm import Arm, Array
from services.experiments.ik.kept import kept
from services.experiments.ik.nlp import Form, PlainNlp

VERSION = 3  # of what is kept between runs
FEW_STARTS = 4  # sort candidates out before the many starts
REACHED_M = 1e-5  # an equation that holds
LEAST_ANGLE, MOST_ANGLE = np.radians(3.0), np.radians(29.0)
LEAST_M, MOST_M = 0.013, 0.246
TURNED_RAD = np.radians([10.0, 80.0])
NEAR_RAD = np.radians(5.0)

Say = Callable[[str], None]


@dataclass(frozen=True, eq=False)
class Targets:
    """Poses, one per row. `best` is what no solver can beat; its meaning is the set's."""

    position: Array  # (k, 3)
    rotation: Array  # (k, 3, 3)
    near: Array  # (k, n): a start close to the posture that the pose was made from
    best: Array  # (k,): objective, angle [rad] or distance [m]

    def __len__(self) -> int:
        return len(self.best)


@dataclass(frozen=True)
class Sizes:
    """How many of everything."""

    reachable: int = 500
    unreachable: int = 100
    objective_starts: int = 60
    starts: int = 30


SHORT = Sizes(60, 20, 12, 12)


def reachable(arm: Arm, seed: int, sizes: Sizes, say: Say) -> Targets:
    """Poses of random postures; best = lowest objective of many starts with x = 0."""

    def make() -> Targets:
        rng = np.random.default_rng([seed, 1])
        nlp = PlainNlp(arm, Form.EXACT, "fatrop")
        made: list[_Made] = []
        for q in arm.postures(rng, sizes.reachable):
            R, p = arm.pose(q)
            starts = arm.postures(rng, sizes.objective_starts - 1)
            costs = [
                arm.objective(found, R)
                for found in (nlp.solve(p, R, start) for start in (q, *starts))
                if _holds(arm, found, p)
            ]
            near = arm.inside(q + rng.normal(0.0, NEAR_RAD, arm.n))
            made.append((p, R, near, min([*costs, arm.objective(q, R)])))
        return _collected(made)

    return _kept(arm, "reachable", seed, sizes, say, make)


def orientation_out(arm: Arm, seed: int, sizes: Sizes, say: Say) -> Targets:
    """Positions in reach whose orientation is not; best = smallest angle of many starts."""

    def make() -> Targets:
        rng = np.random.default_rng([seed, 2])
        nlp = PlainNlp(arm, Form.EXACT, "fatrop")

        def angle(p: Array, R: Array, starts: Array) -> float:
            ends = [nlp.solve(p, R, start) for start in starts]
            return min((arm.angle_rad(q, R) for q in ends if _holds(arm, q, p)), default=np.inf)

        made: list[_Made] = []
        while len(made) < sizes.unreachable:
            q = arm.postures(rng, 1)[0]
            R, p = arm.pose(q)
            R = _turned(rng, R)
            near = arm.inside(q + rng.normal(0.0, NEAR_RAD, arm.n))
            if angle(p, R, np.vstack([q, arm.postures(rng, FEW_STARTS)])) < LEAST_ANGLE:
                continue
            best = angle(p, R, np.vstack([q, arm.postures(rng, sizes.starts)]))
            if LEAST_ANGLE <= best <= MOST_ANGLE:
                made.append((p, R, near, best))
        return _collected(made)

    return _kept(arm, "orientation", seed, sizes, say, make)


def position_out(arm: Arm, seed: int, sizes: Sizes, say: Say) -> Targets:
    """Positions beyond reach; best = smallest distance of many starts."""

    def make() -> Targets:
        rng = np.random.default_rng([seed, 3])
        nlp = PlainNlp(arm, Form.NEAREST)
        shoulder = arm.pose(arm.rest)[1] - np.array([-0.25, 0.0, 0.0])

        def distance(p: Array, R: Array, starts: Array) -> float:
            ends = [nlp.solve(p, R, start) for start in starts]
            return min(arm.distance_m(q, p) for q in ends)

        made: list[_Made] = []
        while len(made) < sizes.unreachable:
            q = arm.postures(rng, 1)[0]
            R, p = arm.pose(q)
            outwards = p - shoulder + rng.normal(0.0, 0.1, 3)
            p = p + rng.uniform(0.02, 0.4) * outwards / np.linalg.norm(outwards)
            near = arm.inside(q + rng.normal(0.0, NEAR_RAD, arm.n))
            few = np.vstack([q, arm.postures(rng, FEW_STARTS)])
            if not LEAST_M <= distance(p, R, few) <= MOST_M:
                continue
            best = distance(p, R, arm.postures(rng, sizes.starts))
            if best >= LEAST_M:
                made.append((p, R, near, best))
        return _collected(made)

    return _kept(arm, "position", seed, sizes, say, make)


_Made = tuple[Array, Array, Array, float]


def _collected(made: list[_Made]) -> Targets:
    p, R, near, best = zip(*made, strict=True)
    return Targets(np.array(p), np.array(R), np.array(near), np.array(best))


def _holds(arm: Arm, q: Array, p: Array) -> bool:
    return arm.distance_m(q, p) <= REACHED_M and arm.violation(q) <= REACHED_M


def _turned(rng: np.random.Generator, R: Array) -> Array:
    """By 10..80 degrees about any axis."""
    axis = rng.normal(size=3)
    turn = pin.exp3(rng.uniform(*TURNED_RAD) * axis / np.linalg.norm(axis))
    found: Array = turn @ R
    return found


def _kept(
    arm: Arm, name: str, seed: int, sizes: Sizes, say: Say, make: Callable[[], Targets]
) -> Targets:
    names = [field.name for field in fields(Targets)]

    def made() -> dict[str, Array]:
        say(f"{arm.name}, seed {seed}: looking for the best answers ({name}), once ...")
        targets = make()
        return {field: getattr(targets, field) for field in names}

    return Targets(**kept(arm, name, (VERSION, seed, sizes), made))
