"""A field service with an arm that stands at home, for several tests."""

import msgspec
import numpy as np
from numpy.typing import NDArray

from services.core.testing import Bench
from services.field import Field
from services.fields.messages import FieldReply, FieldRequest, FieldStatus, NamedFloats
from services.messages import CartesianStatus, Goal, JointState, Objects, Vector3, WorldObject
from services.reaching.limb import limb_model
from services.robotfile.robot_tables import RobotFile
from services.streams import CARTESIAN_STATUS, FIELD_CALL, FIELD_STATUS, GOAL, JOINT_STATE, OBJECTS
from tests.services.postures import arms_at

PERIOD_S = 0.01
STILL: Vector3 = (0.0, 0.0, 0.0)


class FieldStand:
    """The service, and states of joints that come every period."""

    def __init__(self, robot: RobotFile, mode: str = "dforc") -> None:
        self.field = Field(robot, mode)
        self.bench = Bench(self.field)
        self.states: dict[str, JointState] = arms_at(robot)
        self.status: CartesianStatus | None = None
        home = np.radians(robot.reach.home_deg)
        self.home_m: NDArray[np.float64] = limb_model(robot).tip_pose(home)[1]

    def run(self, seconds: float) -> None:
        """Let time pass."""
        for _ in range(round(seconds / PERIOD_S)):
            for part, state in self.states.items():
                self.bench.put(JOINT_STATE[part], state)
            if self.status is not None:
                self.bench.put(CARTESIAN_STATUS, self.status)
            self.bench.advance(PERIOD_S)

    def beside(self, x: float, y: float, z: float) -> Vector3:
        """A place beside the hand at home."""
        a, b, c = (self.home_m + np.array((x, y, z))).tolist()
        return (a, b, c)

    def goal(self, x: float, y: float, z: float, **more: object) -> Goal:
        """A goal beside the hand, turned as it likes."""
        plain = Goal(
            stamp_ns=0, position_m=self.beside(x, y, z), rotation_rad=STILL, position_only=True
        )
        return msgspec.structs.replace(plain, **more)

    def send(self, goal: Goal) -> None:
        """A goal on the stream."""
        self.bench.put(GOAL, goal)

    def see(self, *items: WorldObject, source: str = "") -> None:
        """A source's objects."""
        self.bench.put(OBJECTS, Objects(stamp_ns=0, objects=items, source=source))

    def ask(self, request: FieldRequest, patience_s: float = 5.0) -> FieldReply:
        """The reply to a request."""
        token = self.bench.request(FIELD_CALL, request)
        for _ in range(round(patience_s / PERIOD_S)):
            self.run(PERIOD_S)
            replies = dict(self.bench.replies(FIELD_CALL))
            if token in replies:
                return replies[token]
        raise AssertionError("no reply")

    def set(self, mode: str = "", gains: NamedFloats = (), preset: str = "") -> FieldReply:
        """Another mode, other gains."""
        return self.ask(FieldRequest(action="set", mode=mode, gains=gains, preset=preset))

    def told(self) -> FieldStatus:
        """The next status."""
        self.run(5 * PERIOD_S)
        return self.bench.last(FIELD_STATUS)


def ball(name: str, place: Vector3, radius_m: float = 0.05, **more: object) -> WorldObject:
    """A ball at rest."""
    plain = WorldObject(
        name=name, shape="sphere", size_m=(radius_m,), position_m=place, velocity_m_s=STILL
    )
    return msgspec.structs.replace(plain, **more)
