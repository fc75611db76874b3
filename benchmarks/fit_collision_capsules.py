"""Fit capsules that hold the links of a robot and print them as the table collision.toml.

The rule, for each body below: all triangles of its links' visual meshes, in the axes of the link
that carries it; cut in as many pieces as it gets capsules, along one of its principal axes; around
each piece the capsule of least volume; of all cuts the one whose capsules together take the least
room. Each triangle lies in one capsule, so nothing sticks out. Of two sides the right one is
fitted, to itself and to the mirror image of the left one, and mirrored. A shoulder's discs turn
about its centre and are held by a ball around it.
"""

import argparse
import math
import sys
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import combinations
from pathlib import Path

import numpy as np
import pinocchio as pin
from scipy.optimize import minimize
from scipy.spatial import ConvexHull

from benchmarks.link_meshes import Mesh, load_meshes
from dforc.arrays import Matrix, Vector
from dforc.compiled import compiled
from services.robotfile.model_file import urdf_path

STEP_M = 1e-4  # of the printed numbers; radii are rounded up
CUTS = np.linspace(0.15, 0.85, 8)  # of the length along an axis
SEARCH, REFINE = (1, 200), (3, 3000)  # starts and evaluations of a fit
ROUNDS = 3  # each from where the one before ended, with a fresh simplex
ROOM_POINTS = 5000
LEAST_CORNERS = 30  # of a piece


@dataclass(frozen=True, slots=True)
class Part:
    """What gets capsules; `side` stands for l and r where there are two."""

    name: str
    carrier: str  # link in whose axes they are
    links: tuple[str, ...]  # whose meshes they hold, with all joints between them at zero
    capsules: int
    centre: str = ""  # of a ball around the origin of this link, whose turns it is held for


PARTS = (
    Part("root", "root_link", ("root_link",), 1),
    Part("pelvis", "torso_1", ("torso_1",), 2),
    Part("chest", "chest", ("chest",), 1),
    Part("head", "head", ("neck_1", "neck_2", "head"), 2),
    Part(
        "{side}_shoulder",
        "chest",
        ("{side}_shoulder_1", "{side}_shoulder_2"),
        1,
        "{side}_shoulder_1",
    ),
    Part("{side}_upper_arm", "{side}_upper_arm", ("{side}_upper_arm",), 1),
    Part("{side}_forearm", "{side}_forearm", ("{side}_forearm",), 1),
    Part("{side}_hand", "{side}_hand", ("{side}_hand",), 1),
    Part(
        "{side}_thigh", "{side}_upper_leg", ("{side}_hip_1", "{side}_hip_2", "{side}_upper_leg"), 1
    ),
)


@compiled
def radius_around(ends: Vector, points: Matrix) -> float:
    """Of the capsule with these ends (6,) that holds all points (k, 3)."""
    ax, ay, az = ends[3] - ends[0], ends[4] - ends[1], ends[5] - ends[2]
    length2 = max(ax * ax + ay * ay + az * az, 1e-12)
    most = 0.0
    for i in range(len(points)):
        x, y, z = points[i, 0] - ends[0], points[i, 1] - ends[1], points[i, 2] - ends[2]
        share = min(max((x * ax + y * ay + z * az) / length2, 0.0), 1.0)
        x, y, z = x - share * ax, y - share * ay, z - share * az
        most = max(most, x * x + y * y + z * z)
    return math.sqrt(most)


def volume(ends: Vector, points: Matrix) -> float:
    """Litres of that capsule."""
    radius = radius_around(ends, points)
    length = math.dist(ends[:3], ends[3:])
    return 1e3 * math.pi * radius * radius * (length + radius * 4.0 / 3.0)


def hull_points(points: Matrix) -> Matrix:
    """The corners of their convex hull."""
    corners: Matrix = points[ConvexHull(points).vertices]
    return corners


def fitted(points: Matrix, starts: int, evaluations: int) -> Vector:
    """Ends (6,) of the least capsule around some points: the best from one start or three."""
    hull = hull_points(points)
    centre = hull.mean(axis=0)
    axes = np.linalg.svd(hull - centre, full_matrices=False)[2]
    options = {"maxfev": evaluations, "xatol": 1e-6, "fatol": 1e-9}
    found = []
    for axis in axes[:starts]:
        along = (hull - centre) @ axis
        first = np.concatenate([centre + 0.5 * x * axis for x in (along.min(), along.max())])
        for _ in range(ROUNDS):
            first = minimize(volume, first, args=(hull,), method="Nelder-Mead", options=options).x
        found.append(first)
    return min(found, key=lambda ends: volume(ends, hull))


def rounded(ends: Vector, points: Matrix) -> Vector:
    """Ends and radius (7,) as printed."""
    ends = np.round(ends / STEP_M) * STEP_M
    radius = np.ceil(radius_around(ends, points) / STEP_M) * STEP_M
    return np.array([*ends, radius])


def distance_to(capsules: Matrix, points: Matrix) -> Vector:
    """Of points (k, 3) to the surface of the nearest of some capsules (c, 7), negative inside."""
    a, axis = capsules[:, :3], capsules[:, 3:6] - capsules[:, :3]
    from_a = points[:, None, :] - a
    length2 = np.maximum((axis * axis).sum(axis=1), 1e-12)
    share = np.clip((from_a * axis).sum(axis=2) / length2, 0.0, 1.0)
    away = np.linalg.norm(from_a - share[..., None] * axis, axis=2) - capsules[:, 6]
    nearest: Vector = away.min(axis=1)
    return nearest


