"""Distances of hands' points from the surfaces of objects, where these are now."""

import numpy as np

from dforc.collision.kernel_shapes import point_distance
from services.fields.mode import HandPoint, Surroundings

HAND = "hand"


def hand_clearance(
    hands: tuple[HandPoint, ...], around: Surroundings
) -> tuple[float, tuple[str, str]]:
    """The smallest, negative inside, and from what; infinite without obstacles."""
    closest, nearest = float("inf"), ("", "")
    distances = surface_distances(hands, around)
    for seen, distance_m in zip(around.obstacles, distances, strict=True):
        if distance_m < closest:
            closest, nearest = distance_m, (HAND, seen.name)
    return closest, nearest


def surface_distances(hands: tuple[HandPoint, ...], around: Surroundings) -> list[float]:
    """Of the nearest hand's point from every obstacle, in their order."""
    world, normal = around.world, np.empty(3)
    return [
        min(
            float(
                point_distance(
                    world.kinds[i],
                    world.sizes[i],
                    world.rotations[i],
                    np.array(seen.place_m),
                    hand.position_m,
                    normal,
                )
            )
            for hand in hands
        )
        for i, seen in enumerate(around.obstacles)
    ]
