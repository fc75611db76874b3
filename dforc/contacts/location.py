"""Where a limb is touched, from the wrench at its sensor and the shapes of its links.

A pure force f whose moment about a known point is m acts somewhere on the line

    r(s) = f x m / |f|^2 + s f / |f|        (from the known point)

The world pushes: the line enters a link's surface there, within the friction cone about the inward
normal. Where the line enters one link only, that is the one; else the answer is "unsure".

Every link gets a share of the evidence. The line is drawn again for LINES deviations of force and
moment as large as their noise (and of the line as large as the shapes' error); each entry
counts with w / cos(angle), the density of lines through a surface that is touched anywhere with
equal chance and from any direction of the cone. The share is sure from SURE upwards. A moment
along the force that the noise does not explain is not from a pure force: "unsure", too.
"""

import math
from dataclasses import dataclass
from typing import Literal, NamedTuple

import numpy as np
from numpy.typing import NDArray

from dforc.arrays import ArrayLike, Matrix, Vector, constant, finite_vector
from dforc.contacts.shapes import PosedShapes

Certainty = Literal["sure", "unsure"]

LINES = 32
LEAST_LINES = 8  # that enter the link, else the noise has the answer
SURE = 0.8
CONE_RAD = math.radians(35.0)  # friction coefficient 0.7, rubber on most things
CONE_EDGE_RAD = math.radians(8.0)  # a capsule's normal is that far from the surface's
GRAZING = 0.1  # cosine below which a line enters nothing
SHAPE_ERROR_M = 0.004
BURIED_M = 0.006  # a surface so deep inside another link cannot be touched
NO_TURN = 4.0  # standard deviations of the moment along the force that still count as noise
LEAST_FORCE_N = 1.0
ROUNDING_M = 1e-6
ELSEWHERE = (
    0.01  # evidence for something that has no shape here, of each line: a push at 70 degrees
)


@dataclass(frozen=True, slots=True, kw_only=True)
class WrenchNoise:
    """Standard deviation of each component; residual of the model included."""

    force_n: float = 0.05
    moment_nm: float = 0.002


@dataclass(frozen=True, slots=True, eq=False)
class Location:
    """The likeliest place of a contact; no link and the known point where there is none."""

    link: str
    point_m: Vector  # (3,), on the surface, frame of the shapes
    certainty: Certainty
    share: float  # of the evidence, 0 to 1
    reason: str = ""  # why it is unsure


SENSOR_NOISE = WrenchNoise()


def locate(
    force_n: ArrayLike,
    moment_nm: ArrayLike,
    at_m: ArrayLike,
    shapes: PosedShapes,
    noise: WrenchNoise = SENSOR_NOISE,
) -> Location:
    """Where a pure force acts.

    Args:
        force_n: what the world exerts on the limb beyond the sensor (3,).
        moment_nm: its moment about `at_m` (3,).
        at_m: the known point, the sensor's origin (3,).
        shapes: of the links beyond the sensor; all in one frame.
        noise: of force and moment.

    Raises:
        NotFiniteError: NaN or infinity in the wrench or the point.
    """
    wrench = finite_vector("wrench", np.concatenate([force_n, moment_nm]), 6)
    at = finite_vector("known point", at_m, 3)
    force, moment = wrench[:3], wrench[3:]
    size = math.sqrt(force @ force)
    if size < max(LEAST_FORCE_N, 4.0 * noise.force_n):
        return Location("", at, "unsure", 0.0, "the force is too small")
    along = force / size
    turn = float(along @ moment)
    lever = math.sqrt(max(float(moment @ moment) - turn * turn, 0.0)) / size
    if abs(turn) > NO_TURN * math.hypot(noise.moment_nm, noise.force_n * lever):
        return Location("", at, "unsure", 0.0, "not a pure force: it turns about itself")
    points, directions = _lines(force, moment, at, noise)
    return _judge(shapes, _entries(points, directions, shapes), at)


def _judge(shapes: PosedShapes, entries: "_Entries", at: Vector) -> Location:
    """The link with the largest share of the weights."""
    link_at = shapes.link_at[entries.capsule]
    evidence = np.bincount(link_at, weights=entries.weight, minlength=len(shapes.links))
    best = int(evidence.argmax())
    if evidence[best] <= 0.0:
        return Location("", at, "unsure", 0.0, "the line of the force enters no link")
    share = float(evidence[best] / (evidence.sum() + ELSEWHERE * LINES))
    own = entries.weight * (link_at == best)
    point: Vector = own @ entries.point_m / own.sum()
    link = shapes.links[best]
    if len(np.unique(entries.line[own > 0.0])) < LEAST_LINES:
        return Location(link, point, "unsure", share, "the line of the force is too uncertain")
    if share < SURE:
        return Location(link, point, "unsure", share, "the line of the force enters several links")
    return Location(link, point, "sure", share)


