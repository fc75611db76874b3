"""The parts of a robot that are in its rigid-body model, and which sensor feels which of them."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from dforc.arrays import Matrix
from services.core.stream import Stream
from services.messages import Floats, ImpedanceOffset, JointState, TorqueEstimate, Wrench
from services.robotfile.model_file import model_path
from services.robotfile.model_tree import ModelTree, model_tree
from services.robotfile.robot_tables import RobotFile
from services.streams import IMPEDANCE_OFFSET, JOINT_STATE, TORQUE_ESTIMATE, WRENCH


@dataclass(frozen=True, slots=True, eq=False)
class BodyPart:
    """One part with joints of the model; its streams carry `size` joints, some of them not."""

    name: str
    joints: tuple[str, ...]  # those of the model
    start: int  # of them in the model's joint vector
    taken: tuple[int, ...]  # where they stand in the part's streams
    size: int
    felt: tuple[str, ...]  # joints whose board takes a torque estimate; () = the part gets none
    related: tuple[str, ...]  # parts, itself too, whose angles its torques depend on
    state: Stream[JointState]
    torque: Stream[TorqueEstimate]
    offset: Stream[ImpedanceOffset]

    @property
    def stop(self) -> int:
        """End of its joints in the model's vector."""
        return self.start + len(self.joints)

    @property
    def is_whole(self) -> bool:
        """Whether all its joints are in the model, in order."""
        return self.taken == tuple(range(self.size))

    def from_stream(self, values: Floats) -> Floats:
        """The model's joints out of a message's."""
        return values if self.is_whole else tuple([values[i] for i in self.taken])

    def to_stream(self, values: Sequence[float]) -> Floats:
        """A message's joints out of the model's whole vector; zero where the model has none."""
        if self.is_whole:
            return tuple(values[self.start : self.stop])
        spread = [0.0] * self.size
        for i, value in zip(self.taken, values[self.start : self.stop], strict=True):
            spread[i] = value
        return tuple(spread)


@dataclass(frozen=True, slots=True, eq=False)
class BodySensor:
    """One FT sensor."""

    name: str
    frame: str  # fixed joint of the URDF
    part: str
    wrench: Stream[Wrench]
    contact_frame: str
    contact_on_n: float
    contact_off_n: float
    contact_learned_on_n: float
    full_scale: tuple[float, ...]
    gain: Matrix  # of the robot file, (6, 6)


class Body:
    """What whole-body dynamics asks of a robot file."""

    def __init__(self, robot: RobotFile) -> None:
        self.urdf = model_path(robot)
        self.tree = model_tree(self.urdf)
        self.sensors = tuple(
            BodySensor(
                name,
                table.frame,
                robot.boards[table.board].part,
                WRENCH[name],
                table.contact_frame or table.frame,
                table.contact_on_n,
                table.contact_off_n,
                table.contact_learned_on_n,
                table.full_scale,
                np.reshape(table.gain, (6, 6)) if table.gain else np.eye(6),
            )
            for name, table in robot.sensors.items()
        )
        self.parts = _parts(robot, self.tree)
        self.joints = tuple(joint for part in self.parts for joint in part.joints)
        self.imus = {
            name: board.frame for name, board in robot.boards.items() if board.type == "imu"
        }

    @property
    def sensor_frames(self) -> dict[str, str]:
        """URDF joint of each sensor, by name."""
        return {sensor.name: sensor.frame for sensor in self.sensors}


def _parts(robot: RobotFile, tree: ModelTree) -> tuple[BodyPart, ...]:
    body = {
        part: [joint for joint in names if robot.joints[joint].mechanism == "body"]
        for part, names in robot.parts.items()
    }
    felt = {joint for one in robot.virtual_sensors.values() for joint in one.channels}
    above = {joint: set(tree.joints_above(joint)) for names in body.values() for joint in names}
    parts, start = [], 0
    for name, joints in body.items():
        if not joints:
            continue
        related = [
            other
            for other, theirs in body.items()
            if any(a in above[b] or b in above[a] for a in joints for b in theirs)
        ]
        names = robot.parts[name]
        parts.append(
            BodyPart(
                name=name,
                joints=tuple(joints),
                start=start,
                taken=tuple(names.index(joint) for joint in joints),
                size=len(names),
                felt=tuple(joint for joint in joints if joint in felt),
                related=tuple(related),
                state=JOINT_STATE[name],
                torque=TORQUE_ESTIMATE[name],
                offset=IMPEDANCE_OFFSET[name],
            )
        )
        start += len(joints)
    return tuple(parts)
