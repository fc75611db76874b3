"""Time of one posture's distances in compiled code, and beside it of an empty call from Python.

The whole iCub among random obstacles in front of it; microseconds, the best of several.
"""

import argparse
import timeit
from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from dforc.arrays import Matrix, Vector
from dforc.collision.body import BodyArrays
from dforc.collision.kernel_body import Mask, clearance, place_body, proximities
from dforc.collision.obstacles import Obstacle, World, box, cylinder, ellipsoid, sphere, world_of
from dforc.compiled import compiled
from services.config import load_robot
from services.fields.robot_body import robot_body

POSTURES, REPEATS, ROWS = 500, 15, 40
MARGIN_M, SELF_MARGIN_M = 0.02, 0.01
REACH_M, SELF_REACH_M = 0.15, 0.10


@compiled
def place_all(q: Matrix, body: BodyArrays, frames: Matrix, segments: Matrix) -> None:
    """Only where everything is."""
    for k in range(len(q)):
        place_body(q[k], body, frames, segments)


@compiled
def clear_all(
    q: Matrix,
    body: BodyArrays,
    world: World,
    mask: Mask,
    frames: Matrix,
    segments: Matrix,
    stop_below: float,
) -> float:
    """Sum of the clearances."""
    total = 0.0
    for k in range(len(q)):
        total += clearance(
            q[k], body, world, mask, frames, segments, MARGIN_M, SELF_MARGIN_M, stop_below
        )
    return total


@compiled
def near_all(
    q: Matrix,
    body: BodyArrays,
    world: World,
    mask: Mask,
    frames: Matrix,
    segments: Matrix,
    distances: Vector,
    gradients: Matrix,
    drifts: Vector,
    which: NDArray[np.int64],
) -> int:
    """Number of all rows."""
    count = 0
    for k in range(len(q)):
        count += proximities(
            q[k],
            body,
            world,
            mask,
            REACH_M,
            SELF_REACH_M,
            frames,
            segments,
            distances,
            gradients,
            drifts,
            which,
        )
    return count


def obstacles(count: int, kinds: str) -> list[Obstacle]:
    """In front of the robot, 2 to 8 cm large."""
    rng = np.random.default_rng(3)
    made: list[Obstacle] = []
    for number in range(count):
        x, y, z = rng.uniform([-0.5, -0.4, -0.1], [-0.15, 0.4, 0.4]).tolist()
        a, b, c = rng.uniform(0.02, 0.08, 3).tolist()
        made.append(
            {
                "s": sphere(str(number), (x, y, z), a),
                "e": ellipsoid(str(number), (x, y, z), (a, b, c)),
                "b": box(str(number), (x, y, z), (a, b, c)),
                "c": cylinder(str(number), (x, y, z), a, b),
            }[kinds[number % len(kinds)]]
        )
    return made


def least_us(call: Callable[[], object], postures: int = POSTURES) -> float:
    """Microseconds per posture."""
    call()
    return min(timeit.repeat(call, number=1, repeat=REPEATS)) / postures * 1e6


def main() -> int:
    """Print a line for each kind of obstacles."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--obstacles", type=int, default=10)
    options = parser.parse_args()
    robot = load_robot("icub")
    body = robot_body(robot)
    arrays, n, c = body.arrays, len(body.joints), len(body.capsules)
    limits = np.radians([robot.joints[name].limits_deg for name in body.joints])
    q = np.random.default_rng(1).uniform(limits[:, 0], limits[:, 1], (POSTURES, n))
    frames, segments, mask = np.zeros((n, 12)), np.zeros((c, 6)), body.moved_by(body.joints)
    distances, gradients, drifts = np.zeros(ROWS), np.zeros((ROWS, n)), np.zeros(ROWS)
    which = np.zeros((ROWS, 2), dtype=np.int64)
    nobody = q[:0]
    print(f"{c} capsules, {len(arrays.pairs)} pairs, {options.obstacles} obstacles")
    print(f"place {least_us(lambda: place_all(q, arrays, frames, segments)):.2f} us")
    for kinds in ("s", "e", "b", "c", "sebc"):
        world = world_of(obstacles(options.obstacles, kinds))

        def clear(chosen: Matrix, stop_below: float, world: World = world) -> float:
            return clear_all(chosen, arrays, world, mask, frames, segments, stop_below)

        def near(world: World = world) -> int:
            return near_all(
                q, arrays, world, mask, frames, segments, distances, gradients, drifts, which
            )

        print(
            f"{kinds:4s} clearance {least_us(lambda: clear(q, -np.inf)):.2f}, "
            f"is it free {least_us(lambda: clear(q, 0.0)):.2f}, "
            f"proximities {least_us(near):.2f} with {near() / POSTURES:.0f} rows, "
            f"an empty call {least_us(lambda: clear(nobody, 0.0), 1):.2f} us"
        )
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
