"""How far a limb may move straight between postures without touching, for numba.

Conservative advancement: a clearance divided by a bound of the speed with which anything can come
nearer is a share of the edge on which nothing touches. So nothing is jumped over, however thin.
"""

from typing import NamedTuple

from dforc.arrays import Matrix, Vector
from dforc.collision.body import BodyArrays
from dforc.collision.kernel_body import place_body
from dforc.collision.kernel_nearness import apart, axes_bound, ball_bound
from dforc.collision.kernel_shapes import nearest_on
from dforc.collision.obstacles import World
from dforc.compiled import compiled
from dforc.virtual_arm.moving import Moving

FAR = 1e9  # shares beyond any edge
STRETCH = 1.8  # a step goes this much farther than is safe, and is believed if both ends agree
TOUCHES = -1.0


class Scene(NamedTuple):
    """A limb of a body among obstacles, with scratch."""

    body: BodyArrays
    moving: Moving
    world: World
    kept: Matrix  # (k, m) distance to keep between each capsule's axis and each obstacle
    pairs_kept: Vector  # (p,) and between the axes of two capsules
    between: float  # m, by how much distances may fall short between two postures looked at
    looks: int  # postures of one way at most
    misses: int  # that touch, until a way is given up: 1 quickly, 2 near to where it is blocked
    whole: Vector  # (N,) the body's posture; the limb's joints are overwritten
    frames: Matrix  # (N, 12)
    segments: Matrix  # (c, 6)
    speeds: Vector  # (k,) m of the capsules along the edge that is looked at, at most
    pair_speeds: Vector  # (p,)


@compiled
def safe_share(scene: Scene) -> float:
    """On which share of the edge around the placed posture nothing can touch; TOUCHES if it does.

    Distances may fall short by half of `between` there.
    """
    least = FAR
    body, world, moving, segments = scene.body, scene.world, scene.moving, scene.segments
    slack = 0.5 * scene.between
    for i in range(len(moving.capsules)):
        capsule, speed = moving.capsules[i], scene.speeds[i]
        for o in range(len(world.kinds)):
            kept = scene.kept[i, o]
            enough = kept + max(0.0, least * speed - slack)
            if ball_bound(segments, capsule, world, o) >= enough:
                continue
            far, _, _, _, _ = nearest_on(o, world, segments[capsule], enough)
            if far < kept:
                return TOUCHES
            if far < enough:
                least = (far - kept + slack) / speed
    for i in range(len(moving.pairs)):
        first, second = moving.pairs[i, 0], moving.pairs[i, 1]
        kept, speed = scene.pairs_kept[i], scene.pair_speeds[i]
        enough = kept + max(0.0, least * speed - slack)
        if axes_bound(body, segments, first, second) >= enough:
            continue
        far, _, _ = apart(segments, first, second)
        if far < kept:
            return TOUCHES
        if far < enough:
            least = (far - kept + slack) / speed
    return least


@compiled
def set_edge(scene: Scene, a: Vector, b: Vector) -> None:
    """Bounds of how far the edge from a to b moves everything."""
    moving = scene.moving
    n = len(moving.columns)
    for i in range(len(moving.capsules)):
        speed = 0.0
        for j in range(n):
            speed += moving.levers[i, j] * abs(b[j] - a[j])
        scene.speeds[i] = speed
    for i in range(len(moving.pairs)):
        speed = 0.0
        for j in range(n):
            speed += moving.pair_levers[i, j] * abs(b[j] - a[j])
        scene.pair_speeds[i] = speed


@compiled
def look_at(scene: Scene, a: Vector, b: Vector, share: float) -> float:
    """`safe_share` of the posture at a share of the edge."""
    columns = scene.moving.columns
    for j in range(len(columns)):
        scene.whole[columns[j]] = a[j] + share * (b[j] - a[j])
    place_body(scene.whole, scene.body, scene.frames, scene.segments)
    return safe_share(scene)


@compiled
def march(scene: Scene, a: Vector, b: Vector) -> tuple[float, bool, int]:
    """Free share of the way from a to b, whether something stops it there, and postures looked at.

    The share is that of the last posture found free. `scene.looks` may be passed by two.
    """
    set_edge(scene, a, b)
    here = look_at(scene, a, b, 0.0)
    if here < 0.0:
        return 0.0, True, 1
    if here >= 1.0:
        return 1.0, False, 1
    last = look_at(scene, a, b, 1.0)
    end = 1.0 - max(0.0, last)
    share, looks, misses, stretch = 0.0, 2, 0, STRETCH
    while share + here < end or last < 0.0:
        if looks >= scene.looks:
            return share, False, looks
        ahead = min(share + stretch * here, max(share + here, 0.5 * (share + here + end)))
        if ahead >= 1.0:
            return share, True, looks
        there = look_at(scene, a, b, ahead)
        looks += 1
        if there >= 0.0 and ahead - there > share + here:  # a gap between what the two make safe
            ahead = share + here
            there = look_at(scene, a, b, ahead)
            looks += 1
        if there >= 0.0:
            share, here = ahead, there
            continue
        misses += 1
        if misses >= scene.misses or ahead <= share + here:
            return share, True, looks
        stretch = 1.0
    return 1.0, False, looks