def _deviations() -> Matrix:
    """LINES standard normal deviations of force, moment and line (9), in opposite pairs."""
    half = np.random.default_rng(0).standard_normal((LINES // 2, 9))
    half[0] = 0.0
    return constant(np.vstack([half, -half]))


DEVIATIONS = _deviations()


def _lines(force: Vector, moment: Vector, at: Vector, noise: WrenchNoise) -> tuple[Matrix, Matrix]:
    """Points and unit directions (LINES, 3) of the line of the force, as noise may have it."""
    f = force + noise.force_n * DEVIATIONS[:, :3]
    m = moment + noise.moment_nm * DEVIATIONS[:, 3:6]
    size2 = (f * f).sum(axis=1)
    points = at + np.cross(f, m) / size2[:, None] + SHAPE_ERROR_M * DEVIATIONS[:, 6:]
    return points, f / np.sqrt(size2)[:, None]


class _Entries(NamedTuple):
    """Where lines enter capsules, one row for each pair that meets."""

    line: NDArray[np.intp]
    capsule: NDArray[np.intp]
    point_m: Matrix  # (rows, 3)
    weight: Vector


def _entries(points: Matrix, directions: Matrix, shapes: PosedShapes) -> _Entries:
    """Every first crossing of a line with a capsule, and what it weighs."""
    s, hit = _first_crossing(points, directions, shapes)
    line, capsule = np.nonzero(hit)
    direction = directions[line]
    entry = points[line] + s[line, capsule, None] * direction
    outwards, depth = _surface(entry, capsule, shapes)
    cosine = np.clip(-(outwards * direction).sum(axis=1), -1.0, 1.0)
    inside = 1.0 / (1.0 + np.exp((np.arccos(cosine) - CONE_RAD) / CONE_EDGE_RAD))
    same_link = shapes.link_at[capsule, None] == shapes.link_at
    limit = np.where(same_link, ROUNDING_M, BURIED_M)  # of one link, only the outer surface is one
    free = ~(depth > limit).any(axis=1)
    weight = np.where(free & (cosine > GRAZING), inside / np.maximum(cosine, GRAZING), 0.0)
    return _Entries(line, capsule, entry, weight)


def _surface(
    entry: Matrix, capsule: NDArray[np.intp], shapes: PosedShapes
) -> tuple[Matrix, Matrix]:
    """Outward normals (rows, 3) at the entries, and how deep these are in each capsule."""
    axis = shapes.end_m - shapes.start_m
    length2 = np.maximum((axis * axis).sum(axis=1), 1e-18)
    # |entry - start|^2 and its part along the axis, without an array of (rows, capsules, 3)
    shift = -(shapes.start_m * axis).sum(axis=1)
    share = np.clip((entry @ axis.T + shift) / length2, 0.0, 1.0)
    from_start = (
        (entry * entry).sum(axis=1)[:, None]
        - 2.0 * entry @ shapes.start_m.T
        + (shapes.start_m * shapes.start_m).sum(axis=1)
    )
    along = (entry @ axis.T + shift) * share
    distance = np.sqrt(np.maximum(from_start - 2.0 * along + share * share * length2, 0.0))
    rows = np.arange(len(entry))
    foot = shapes.start_m[capsule] + share[rows, capsule, None] * axis[capsule]
    outwards = (entry - foot) / shapes.radius_m[capsule, None]
    return outwards, shapes.radius_m - distance


def _first_crossing(
    points: Matrix, directions: Matrix, shapes: PosedShapes
) -> tuple[Matrix, NDArray[np.bool_]]:
    """Parameter of the first point that lines and capsules share (lines, capsules), and if any."""
    s_start, at_start = _ball_crossing(points, directions, shapes.start_m, shapes.radius_m)
    s_end, at_end = _ball_crossing(points, directions, shapes.end_m, shapes.radius_m)
    s_side, at_side = _side_crossing(points, directions, shapes)
    s = np.minimum(
        np.where(at_side, s_side, np.inf),
        np.minimum(np.where(at_start, s_start, np.inf), np.where(at_end, s_end, np.inf)),
    )
    hit = np.isfinite(s)
    return np.where(hit, s, 0.0), hit


def _ball_crossing(
    points: Matrix, directions: Matrix, centres: Matrix, radius: Vector
) -> tuple[Matrix, NDArray[np.bool_]]:
    from_centre = points[:, None, :] - centres
    b = (from_centre * directions[:, None, :]).sum(axis=2)
    root = b * b - (from_centre * from_centre).sum(axis=2) + radius * radius
    return -b - np.sqrt(np.maximum(root, 0.0)), root >= 0.0


def _side_crossing(
    points: Matrix, directions: Matrix, shapes: PosedShapes
) -> tuple[Matrix, NDArray[np.bool_]]:
    """With the cylinder about the axis, between its ends."""
    axis = shapes.end_m - shapes.start_m
    length = np.maximum(np.sqrt((axis * axis).sum(axis=1)), 1e-9)
    unit = axis / length[:, None]
    from_start = points[:, None, :] - shapes.start_m
    d_along = directions @ unit.T
    p_along = (from_start * unit).sum(axis=2)
    a = np.maximum(1.0 - d_along * d_along, 1e-12)
    b = (from_start * directions[:, None, :]).sum(axis=2) - d_along * p_along
    c = (from_start * from_start).sum(axis=2) - p_along * p_along - shapes.radius_m**2
    root = b * b - a * c
    s = (-b - np.sqrt(np.maximum(root, 0.0))) / a
    height = p_along + s * d_along
    return s, (root >= 0.0) & (height >= 0.0) & (height <= length)
