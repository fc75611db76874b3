"""The Cartesian controller with inverse kinematics and joints that do as they are told."""

from collections.abc import Callable, Sequence

import numpy as np

from dforc import rotation
from dforc.arrays import Vector
from dforc.robot_model import RobotModel
from services.cartesian import Cartesian
from services.core.clock import VirtualClock
from services.core.service import CallFailed, Inputs, Outputs, Period, Service
from services.core.stream import AnyCall, AnyStream
from services.core.virtual import VirtualExecutor
from services.ik import Ik
from services.messages import CartesianStatus, JointCommand, JointState
from services.reaching.cartesian_messages import (
    CartesianEvent,
    CartesianReply,
    CartesianRequest,
    CartesianSettings,
    MotionState,
)
from services.reaching.limb import find_limb, limb_joints, limb_models
from services.reaching.messages import SetupInUse, TipPose
from services.robotfile.robot_tables import RobotFile
from services.streams import (
    CARTESIAN_CALL,
    CARTESIAN_EVENTS,
    CARTESIAN_SETUP,
    CARTESIAN_STATUS,
    JOINT_COMMAND,
    JOINT_STATE,
)

DIRECT, IDLE, FAULT = 0x08, 0x00, 0xA0
Offset = tuple[float, float, float]


class Joints(Service):
    """Each joint is where its last set-point was, in position-direct mode, unless told."""

    trigger = Period(0.01)

    def __init__(self, robot: RobotFile, q_rad: dict[str, float]) -> None:
        self.parts = robot.parts
        self.q_rad = q_rad
        self.modes = dict.fromkeys(q_rad, DIRECT)
        self.invalid: set[str] = set()  # parts
        self.silent: set[str] = set()
        self.stuck: set[str] = set()  # joints
        self.commands: list[tuple[str, JointCommand]] = []
        self.reads = tuple(JOINT_COMMAND[part] for part in self.parts)
        self.writes = tuple(JOINT_STATE[part] for part in self.parts)

    def step(self, now_ns: int, inputs: Inputs, outputs: Outputs) -> None:
        for part, joints in self.parts.items():
            for command in inputs.all_new(JOINT_COMMAND[part]):
                self.commands.append((part, command))
                for joint, q in zip(command.joints or joints, command.q_rad, strict=True):
                    if self.modes[joint] == DIRECT and joint not in self.stuck:
                        self.q_rad[joint] = q
            if part not in self.silent:
                outputs.put(JOINT_STATE[part], self._state(now_ns, part))

    def _state(self, now_ns: int, part: str) -> JointState:
        joints = self.parts[part]
        return JointState(
            stamp_ns=now_ns,
            q_rad=tuple(self.q_rad[joint] for joint in joints),
            dq_rad_s=(0.0,) * len(joints),
            tau_nm=(0.0,) * len(joints),
            control_mode=tuple(self.modes[joint] for joint in joints),
            compliant=(False,) * len(joints),
            valid=part not in self.invalid,
        )


class Caller(Service):
    """Sends what a test wants to say, and keeps what it hears."""

    trigger = Period(0.001)
    reads = (CARTESIAN_EVENTS, CARTESIAN_STATUS, CARTESIAN_SETUP)
    calls: tuple[AnyCall, ...] = (CARTESIAN_CALL,)

    def __init__(self, writes: tuple[AnyStream, ...] = ()) -> None:
        self.writes = writes
        self.waiting: list[CartesianRequest] = []
        self.sent: list[int] = []
        self.replies: dict[int, CartesianReply | CallFailed] = {}
        self.events: list[CartesianEvent] = []
        self.setups: list[SetupInUse] = []
        self.status: CartesianStatus | None = None
        self.stream: Callable[[int, Outputs], None] | None = None

    def step(self, now_ns: int, inputs: Inputs, outputs: Outputs) -> None:
        self.replies |= dict(inputs.replies(CARTESIAN_CALL))
        self.events += inputs.all_new(CARTESIAN_EVENTS)
        self.setups += inputs.all_new(CARTESIAN_SETUP)
        self.status = inputs.latest(CARTESIAN_STATUS)
        for request in self.waiting:
            self.sent.append(outputs.call(CARTESIAN_CALL, request))
        self.waiting.clear()
        if self.stream is not None:
            self.stream(now_ns, outputs)


