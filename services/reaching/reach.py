"""The main job as a client of the stack: calibrate, go compliant, reach around a ball, come down.

Reads   robot/status, dynamics/status, cartesian/status, field/status, and boards/plant_truth (to
        judge the result on what the plant really did)
Writes  field/goal, field/objects
Calls   robot/request, dynamics/zero_ft, boards/push, field/request
It is no process of the stack: the demo runs it on an executor of its own, live or virtual. It stops
with a reason when anything it waits for does not come, and in any case asks the robot to come down.
"""

from dataclasses import dataclass

import numpy as np

from dforc import rotation
from services.core.service import CallFailed, Period
from services.core.stream import AnyStream
from services.emulated.messages import PushRequest
from services.fields.messages import FieldRequest
from services.messages import FtRequest, Goal, Objects, Obstacle, Reply, Vector3
from services.reaching.limb import limb_model
from services.reaching.reach_record import Recording, Sample
from services.reaching.reach_scene import Scene, draw_scene, rotation_there
from services.robot_messages import RobotRequest
from services.robotfile.robot_tables import RobotFile
from services.script import TASK_TIMEOUT_S, AbandonedError, Script, ScriptedService
from services.streams import (
    CARTESIAN_STATUS,
    DYNAMICS_STATUS,
    FIELD_CALL,
    FIELD_STATUS,
    FT_CALL,
    GOAL,
    OBJECTS,
    PLANT_TRUTH,
    PUSH_CALL,
    ROBOT_CALL,
    ROBOT_STATUS,
)

PERIOD_S = 0.01
STATE_AGE_S = 0.1
CALIBRATION_TIMEOUT_S = 40.0
HOME_S = 2.0
SETTLE_S = 1.0
DWELL_S = 1.0  # the bar: inside the bars for this long
FEEDBACK_SILENCE_S = (
    0.5  # status of the robot, or truth of the plant, missing this long: the stack is broken
)


@dataclass(frozen=True, kw_only=True)
class Push:
    """A push on the hand once it holds, base frame."""

    force_n: Vector3 = (0.0, 0.0, -20.0)
    duration_s: float = 3.0
    recovery_s: float = 5.0


@dataclass(frozen=True, kw_only=True)
class ReachOptions:
    """What to do, and when it counts as done."""

    seed: int = 0
    stiff: bool = False
    target_m: Vector3 | None = None
    ball: tuple[float, float, float, float] | None = None
    position_bar_m: float = 0.003
    orientation_bar_rad: float = float(np.radians(1.5))
    push: Push | None = None
    timeout_s: float = 30.0  # in the target within this, or not reached
    field: str = ""  # mode of the field; empty = the one in use
    hold_s: float = 1.5  # the errors reported are the largest of the last second of it


