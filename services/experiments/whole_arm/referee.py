"""Who says whether an arm touched anything: pinocchio places the capsules, coal measures.

Nothing here is of dforc's distances or kinematics, so that no error of theirs judges itself. A
capsule is a link's, in the link's frame. Obstacles count against capsules that the limb moves.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
import pinocchio as pin
from numpy.typing import NDArray

from dforc.collision.obstacles import Obstacle, Shape

Array = NDArray[np.float64]

BETWEEN = 5  # postures looked at from one tick to the next


@dataclass(frozen=True)
class Capsule:
    """All points within a radius of a segment, in a link's frame."""

    name: str
    link: str
    start_m: tuple[float, float, float]
    end_m: tuple[float, float, float]
    radius_m: float


@dataclass(frozen=True)
class Nearest:
    """The smallest distance [m] of two surfaces, negative where they overlap, and of which two."""

    distance_m: float = np.inf
    pair: tuple[str, str] = ("", "")


@dataclass
class Verdict:
    """The nearest that a run came to obstacles and to itself, and when [s]."""

    obstacle: Nearest = field(default_factory=Nearest)
    itself: Nearest = field(default_factory=Nearest)
    obstacle_s: float = 0.0
    itself_s: float = 0.0

    @property
    def is_clean(self) -> bool:
        """Nothing touched anything."""
        return self.obstacle.distance_m > 0.0 and self.itself.distance_m > 0.0

    def add(self, obstacle: Nearest, itself: Nearest, at_s: float) -> None:
        """Take one posture in."""
        if obstacle.distance_m < self.obstacle.distance_m:
            self.obstacle, self.obstacle_s = obstacle, at_s
        if itself.distance_m < self.itself.distance_m:
            self.itself, self.itself_s = itself, at_s


@dataclass(frozen=True, eq=False)
class Standing:
    """Where everything is in one tick: the body's joints, and the obstacles if they move."""

    body_rad: Array  # (N,)
    centres_m: Array | None = None  # (m, 3)


