"""Figure 5, D and E: the paper's field on the emulated robot, through its boards and CAN frames.

The field service in mode `dforc` with the paper's constants, no margin; the joints are stiff. What
the hand truly did is the plant's own word.
"""

from collections.abc import Sequence
from contextlib import closing
from dataclasses import dataclass, field

import numpy as np

from dforc.arrays import Matrix, Vector
from dforc.rotation import angle_between, matrix
from services.core.errors import ServiceError
from services.core.service import CallFailed, Period
from services.core.stream import AnyStream
from services.emulated.messages import PlantTruth
from services.emulated.simulation import Progress, Simulation
from services.fields.messages import FieldReply, FieldRequest
from services.messages import Goal, Objects, Obstacle, Vector3
from services.robotfile.robot_tables import RobotFile
from services.script import AbandonedError, Script, ScriptedService
from services.streams import (
    FIELD_CALL,
    GOAL,
    OBJECTS,
    PLANT_TRUTH,
    ROBOT_CALL,
    ROBOT_STATUS,
    VIRTUAL_POINT,
)

PERIOD_S = 0.01
ANSWER_TIMEOUT_S = 5.0
HOME_S, SETTLE_S = 2.0, 1.0
REACH_S = 13.0  # eq. 3 needs 9.5 s to come within 2 mm from 0.3 m away, and its detour some more
REPEAT_PERIODS = 10
PAPER_GAINS = (("K", 4.0), ("D", 8.0), ("G", 8.0), ("margin", 0.0))
SOURCE = "figure 5"


@dataclass(frozen=True, slots=True, kw_only=True)
class StackScene:
    """One reach from home."""

    name: str
    target_m: Vector3
    rotation_rad: Vector3
    ball: Obstacle | None = None


@dataclass(slots=True, eq=False, kw_only=True)
class StackReach:
    """What one reach came to, every 10 ms from the goal on."""

    scene: StackScene
    seed: int
    point_m: list[Vector3] = field(default_factory=list)
    hand_m: list[Vector3] = field(default_factory=list)
    hand_rotation_rad: list[Vector3] = field(default_factory=list)
    violations: int = 0  # ticks of the plant in which a joint was beyond its range

    @property
    def error_m(self) -> float:
        """Of the hand, at the end."""
        return float(np.linalg.norm(np.array(self.hand_m[-1]) - np.array(self.scene.target_m)))

    @property
    def error_rad(self) -> float:
        """Of the hand, at the end."""
        wanted = matrix(self.scene.rotation_rad)
        return angle_between(matrix(self.hand_rotation_rad[-1]), wanted)

    def clearance_m(self, path: Sequence[Vector3]) -> float:
        """Smallest distance from the ball's surface; infinite without one."""
        ball = self.scene.ball
        if ball is None:
            return float("inf")
        away: Vector = np.linalg.norm(np.array(path) - np.array(ball.centre_m), axis=1)
        return float(away.min()) - ball.radius_m

    @property
    def path_m(self) -> Matrix:
        """Of the hand (k, 3)."""
        return np.array(self.hand_m)


def run_scenes(
    robot: RobotFile, scenes: Sequence[StackScene], seed: int, progress: Progress | None = None
) -> list[StackReach]:
    """All scenes, one after another, on one emulated robot in virtual time.

    Raises:
        ServiceError: the robot did not carry one through.
    """
    trial = StackTrial(robot, scenes, seed)
    with closing(Simulation(robot, seed, guests={"figure 5": trial})) as simulation:
        simulation.run(trial, progress)
    if trial.failure:
        raise ServiceError(f"the emulated robot (plant {seed}) stopped: {trial.failure}")
    return trial.reaches


