"""Fit capsules to the meshes of a robot's links and print them as the table shapes.toml.

The rule, for each link with a mesh: POINTS points of its outer surface; one, two, ... MOST capsules
whose union has the least mean square distance to them and keeps inside the mesh's box, from several
starts; of these counts the smallest whose root mean square is within GOOD_M, else the best.
"""

import argparse
import sys
from pathlib import Path

import numpy as np
from scipy.optimize import least_squares

from benchmarks.link_meshes import Mesh, load_meshes
from dforc.arrays import Matrix, Vector
from services.robotfile.model_file import urdf_path

POINTS = 500
MOST = 4
GOOD_M = 0.003
STARTS = 6
LEAST_RADIUS_M = 0.004
BOX_WEIGHT = 20.0  # so strongly capsules are kept inside the box of the mesh, like so many points


def distances(parameters: Vector, points: Matrix) -> Vector:
    """From each point to the surface of the union of capsules [m], negative inside."""
    a, b = parameters.reshape(-1, 7)[:, :3], parameters.reshape(-1, 7)[:, 3:6]
    radius = parameters.reshape(-1, 7)[:, 6]
    axis = b - a
    length2 = np.maximum((axis * axis).sum(axis=1), 1e-12)
    from_a = points[:, None, :] - a
    share = np.clip((from_a * axis).sum(axis=2) / length2, 0.0, 1.0)
    away = from_a - share[..., None] * axis
    apart: Vector = (np.sqrt((away * away).sum(axis=2) + 1e-12) - radius).min(axis=1)
    return apart


def misfit(parameters: Vector, points: Matrix, low: Vector, high: Vector) -> Vector:
    """Distances, and by how much each end's ball leaves the box of the mesh on each axis."""
    rows = parameters.reshape(-1, 7)
    ends, radius = rows[:, :6].reshape(-1, 2, 3), rows[:, 6, None, None]
    beyond = np.maximum(ends + radius - high, 0.0) + np.maximum(low - ends + radius, 0.0)
    return np.concatenate([distances(parameters, points), BOX_WEIGHT * beyond.ravel()])


def start(points: Matrix, count: int, generator: np.random.Generator) -> Vector:
    """Capsules between random points, a third of the link thick."""
    spread = points.std(axis=0)
    rows = []
    for _ in range(count):
        middle = points[generator.integers(len(points), size=12)].mean(axis=0)
        half = generator.normal(size=3) * spread
        rows.append([*(middle - half), *(middle + half), float(np.sort(spread)[1])])
    return np.array(rows).ravel()


def fitted(points: Matrix, count: int, generator: np.random.Generator) -> tuple[float, Vector]:
    """Root mean square [m] and the capsules (7 numbers each) of the best of STARTS fits."""
    box = (points.min(axis=0), points.max(axis=0))
    low = np.tile([-np.inf] * 6 + [LEAST_RADIUS_M], count)
    best = (np.inf, np.empty(0))
    for _ in range(STARTS):
        first = np.maximum(start(points, count, generator), low)
        bounds = (low, np.full(7 * count, np.inf))
        found = least_squares(misfit, first, bounds=bounds, args=(points, *box), max_nfev=60)
        rms = float(np.sqrt(np.sum(found.fun**2) / len(points)))
        if rms < best[0]:
            best = (rms, found.x)
    return best


def fit(mesh: Mesh, generator: np.random.Generator) -> tuple[float, Vector]:
    """Root mean square and capsules of one link, as the rule says."""
    points, _ = mesh.touchable_points(POINTS, generator)
    best = (np.inf, np.empty(0))
    for count in range(1, MOST + 1):
        found = fitted(points, count, generator)
        if found[0] < best[0]:
            best = found
        if best[0] <= GOOD_M:
            break
    return best


def main() -> int:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("model", help="name in icub-models")
    parser.add_argument("links", nargs="*", help="only these links")
    options = parser.parse_args()
    generator = np.random.default_rng(1)
    for link, mesh in load_meshes(Path(urdf_path(options.model))).items():
        if options.links and link not in options.links:
            continue
        rms, capsules = fit(mesh, generator)
        print(f"{link}: {rms * 1e3:.1f} mm", file=sys.stderr, flush=True)
        print(f"# {link}: root mean square distance to the mesh {rms * 1e3:.1f} mm")
        for row in capsules.reshape(-1, 7):
            ends = [f"[{', '.join(f'{x:.4f}' for x in end)}]" for end in (row[:3], row[3:6])]
            print(f'[[shapes]]\nlink = "{link}"\nstart_m = {ends[0]}\nend_m = {ends[1]}')
            print(f"radius_m = {row[6]:.4f}\n")
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