class Stand:
    """Everything, in virtual time."""

    def __init__(
        self, robot: RobotFile, writes: tuple[AnyStream, ...] = (), hop_ticks: int = 1
    ) -> None:
        self.robot = robot
        home = {
            joint: float(angle)
            for limb in robot.limbs
            for joint, angle in zip(
                limb_joints(robot, limb), np.radians(find_limb(robot, limb).home_deg), strict=True
            )
        }
        self._models: dict[str, tuple[RobotModel, ...]] = {}
        self.clock = VirtualClock()
        self.joints = Joints(robot, home)
        self.caller = Caller(writes)
        self.cartesian = Cartesian(robot)
        self.executor = VirtualExecutor(
            self.clock,
            {
                "joints": self.joints,
                "ik": Ik(robot),
                "cartesian": self.cartesian,
                "caller": self.caller,
            },
            hop_ticks,
        )
        self.run(0.03)

    def run(self, seconds: float, until: Callable[[], bool] | None = None) -> bool:
        return self.executor.run(seconds, until)

    def send(self, action: str, limb: str = "right_arm", /, **fields: object) -> int:
        """Send a request; the number finds its reply in `reply`."""
        self.caller.waiting.append(CartesianRequest(action=action, limb=limb, **fields))  # type: ignore[arg-type]
        count = len(self.caller.sent)
        assert self.run(0.01, lambda: len(self.caller.sent) > count)
        return self.caller.sent[-1]

    def reply(self, number: int) -> CartesianReply:
        assert self.run(6.0, lambda: number in self.caller.replies), "no reply"
        reply = self.caller.replies[number]
        assert isinstance(reply, CartesianReply), reply
        return reply

    def ask(self, action: str, limb: str = "right_arm", /, **fields: object) -> CartesianReply:
        """Send a request and wait for its reply."""
        return self.reply(self.send(action, limb, **fields))

    def set(self, limb: str = "right_arm", /, **fields: object) -> CartesianReply:
        return self.ask("set", limb, settings=CartesianSettings(**fields))  # type: ignore[arg-type]

    def go(
        self, offset_m: Offset | Sequence[Offset], limb: str = "right_arm", **fields: object
    ) -> CartesianReply:
        """Move the limb's tips by so much from where they are now, orientation kept."""
        return self.ask("go", limb, poses=self.poses(offset_m, limb), **fields)

    def poses(
        self, offset_m: Offset | Sequence[Offset], limb: str = "right_arm"
    ) -> tuple[TipPose, ...]:
        offsets = np.atleast_2d(np.array(offset_m))
        poses = zip(self.hands(limb), offsets, strict=True)
        return tuple(
            TipPose(
                position_m=tuple((place + offset).tolist()),
                rotation_rad=tuple(rotation.rotation_vector(turned).tolist()),
            )
            for (turned, place), offset in poses
        )

    def hands(self, limb: str = "right_arm") -> list[tuple[Vector, Vector]]:
        """Rotation and position of the limb's tips, by the joints as they are."""
        q = np.array([self.joints.q_rad[joint] for joint in limb_joints(self.robot, limb)])
        if limb not in self._models:
            self._models[limb] = limb_models(self.robot, limb)
        return [model.tip_pose(q) for model in self._models[limb]]

    def kinds(self, motion: int) -> list[str]:
        """Kinds of a motion's events, in order."""
        return [event.kind for event in self.caller.events if event.motion.motion == motion]

    def wait(self, motion: int, timeout_s: float = 15.0) -> MotionState:
        """Until a motion is done."""

        def over() -> bool:
            return self.ended(motion) is not None

        assert self.run(timeout_s, over), "the motion does not end"
        ended = self.ended(motion)
        assert ended is not None
        return ended

    def ended(self, motion: int) -> MotionState | None:
        return next(
            (
                event.motion
                for event in self.caller.events
                if event.kind == "motion-done" and event.motion.motion == motion
            ),
            None,
        )

    @property
    def status(self) -> CartesianStatus:
        assert self.caller.status is not None
        return self.caller.status
