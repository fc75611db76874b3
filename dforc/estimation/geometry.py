"""Frames, Jacobians and the centre of mass, from the poses of all bodies.

Poses have a row for each body: its rotation (9, column by column) and its origin (3).
"""

import numpy as np

from dforc.arrays import Matrix, Vector
from dforc.estimation.assumption import Point
from dforc.estimation.tree_model import TreeModel


def frame_pose(model: TreeModel, poses: Matrix, name: str) -> tuple[Matrix, Vector]:
    """Rotation (3x3) and position (3, m) of a link or frame in the base frame."""
    body, R, p = model.frame(name)
    turn = poses[body, :9].reshape(3, 3).T
    return turn @ R, poses[body, 9:] + turn @ p


def jacobian(
    model: TreeModel, poses: Matrix, name: str, point_m: Point = (0.0, 0.0, 0.0)
) -> Matrix:
    """Jacobian (6, n) of a point of a frame: linear rows, then angular, in base axes."""
    body = model.frame(name).body
    R, p = frame_pose(model, poses, name)
    axes, origins = _axes(model, poses)
    linear = np.cross(axes, p + R @ np.array(point_m) - origins)
    moved = model.carries[:, body][:, None]
    return np.hstack([linear * moved, axes * moved]).T


def centre_of_mass(model: TreeModel, poses: Matrix) -> Vector:
    """Centre of mass of the whole robot (3,), base frame, m."""
    centre: Vector = model.mass @ _centres(model, poses) / model.mass.sum()
    return centre


def centre_of_mass_jacobian(model: TreeModel, poses: Matrix) -> Matrix:
    """Jacobian (3, n) of the centre of mass in the base frame."""
    axes, origins = _axes(model, poses)
    weighted = model.carries * model.mass
    arms = weighted @ _centres(model, poses) - weighted.sum(axis=1)[:, None] * origins
    columns: Matrix = np.cross(axes, arms).T / model.mass.sum()
    return columns


def _axes(model: TreeModel, poses: Matrix) -> tuple[Matrix, Matrix]:
    """Axis and origin (n, 3) of every joint in the base frame."""
    mine = poses[model.body_of_joint]
    turns = mine[:, :9].reshape(-1, 3, 3).transpose(0, 2, 1)
    axes: Matrix = (turns @ model.axis[model.body_of_joint][:, :, None])[:, :, 0]
    return axes, mine[:, 9:]


def _centres(model: TreeModel, poses: Matrix) -> Matrix:
    """Centre of mass of every body (bodies, 3) in the base frame."""
    turns = poses[:, :9].reshape(-1, 3, 3).transpose(0, 2, 1)
    centres: Matrix = poses[:, 9:] + (turns @ model.centre[:, :, None])[:, :, 0]
    return centres
