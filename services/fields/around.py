"""What is around the limb in a period: the objects that are on, and where the body is."""

import numpy as np

from dforc.arrays import Vector
from dforc.collision.body import Body
from dforc.collision.obstacles import world_of
from services.core.service import Inputs
from services.fields.goals import ActiveGoal
from services.fields.mode import Surroundings
from services.fields.seen import SeenObject, as_obstacle
from services.fields.sources import find_object
from services.robotfile.robot_tables import RobotFile
from services.streams import JOINT_STATE

STATE_AGE_S = 0.1


def around_limb(
    seen: tuple[SeenObject, ...], goal: ActiveGoal | None, body: tuple[Vector, Vector]
) -> Surroundings:
    """Obstacles and targets; what is followed is no obstacle. `body` are its joints and speeds."""
    followed = None
    if goal is not None and goal.message.follow:
        followed = find_object(seen, goal.message.follow)
    obstacles = tuple(
        one for one in seen if one.on and one.role == "obstacle" and one is not followed
    )
    return Surroundings(
        obstacles=obstacles,
        targets=tuple(
            one for one in seen if one.on and one.role == "target" and one is not followed
        ),
        world=world_of([as_obstacle(one) for one in obstacles]),
        body_rad=body[0],
        body_rad_s=body[1],
    )


class BodyReading:
    """The whole body's joints as measured. A part that is not heard stays where it was last."""

    def __init__(self, robot: RobotFile, body: Body) -> None:
        self.body = body
        self._parts = {
            part: body.columns([joint for joint in joints if joint in body.joints])
            for part, joints in robot.parts.items()
            if set(joints) & set(body.joints)
        }
        self.streams = {part: JOINT_STATE[part] for part in self._parts}
        self.q_rad: Vector = np.radians([robot.joints[name].park_deg for name in body.joints])
        self.dq_rad_s: Vector = np.zeros(len(body.joints))
        self.assumed: tuple[str, ...] = tuple(self._parts)

    def take(self, inputs: Inputs) -> None:
        """Take in what is new."""
        silent = []
        for part, stream in self.streams.items():
            columns = self._parts[part]
            state = inputs.fresh(stream, STATE_AGE_S)
            usable = state is not None and state.valid and len(state.q_rad) == len(columns)
            if state is None or not usable or not np.isfinite(state.q_rad).all():
                silent.append(part)
                self.dq_rad_s[columns] = 0.0
                continue
            self.q_rad[columns] = state.q_rad
            speeds = np.array(state.dq_rad_s)
            known = len(speeds) == len(columns) and bool(np.isfinite(speeds).all())
            self.dq_rad_s[columns] = speeds if known else 0.0
        self.assumed = tuple(silent)