def pieces(mesh: Mesh, count: int) -> list[list[Matrix]]:
    """All the ways to cut: for each the points (k, 3) of its pieces."""
    middles = mesh.corners_m.mean(axis=1)
    if count == 1:
        return [[mesh.corners_m.reshape(-1, 3)]]
    axes = np.linalg.svd(middles - middles.mean(axis=0), full_matrices=False)[2]
    ways = []
    for axis in axes:
        along = middles @ axis
        low, high = along.min(), along.max()
        for cuts in combinations(low + CUTS * (high - low), count - 1):
            number = np.searchsorted(np.array(cuts), along)
            ways.append([mesh.corners_m[number == i].reshape(-1, 3) for i in range(count)])
    return [way for way in ways if all(len(piece) >= LEAST_CORNERS for piece in way)]


def fit(mesh: Mesh, count: int) -> Matrix:
    """Capsules (count, 7) of one body, as the rule says."""
    points = mesh.corners_m.reshape(-1, 3)
    low, high = points.min(axis=0) - 0.1, points.max(axis=0) + 0.1
    somewhere = np.random.default_rng(1).uniform(low, high, size=(ROOM_POINTS, 3))

    def room(way: Sequence[Matrix], starts: int, evaluations: int) -> tuple[float, Matrix]:
        capsules = np.array([rounded(fitted(piece, starts, evaluations), piece) for piece in way])
        return float((distance_to(capsules, somewhere) < 0.0).mean()), capsules

    ways = pieces(mesh, count)
    rooms = [room(way, *SEARCH)[0] for way in ways]
    return room(ways[int(np.argmin(rooms))], *REFINE)[1]


class Model:
    """Meshes and poses of the links with all joints at zero."""

    def __init__(self, urdf: Path) -> None:
        self._model = pin.buildModelFromUrdf(str(urdf))
        data = self._model.createData()
        pin.framesForwardKinematics(self._model, data, pin.neutral(self._model))
        self._placed = data.oMf
        self._meshes = load_meshes(urdf)

    def pose(self, link: str) -> tuple[Matrix, Vector]:
        """Rotation and position of a link in the base."""
        placed = self._placed[self._model.getFrameId(link)]
        return placed.rotation, placed.translation

    def mesh(self, part: Part, side: str) -> Mesh:
        """Meshes of a part's links, in the axes of its carrier."""
        R, p = self.pose(part.carrier.format(side=side))
        moved = []
        for link in part.links:
            R_link, p_link = self.pose(link.format(side=side))
            moved.append(
                self._meshes[link.format(side=side)].moved(R.T @ R_link, R.T @ (p_link - p))
            )
        return Mesh(np.concatenate([one.corners_m for one in moved]))

    def mirrored(self, part: Part, points: Matrix, side: str, onto: str) -> Matrix:
        """Mirror image of points (..., 3): from the axes of one side's carrier to the other's."""
        R, p = self.pose(part.carrier.format(side=side))
        R_onto, p_onto = self.pose(part.carrier.format(side=onto))
        image: Matrix = ((points @ R.T + p) * [1.0, -1.0, 1.0] - p_onto) @ R_onto
        return image


def capsules_of(model: Model, part: Part) -> dict[str, tuple[Matrix, Mesh]]:
    """Capsules (c, 7) and mesh of a part, or of both sides of one."""
    if "{side}" not in part.name:
        mesh = model.mesh(part, "")
        return {"": (fit(mesh, part.capsules), mesh)}
    left, right = model.mesh(part, "l"), model.mesh(part, "r")
    both = Mesh(np.concatenate([right.corners_m, model.mirrored(part, left.corners_m, "l", "r")]))
    points = both.corners_m.reshape(-1, 3)
    if part.centre:
        R, p = model.pose(part.carrier)
        centre = R.T @ (model.pose(part.centre.format(side="r"))[1] - p)
        found = np.array([rounded(np.tile(centre, 2), points)])
    else:
        found = fit(both, part.capsules)
    ends = model.mirrored(part, found[:, :6].reshape(-1, 3), "r", "l").reshape(-1, 6)
    # Rounded once more, so once more grown by what that may take: half a step on each axis.
    grown = np.ceil((found[:, 6:] + STEP_M) / STEP_M) * STEP_M
    image = np.hstack([np.round(ends / STEP_M) * STEP_M, grown])
    return {"l": (image, left), "r": (found, right)}


def table(name: str, link: str, row: Vector) -> str:
    """One capsule."""
    ends = [f"[{', '.join(f'{x + 0.0:.4f}' for x in end)}]" for end in (row[:3], row[3:6])]
    lines = (f'name = "{name}"', f'link = "{link}"', f"start_m = {ends[0]}", f"end_m = {ends[1]}")
    return "\n".join(("[[capsules]]", *lines, f"radius_m = {row[6]:.4f}\n"))


def main() -> int:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("model", help="name in icub-models")
    parser.add_argument("parts", nargs="*", help="only these")
    options = parser.parse_args()
    model = Model(Path(urdf_path(options.model)))
    for part in PARTS:
        if options.parts and part.name.removeprefix("{side}_") not in options.parts:
            continue
        for side, (capsules, mesh) in capsules_of(model, part).items():
            below = -distance_to(capsules, hull_points(mesh.corners_m.reshape(-1, 3)))
            name = part.name.format(side=side)
            print(
                f"# {name}: corners of its hull are {below.mean() * 1e3:.0f} mm inside on average, "
                f"{below.min() * 1e3:.1f} to {below.max() * 1e3:.0f}"
            )
            print(f"{name} done", file=sys.stderr, flush=True)
            for number, row in enumerate(capsules):
                numbered = name if len(capsules) == 1 else f"{name}_{number + 1}"
                print(table(numbered, part.carrier.format(side=side), row), flush=True)
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
