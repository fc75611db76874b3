"""The iCub's torso and arms with a few capsules, and room for what is computed of them."""

import icub_models
import numpy as np

from dforc.arrays import Matrix, Vector
from dforc.collision.body import Body, BodyCapsule
from dforc.collision.kernel_body import proximities
from dforc.collision.kernel_segments import own_segment
from dforc.collision.obstacles import Obstacle, Triple, World, box, cylinder, ellipsoid, sphere
from dforc.rotation import matrix

URDF = str(icub_models.get_model_file("iCubLisboa01"))
ARM = ("shoulder_pitch", "shoulder_roll", "shoulder_yaw", "elbow")
WRIST = ("wrist_prosup", "wrist_pitch", "wrist_yaw")
TORSO = ("torso_pitch", "torso_roll", "torso_yaw")
LEFT = tuple(f"l_{name}" for name in ARM + WRIST)
RIGHT = tuple(f"r_{name}" for name in ARM + WRIST)
JOINTS = (*TORSO, *LEFT, *RIGHT)
TIPS = ("l_hand_dh_frame", "r_hand_dh_frame")
NEIGHBOURS = tuple(
    (f"{side}_{one}", f"{side}_{other}" if other != "chest" else other)
    for side in "lr"
    for one, other in (("upper_arm", "chest"), ("upper_arm", "forearm"), ("forearm", "hand"))
)


def capsule(link: str, start: Triple, end: Triple, radius_m: float) -> BodyCapsule:
    return BodyCapsule(name=link, link=link, start_m=start, end_m=end, radius_m=radius_m)


CAPSULES = (
    capsule("root_link", (0.0, 0.0, -0.02), (0.0, 0.0, -0.12), 0.04),
    capsule("chest", (-0.02, 0.12, 0.0), (-0.02, 0.09, 0.0), 0.08),
    *(
        one
        for side, sign in (("l", 1.0), ("r", -1.0))
        for one in (
            capsule(f"{side}_upper_arm", (-0.015, 0.0, 0.08), (-0.016, 0.0, -0.04), 0.038),
            capsule(f"{side}_forearm", (0.0, sign * 0.107, 0.02), (0.0, sign * 0.028, 0.03), 0.04),
            capsule(f"{side}_hand", (0.058, 0.02, 0.0), (0.011, 0.02, 0.0), 0.037),
        )
    ),
)


def make_body() -> Body:
    return Body.make(URDF, JOINTS, CAPSULES, TIPS, NEIGHBOURS)


def hanging() -> Vector:
    """Arms that hang beside the body, apart from it."""
    q = np.zeros(len(JOINTS))
    q[[JOINTS.index("l_shoulder_roll"), JOINTS.index("r_shoulder_roll")]] = 0.7
    return q


def random_postures(count: int, seed: int) -> Matrix:
    """Half a radian around that."""
    postures: Matrix = (
        hanging() + np.random.default_rng(seed).normal(size=(count, len(JOINTS))) * 0.5
    )
    return postures


def random_obstacles(count: int, seed: int) -> list[Obstacle]:
    """All kinds in turn, in reach of the arms."""
    rng = np.random.default_rng(seed)
    made = []
    for number in range(count):
        x, y, z = (rng.uniform([-0.5, -0.5, -0.3], [0.1, 0.5, 0.4])).tolist()
        a, b, c = rng.uniform(0.02, 0.08, 3).tolist()
        r0, r1, r2 = matrix(rng.normal(size=3)).tolist()
        R = ((r0[0], r0[1], r0[2]), (r1[0], r1[1], r1[2]), (r2[0], r2[1], r2[2]))
        name = f"obstacle {number}"
        made.append(
            (
                sphere(name, (x, y, z), a),
                ellipsoid(name, (x, y, z), (a, b, c), R),
                box(name, (x, y, z), (a, b, c), R),
                cylinder(name, (x, y, z), a, b, R),
            )[number % 4]
        )
    return made


def along(
    kind: int, size: Vector, a: Vector, b: Vector, enough: float = 1e300
) -> tuple[float, float, Vector]:
    """Distance, share and normal of the segment a to b from a solid."""
    far, share, *n = own_segment(kind, *np.concatenate([size, a, b, [enough]]).tolist())
    return far, share, np.array(n)


class Room:
    """Arrays for one body, and the rows of the last call."""

    def __init__(self, body: Body, rows: int = 60) -> None:
        n, c = len(body.joints), len(body.capsules)
        self.body = body
        self.mask = body.moved_by(body.joints)
        self.frames, self.segments = np.zeros((n, 12)), np.zeros((c, 6))
        self.distances, self.drifts = np.zeros(rows), np.zeros(rows)
        self.gradients = np.zeros((rows, n))
        self.which = np.zeros((rows, 2), dtype=np.int64)

    def near(
        self, q: Vector, world: World, reach_m: float = 9.0, self_reach_m: float = 9.0
    ) -> dict[tuple[int, int], tuple[float, Vector, float]]:
        """Distance, gradient and drift of each pair of things."""
        count = proximities(
            q,
            self.body.arrays,
            world,
            self.mask,
            reach_m,
            self_reach_m,
            self.frames,
            self.segments,
            self.distances,
            self.gradients,
            self.drifts,
            self.which,
        )
        return {
            (int(self.which[row, 0]), int(self.which[row, 1])): (
                float(self.distances[row]),
                self.gradients[row].copy(),
                float(self.drifts[row]),
            )
            for row in range(count)
        }