class StackTrial(ScriptedService):
    """Takes the robot through the scenes; `reaches` holds what came of them."""

    trigger = Period(PERIOD_S)
    reads: tuple[AnyStream, ...] = (ROBOT_STATUS, PLANT_TRUTH, VIRTUAL_POINT)
    writes = (GOAL, OBJECTS)
    calls = (ROBOT_CALL, FIELD_CALL)

    def __init__(self, robot: RobotFile, scenes: Sequence[StackScene], seed: int) -> None:
        self.reaches: list[StackReach] = []
        self.failure = ""
        self._robot = robot
        self._scenes = scenes
        self._seed = seed
        super().__init__(robot.chain)

    def script(self) -> Script:
        """Calibrate, choose the paper's field, then every scene."""
        try:
            yield from self.calibrate()
            yield from self._choose_field()
            for scene in self._scenes:
                yield from self._go_home()
                yield from self._reach(scene)
        except AbandonedError as error:
            self.failure = str(error)

    def _choose_field(self) -> Script:
        self.say("choosing the paper's field")
        request = FieldRequest(action="set", mode="dforc", preset="paper", gains=PAPER_GAINS)
        token = self.outputs.call(FIELD_CALL, request)
        deadline_ns = self.now_ns + round(ANSWER_TIMEOUT_S * 1e9)
        while self.now_ns < deadline_ns:
            yield
            for number, reply in self.inputs.replies(FIELD_CALL):
                if number != token:
                    continue
                if isinstance(reply, FieldReply) and reply.ok:
                    return
                reason = reply.reason if isinstance(reply, FieldReply | CallFailed) else ""
                raise AbandonedError(f"the field refused its constants: {reason}")
        raise AbandonedError("the field does not answer")

    def _go_home(self) -> Script:
        home = tuple(np.radians(self._robot.reach.home_deg).tolist())
        yield from self.ask("position mode", "mode", value="position")
        yield from self.ask("moving home", "move", q_rad=home, duration_s=HOME_S)
        yield from self._wait(SETTLE_S)
        yield from self.ask("position-direct mode", "mode", value="direct")
        yield from self._wait(SETTLE_S)

    def _reach(self, scene: StackScene) -> Script:
        self.say(f"reaching, {scene.name}")
        reach = StackReach(scene=scene, seed=self._seed)
        before = self._truth().limit_violations
        for period in range(round(REACH_S / PERIOD_S)):
            if period % REPEAT_PERIODS == 0:
                self._ask_for(scene)
            yield
            self._check()
            truth, point = self._truth(), self.inputs.latest(VIRTUAL_POINT)
            reach.hand_m.append(truth.tip_position_m)
            reach.hand_rotation_rad.append(truth.tip_rotation_rad)
            is_new = point is not None and period > 1
            reach.point_m.append(point.position_m if is_new and point else truth.tip_position_m)
        reach.violations = self._truth().limit_violations - before
        self.reaches.append(reach)
        nothing = Goal(
            stamp_ns=self.now_ns, position_m=(0.0,) * 3, rotation_rad=(0.0,) * 3, active=False
        )
        self.outputs.put(GOAL, nothing)
        self.outputs.put(OBJECTS, Objects(stamp_ns=self.now_ns, source=SOURCE))
        yield from self._wait(SETTLE_S)

    def _ask_for(self, scene: StackScene) -> None:
        balls = () if scene.ball is None else (scene.ball,)
        self.outputs.put(OBJECTS, Objects(stamp_ns=self.now_ns, obstacles=balls, source=SOURCE))
        self.outputs.put(
            GOAL,
            Goal(stamp_ns=self.now_ns, position_m=scene.target_m, rotation_rad=scene.rotation_rad),
        )

    def _truth(self) -> PlantTruth:
        truth = self.inputs.latest(PLANT_TRUTH)
        if truth is None:
            raise AbandonedError("the plant is silent")
        return truth

    def _wait(self, seconds: float) -> Script:
        for _ in range(round(seconds / PERIOD_S)):
            yield
            self._check()

    def _check(self) -> None:
        if self.status().fault_count:
            raise AbandonedError(f"fault{self.faults()}")