class Referee:
    """Distances of one robot's body to obstacles and to itself; the joints not named stay at zero.

    `pairs` are the capsules, by index, that may touch each other. `limb` are the joints whose
    motion is judged: capsules that none of them moves count against no obstacle.
    """

    def __init__(
        self,
        urdf: str,
        joints: Sequence[str],
        capsules: Sequence[Capsule],
        pairs: Sequence[tuple[int, int]],
        limb: Sequence[str],
    ) -> None:
        self._model = pin.buildModelFromUrdf(urdf)
        self._data = self._model.createData()
        self._q = pin.neutral(self._model)
        self._at = np.array([self._model.idx_qs[self._model.getJointId(j)] for j in joints])
        self._capsules = tuple(capsules)
        moving = {self._model.getJointId(joint) for joint in limb}
        self._objects = [self._object(capsule) for capsule in capsules]
        supports = [set(self._model.supports[o.parentJoint]) for o in self._objects]
        self.moved = tuple(bool(moving & above) for above in supports)
        self._self_model = pin.GeometryModel()
        for item in self._objects:
            self._self_model.addGeometryObject(item)
        for a, b in pairs:
            if moving & (supports[a] ^ supports[b]):  # the others never move against each other
                self._self_model.addCollisionPair(pin.CollisionPair(a, b))
        self._self_data = self._self_model.createData()
        self._reaches = np.array([self._reach_m(self._model.getJointId(j)) for j in joints])
        self._seen: tuple[Standing | None, tuple[Nearest, Nearest]] = None, (Nearest(), Nearest())
        self.face(())

    def face(self, obstacles: Sequence[Obstacle]) -> None:
        """Judge against these obstacles from now on."""
        self._seen = None, (Nearest(), Nearest())
        self._model_of_obstacles = pin.GeometryModel()
        first = len(self._objects)
        for item in self._objects:
            self._model_of_obstacles.addGeometryObject(item)
        for obstacle in obstacles:
            item = pin.GeometryObject(obstacle.name, 0, _place(obstacle), _shape(obstacle))
            index = self._model_of_obstacles.addGeometryObject(item)
            for capsule in range(first):
                if self.moved[capsule]:
                    pair = pin.CollisionPair(capsule, index)
                    self._model_of_obstacles.addCollisionPair(pair)
        self._data_of_obstacles = self._model_of_obstacles.createData()

    def carry(self, centres_m: Array) -> None:
        """Put the obstacles there (m, 3), in their order, without another build."""
        objects = self._model_of_obstacles.geometryObjects
        for k, centre in enumerate(centres_m, start=len(self._objects)):
            place = objects[k].placement
            place.translation = centre
            objects[k].placement = place

    def obstacle(self, q_rad: Array) -> Nearest:
        """The nearest obstacle to what the limb moves."""
        return self._nearest(self._model_of_obstacles, self._data_of_obstacles, q_rad)

    def itself(self, q_rad: Array) -> Nearest:
        """The nearest pair of the body."""
        return self._nearest(self._self_model, self._self_data, q_rad)

    def judge(
        self, verdict: Verdict, before: Standing, after: Standing, from_s: float, dt_s: float
    ) -> None:
        """Take the motion between two ticks in, `after` included.

        In between is looked where a distance could be smaller than the smallest so far.
        """
        first = self._seen[1] if self._seen[0] is before else self._look(before)
        last = self._look(after)
        self._seen = after, last
        verdict.add(*last, from_s + dt_s)
        way = float(self._reaches @ np.abs(after.body_rad - before.body_rad))
        drift = self._drift(before, after)
        obstacle = first[0].distance_m + last[0].distance_m - way - drift
        itself = first[1].distance_m + last[1].distance_m - way
        if 0.5 * obstacle >= verdict.obstacle.distance_m and (
            0.5 * itself >= verdict.itself.distance_m
        ):
            return
        for k in range(1, BETWEEN):
            share = k / BETWEEN
            verdict.add(*self._look(_between(before, after, share)), from_s + share * dt_s)

    def _look(self, standing: Standing) -> tuple[Nearest, Nearest]:
        if standing.centres_m is not None:
            self.carry(standing.centres_m)
        return self.obstacle(standing.body_rad), self.itself(standing.body_rad)

    @staticmethod
    def _drift(before: Standing, after: Standing) -> float:
        """How far the fastest obstacle went [m]."""
        if before.centres_m is None or after.centres_m is None:
            return 0.0
        moved = np.linalg.norm(after.centres_m - before.centres_m, axis=1)
        return float(moved.max(initial=0.0))

    def frame_pose(self, q_rad: Array, frame: str) -> tuple[Array, Array]:
        """Rotation (3, 3) and position (3,) of a link."""
        self._q[self._at] = q_rad
        pin.forwardKinematics(self._model, self._data, self._q)
        index = self._model.getFrameId(frame)
        place = pin.updateFramePlacement(self._model, self._data, index)
        return place.rotation.copy(), place.translation.copy()

    def segments(self, q_rad: Array) -> Array:
        """Both ends of every capsule's segment in the base (c, 2, 3)."""
        found = np.zeros((len(self._capsules), 2, 3))
        for k, capsule in enumerate(self._capsules):
            turn, p = self.frame_pose(q_rad, capsule.link)
            found[k] = p + np.array([capsule.start_m, capsule.end_m]) @ turn.T
        return found

    def _nearest(self, model: "pin.GeometryModel", data: "pin.GeometryData", q: Array) -> Nearest:
        if len(model.collisionPairs) == 0:
            return Nearest()
        self._q[self._at] = q
        index = pin.computeDistances(self._model, self._data, model, data, self._q)
        pair = model.collisionPairs[index]
        names = [model.geometryObjects[i].name for i in (pair.first, pair.second)]
        return Nearest(data.distanceResults[index].min_distance, (names[0], names[1]))

    def _reach_m(self, joint: int) -> float:
        """No point that the joint carries is ever farther from it [m]."""
        farthest = 0.0
        for capsule, item in zip(self._capsules, self._objects, strict=True):
            above = list(self._model.supports[item.parentJoint])
            if joint not in above:
                continue
            beyond = above[above.index(joint) + 1 :]
            way = sum(
                float(np.linalg.norm(self._model.jointPlacements[i].translation)) for i in beyond
            )
            along = 0.5 * float(np.linalg.norm(np.subtract(capsule.end_m, capsule.start_m)))
            centre = float(np.linalg.norm(item.placement.translation))
            farthest = max(farthest, way + centre + along + capsule.radius_m)
        return farthest

    def _object(self, capsule: Capsule) -> "pin.GeometryObject":
        frame = self._model.frames[self._model.getFrameId(capsule.link)]
        start, end = np.array(capsule.start_m), np.array(capsule.end_m)
        along = end - start
        length = float(np.linalg.norm(along))
        turn = np.eye(3)
        if length > 0.0:
            turn = pin.Quaternion.FromTwoVectors(np.array([0.0, 0.0, 1.0]), along).matrix()
        place = frame.placement * pin.SE3(turn, 0.5 * (start + end))
        shape = pin.coal.Capsule(capsule.radius_m, length)
        return pin.GeometryObject(capsule.name, frame.parentJoint, place, shape)


def _between(before: Standing, after: Standing, share: float) -> Standing:
    q = before.body_rad + share * (after.body_rad - before.body_rad)
    if before.centres_m is None or after.centres_m is None:
        return Standing(q, after.centres_m)
    return Standing(q, before.centres_m + share * (after.centres_m - before.centres_m))


def _place(obstacle: Obstacle) -> "pin.SE3":
    return pin.SE3(np.array(obstacle.rotation), np.array(obstacle.position_m))


def _shape(obstacle: Obstacle) -> "pin.coal.ShapeBase":
    a, b, c = obstacle.size_m
    if obstacle.shape is Shape.SPHERE:
        return pin.coal.Sphere(a)
    if obstacle.shape is Shape.ELLIPSOID:
        return pin.coal.Ellipsoid(a, b, c)
    if obstacle.shape is Shape.BOX:
        return pin.coal.Box(2.0 * a, 2.0 * b, 2.0 * c)
    return pin.coal.Cylinder(a, 2.0 * b)