class Reach(ScriptedService):
    """Runs the script once; `finished` says when."""

    trigger = Period(PERIOD_S)
    reads: tuple[AnyStream, ...] = (
        ROBOT_STATUS,
        DYNAMICS_STATUS,
        CARTESIAN_STATUS,
        PLANT_TRUTH,
        FIELD_STATUS,
    )
    writes = (GOAL, OBJECTS)
    calls = (ROBOT_CALL, FT_CALL, PUSH_CALL, FIELD_CALL)

    def __init__(self, robot: RobotFile, options: ReachOptions) -> None:
        self._robot = robot
        self._options = options
        self._model = limb_model(robot)
        self.recording = Recording(
            robot, options.seed, options.position_bar_m, options.orientation_bar_rad
        )
        self.scene: Scene | None = None
        self._goal: Goal | None = None
        super().__init__(robot.chain)

    def script(self) -> Script:
        """The job, and in any case the way down."""
        try:
            yield from self._job()
        except AbandonedError as error:
            yield from self._fail(str(error))
            return
        yield from self._come_down()

    def _fail(self, reason: str) -> Script:
        self.recording.failure = reason
        yield from self._come_down()

    def _job(self) -> Script:
        yield from self._prepare()
        yield from self._go()
        yield from self._hold()
        if self._options.push is not None:
            yield from self._push(self._options.push)

    def _prepare(self) -> Script:
        yield from self.calibrate(CALIBRATION_TIMEOUT_S)
        home = tuple(np.radians(self._robot.reach.home_deg).tolist())
        yield from self.ask("moving home", "move", q_rad=home, duration_s=HOME_S)
        yield from self._wait("settling", SETTLE_S)
        self.say("removing the offset of the force/torque sensor")
        limb = FtRequest(sensors=(self._robot.reach.sensor,))
        yield from self.answered(self.outputs.call(FT_CALL, limb), "zero_ft")
        yield from self.until(
            lambda: (s := self.inputs.latest(DYNAMICS_STATUS)) is not None and s.state == "running",
            TASK_TIMEOUT_S,
            "FT offset known",
        )
        yield from self.ask("position-direct mode", "mode", value="direct")
        if not self._options.stiff:
            compliant = self._robot.reach.compliant
            yield from self.ask(
                "switching the arm to compliant", "interaction", joints=compliant, value="compliant"
            )
        yield from self._wait("settling", SETTLE_S)
        if self._options.field:
            asked = FieldRequest(action="set", mode=self._options.field)
            yield from self.answered(self.outputs.call(FIELD_CALL, asked), "field mode")

    def _go(self) -> Script:
        hand = self.inputs.fresh(CARTESIAN_STATUS, STATE_AGE_S)
        if hand is None or not hand.q_rad:
            raise AbandonedError("the hand's pose is not known: joint states are missing")
        _, home_m = self._model.tip_pose(np.radians(self._robot.reach.home_deg))
        self.scene = draw_scene(
            home_m, self._options.seed, self._options.target_m, self._options.ball
        )
        kept = rotation.matrix(hand.hand_rotation_rad)
        turned = rotation_there(
            self._robot, self.scene, np.array(hand.q_rad), kept, self._options.seed
        )
        x, y, z = rotation.rotation_vector(turned).tolist()
        self._goal = Goal(stamp_ns=0, position_m=self.scene.target_m, rotation_rad=(x, y, z))
        self.recording.begin(self.now_ns, self.scene, turned)
        self.say("reaching")
        deadline_ns = self.now_ns + round(self._options.timeout_s * 1e9)
        inside_since_ns: int | None = None
        while self.now_ns < deadline_ns:
            self._send_scene()
            yield
            self._check()
            if not self.recording.inside():
                inside_since_ns = None
                continue
            inside_since_ns = self.now_ns if inside_since_ns is None else inside_since_ns
            if self.now_ns - inside_since_ns >= DWELL_S * 1e9:
                self.recording.reached_ns = inside_since_ns
                return
        self.say("not reached in time")

    def _hold(self) -> Script:
        self.say("holding")
        yield from self._for(self._options.hold_s)
        self.recording.judge(self.now_ns)

    def _push(self, push: Push) -> Script:
        self.say("being pushed")
        self.recording.push_begin_ns = self.now_ns
        request = PushRequest(force_n=push.force_n, duration_s=push.duration_s)
        yield from self.answered(self.outputs.call(PUSH_CALL, request), "push")
        yield from self._for(push.duration_s)
        self.recording.push_end_ns = self.now_ns
        self.say("coming back after the push")
        yield from self._for(push.recovery_s)

    def _come_down(self) -> Script:
        self.say("coming down")
        self.recording.ended = True
        if self._goal is not None:
            self._goal = None
            self.outputs.put(
                GOAL,
                Goal(
                    stamp_ns=self.now_ns,
                    position_m=(0.0,) * 3,
                    rotation_rad=(0.0,) * 3,
                    active=False,
                ),
            )
        status = self.inputs.latest(ROBOT_STATUS)
        if status is None or status.phase in ("opening", "handshake", "configuring", "failed"):
            return
        token = self.outputs.call(ROBOT_CALL, RobotRequest(action="stop"))
        deadline_ns = self.now_ns + round(TASK_TIMEOUT_S * 1e9)
        while self.now_ns < deadline_ns:
            yield
            reply = self.replies.get(token)
            status = self.inputs.latest(ROBOT_STATUS)
            if isinstance(reply, CallFailed):
                return
            if isinstance(reply, Reply) and (
                not reply.ok or (status and status.finished_task >= reply.task)
            ):
                return

    def _wait(self, what: str, seconds: float) -> Script:
        self.say(what)
        yield from self._for(seconds)

    def _for(self, seconds: float) -> Script:
        end_ns = self.now_ns + round(seconds * 1e9)
        while self.now_ns < end_ns:
            if self._goal is not None:
                self._send_scene()
            yield
            self._check()

    def _check(self) -> None:
        """Stop early when the robot faults or the stack falls silent."""
        if self.status().fault_count:
            raise AbandonedError(f"fault{self.faults()}")
        for stream in (ROBOT_STATUS, PLANT_TRUTH):
            if self.inputs.age_s(stream) > FEEDBACK_SILENCE_S:
                raise AbandonedError(f"{stream.name} has been silent for {FEEDBACK_SILENCE_S} s")

    def say(self, what: str) -> None:
        """What it is doing now."""
        super().say(what)
        self.recording.note(self.now_ns, what)

    def _send_scene(self) -> None:
        """Again and again, so that a field process that starts late knows."""
        assert self._goal is not None
        assert self.scene is not None
        balls: tuple[Obstacle, ...] = ()
        if self.scene.ball_centre_m is not None:
            balls = (Obstacle(self.scene.ball_centre_m, self.scene.ball_radius_m),)
        self.outputs.put(OBJECTS, Objects(stamp_ns=self.now_ns, obstacles=balls))
        self.outputs.put(
            GOAL,
            Goal(
                stamp_ns=self.now_ns,
                position_m=self._goal.position_m,
                rotation_rad=self._goal.rotation_rad,
            ),
        )

    def observe(self) -> None:
        """Keep what this period shows."""
        truth = self.inputs.new(PLANT_TRUTH)
        status = self.inputs.latest(ROBOT_STATUS)
        if status is not None:
            self.recording.status = status
            self.recording.torque_loop_ms.extend(
                [ms for s in self.inputs.all_new(ROBOT_STATUS) for ms in s.torque_loop_ms]
            )
        field = self.inputs.latest(FIELD_STATUS)
        if field is not None and not self.recording.ended:
            self.recording.field = field
        if truth is None:
            return
        self.recording.add(
            Sample(
                now_ns=self.now_ns,
                truth=truth,
                cartesian=self.inputs.fresh(CARTESIAN_STATUS, STATE_AGE_S),
                dynamics=self.inputs.fresh(DYNAMICS_STATUS, STATE_AGE_S),
                all_truths=self.inputs.all_new(PLANT_TRUTH),
            )
        )
