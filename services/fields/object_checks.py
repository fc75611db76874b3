"""What an object has to be to be taken."""

import math
from collections.abc import Iterable

import numpy as np

from dforc.errors import DforcError
from services.core.errors import ConfigError
from services.fields.seen import MESH, SHAPE_NAMES, solid_of
from services.messages import Objects, WorldObject

ROLES = ("obstacle", "target")
LARGEST_M = 5.0  # of a size: what is larger is no object that a hand goes around
FARTHEST_M = 100.0
FASTEST_M_S = 20.0
WORST_SIGMA_M = 0.5  # beyond it the place is not known
MOST_VERTICES = 100_000
LONGEST_NAME = 64
MOST_OBJECTS = 64  # of all sources together: each costs time in every period


def check_object(item: WorldObject) -> None:
    """Refuse an object that is none.

    Raises:
        ConfigError: with its name, and what is wrong.
    """
    called = f"object {item.name!r}"
    if not item.name or len(item.name) > LONGEST_NAME or "/" in item.name:
        raise ConfigError(f"{called}: a name has 1 to {LONGEST_NAME} letters and no '/'")
    if item.shape not in SHAPE_NAMES:
        raise ConfigError(
            f"{called}: unknown shape {item.shape!r}; known: {', '.join(SHAPE_NAMES)}"
        )
    if item.seen_ns < 0:
        raise ConfigError(f"{called}: seen_ns of {item.seen_ns} is before all time")
    if item.role not in ROLES:
        raise ConfigError(f"{called}: unknown role {item.role!r}; known: {', '.join(ROLES)}")
    for name, values, most in (
        ("position_m", item.position_m, FARTHEST_M),
        ("rotation_rad", item.rotation_rad, math.inf),
        ("velocity_m_s", item.velocity_m_s or (), FASTEST_M_S),
        ("size_m", item.size_m, LARGEST_M),
    ):
        _check_numbers(f"{called}: {name}", values, most)
    if item.shape == MESH:
        _check_vertices(called, item)
    if item.covariance_m2 is not None:
        _check_covariance(called, item.covariance_m2)
    try:
        solid_of(item)
    except DforcError as error:
        raise ConfigError(str(error)) from error


def as_objects(message: Objects) -> tuple[WorldObject, ...]:
    """All of a message as objects; balls of the short form are called 'ball 1', 'ball 2'."""
    balls = (
        WorldObject(
            name=f"ball {number}",
            shape="sphere",
            size_m=(ball.radius_m,),
            position_m=ball.centre_m,
            velocity_m_s=(0.0, 0.0, 0.0),
        )
        for number, ball in enumerate(message.obstacles, 1)
    )
    return (*balls, *message.objects)


def _check_numbers(what: str, values: Iterable[float], most: float) -> None:
    for value in values:
        if not math.isfinite(value):
            raise ConfigError(f"{what} is not finite")
        if abs(value) > most:
            raise ConfigError(f"{what} of {value:g} is beyond {most:g}")


def _check_vertices(called: str, item: WorldObject) -> None:
    if not 0 < len(item.vertices_m) <= MOST_VERTICES:
        raise ConfigError(f"{called}: a mesh has 1 to {MOST_VERTICES} vertices_m")
    for vertex in item.vertices_m:
        _check_numbers(f"{called}: vertices_m", vertex, LARGEST_M)


def _check_covariance(called: str, covariance_m2: tuple[float, ...]) -> None:
    if len(covariance_m2) != 6:
        raise ConfigError(f"{called}: covariance_m2 has 6 numbers: xx, xy, xz, yy, yz, zz")
    _check_numbers(f"{called}: covariance_m2", covariance_m2, math.inf)
    variances = np.linalg.eigvalsh(covariance_matrix(covariance_m2))
    if variances[0] < -1e-12:
        raise ConfigError(f"{called}: covariance_m2 has a negative variance")
    if variances[2] > WORST_SIGMA_M**2:
        sigma_m = math.sqrt(variances[2])
        raise ConfigError(f"{called}: a place known to {sigma_m:.2g} m (sigma) is not known")


def covariance_matrix(
    covariance_m2: tuple[float, ...],
) -> np.ndarray[tuple[int, int], np.dtype[np.float64]]:
    """The symmetric matrix (3, 3) of its six numbers."""
    xx, xy, xz, yy, yz, zz = covariance_m2
    return np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
