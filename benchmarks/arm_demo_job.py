"""The arm demo as a client of the stack: goals in turn, and a ball that is moved between them.

What the stack is told of the ball is noisy and comes at a camera's rate; what is judged is where
the ball and the plant truly were.
"""

import math
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from benchmarks.arm_demo_ball import MovedBall
from dforc.collision.obstacles import sphere
from dforc.rotation import rotation_vector
from services.emulated.messages import PlantTruth
from services.experiments.whole_arm.referee import Standing, Verdict
from services.experiments.whole_arm.setting import ArmSetting, arm_setting
from services.messages import Goal, Objects, Vector3, WorldObject
from services.reaching.reach import Reach, ReachOptions
from services.reaching.reach_scene import REACH_M
from services.robotfile.robot_tables import RobotFile
from services.script import Script
from services.streams import FIELD_STATUS, GOAL, OBJECTS, PLANT_TRUTH

Array = NDArray[np.float64]

GOALS = 8
WITHIN_M, WITHIN_S = 0.010, 0.2
PER_GOAL_S = 12.0
SPREAD_M = 0.02
BALL_M = (0.03, 0.05)
CAMERA_HZ = (30.0, 100.0)
NOISE_M = 0.005
GIVE_WAY = ("r_forearm", "r_hand")  # the others cannot; nobody pushes the ball into them
AFTER_S = 1.0


@dataclass
class Shown:
    """What one run showed."""

    seed: int
    reached: int = 0
    asked: int = 0
    times_s: list[float] = field(default_factory=list)
    verdict: Verdict = field(default_factory=Verdict)
    states: dict[str, int] = field(default_factory=dict)
    first: tuple[int, int] | None = None  # the plant's milliseconds and the clock's ns, of the
    last: tuple[int, int] | None = None  # judged motion: both must go on alike
    faults: tuple[str, ...] = ()  # that the HAL met by itself, such as a joint near its limit
    failure: str = ""

    @property
    def problem(self) -> str:
        """Why the run says nothing of the demo; empty where it does."""
        if self.failure:
            return self.failure
        was_judged = math.isfinite(self.verdict.obstacle.distance_m)
        return "" if was_judged else "nothing was judged: the plant told of no posture"

    @property
    def realtime(self) -> float:
        """Plant time over the clock's: 1 where the stack keeps its time."""
        if self.first is None or self.last is None or self.last[1] == self.first[1]:
            return 0.0
        return 1e6 * (self.last[0] - self.first[0]) / (self.last[1] - self.first[1])


class ArmDemo(Reach):
    """Prepares as the main job does, then reaches to and fro past the ball."""

    def __init__(self, robot: RobotFile, seed: int, *, stiff: bool = False) -> None:
        self._setting: ArmSetting = arm_setting(robot.robot.name + ":reach")
        self.shown = Shown(seed)
        rng = np.random.default_rng([seed, 77])
        home = self._setting.hands(self._setting.home_rad)[0][1]
        spread = rng.uniform(-SPREAD_M, SPREAD_M, (2, 3))
        self._goals_m = (home + REACH_M + spread[0], home + spread[1])
        fixed = [k for k, c in enumerate(self._setting.capsules) if not c.link.startswith(GIVE_WAY)]
        segments = self._setting.referee.segments(self._setting.whole(self._setting.home_rad))
        radii = np.array([c.radius_m for c in self._setting.capsules])
        self._ball = MovedBall(
            rng,
            self._goals_m,
            float(rng.uniform(*BALL_M)),
            (segments[fixed], radii[fixed]),
            (GOALS + 1) * PER_GOAL_S,
        )
        self._period_ns = round(1e9 / float(rng.uniform(*CAMERA_HZ)))
        self._noise = rng
        self._begun_ns = 0
        self._seen_ns = 0
        self._before: tuple[int, Standing] | None = None
        self._tip_m: Array | None = None
        self._columns: list[int] = []
        super().__init__(robot, ReachOptions(seed=seed, stiff=stiff))

    def _job(self) -> Script:
        yield from self._prepare()
        R, _ = self._setting.hands(self._setting.home_rad)[0]
        x, y, z = rotation_vector(R).tolist()
        ball_x, ball_y, ball_z = self._ball.at(0.0).tolist()
        self._setting.referee.face((sphere("ball", (ball_x, ball_y, ball_z), self._ball.radius_m),))
        self._begun_ns = self.now_ns
        for number in range(GOALS):
            yield from self._reach_past(self._goals_m[number % 2], (x, y, z))
        self.say("holding")
        end_ns = self.now_ns + round(AFTER_S * 1e9)
        while self.now_ns < end_ns:
            yield from self._moment()
        self._begun_ns = 0

    def _reach_past(self, goal_m: Array, turn: Vector3) -> Script:
        x, y, z = goal_m.tolist()
        self.shown.asked += 1
        self.say(f"reaching, goal {self.shown.asked} of {GOALS}")
        self._goal = Goal(stamp_ns=self.now_ns, position_m=(x, y, z), rotation_rad=turn)
        self.outputs.put(GOAL, self._goal)
        from_ns, within_ns = self.now_ns, 0
        while self.now_ns - from_ns < PER_GOAL_S * 1e9:
            yield from self._moment()
            near = self._tip_m is not None and np.linalg.norm(self._tip_m - goal_m) <= WITHIN_M
            if not near:
                within_ns = 0
                continue
            within_ns = within_ns or self.now_ns
            if self.now_ns - within_ns >= WITHIN_S * 1e9:
                self.shown.reached += 1
                self.shown.times_s.append((within_ns - from_ns) * 1e-9)
                return

    def _moment(self) -> Script:
        """One period: tell where the ball seems to be, and go on."""
        if self.now_ns - self._seen_ns >= self._period_ns:
            self._seen_ns = self.now_ns
            place = self._ball.at(self._time_s(self.now_ns))
            x, y, z = (place + self._noise.normal(0.0, NOISE_M, 3)).tolist()
            variance = NOISE_M**2
            ball = WorldObject(
                name="ball",
                shape="sphere",
                size_m=(self._ball.radius_m,),
                position_m=(x, y, z),
                covariance_m2=(variance, 0.0, 0.0, variance, 0.0, variance),
            )
            self.outputs.put(OBJECTS, Objects(stamp_ns=self.now_ns, objects=(ball,), source="eyes"))
        yield
        self._check()

    def observe(self) -> None:
        """Judge every posture that the plant tells of."""
        super().observe()
        status = self.inputs.new(FIELD_STATUS)
        if status is not None and self._begun_ns:
            self.shown.states[status.state] = self.shown.states.get(status.state, 0) + 1
        for truth in self.inputs.all_new(PLANT_TRUTH):
            self._tip_m = np.array(truth.tip_position_m)
            if self._begun_ns and truth.stamp_ns >= self._begun_ns:
                self._judge(truth)

    def _judge(self, truth: PlantTruth) -> None:
        if not self._columns:
            self._columns = [truth.joints.index(name) for name in self._setting.body.joints]
        q = np.array(truth.q_rad)[self._columns]
        self.shown.last = truth.ticks, truth.stamp_ns
        self.shown.first = self.shown.first or self.shown.last
        now = Standing(q, self._ball.at(self._time_s(truth.stamp_ns))[None, :])
        if self._before is not None:
            from_ns, before = self._before
            lasts_s = (truth.stamp_ns - from_ns) * 1e-9
            referee = self._setting.referee
            referee.judge(self.shown.verdict, before, now, self._time_s(from_ns), lasts_s)
        self._before = truth.stamp_ns, now

    def _time_s(self, at_ns: int) -> float:
        return (at_ns - self._begun_ns) * 1e-9

    def _check(self) -> None:
        """Stop early when the robot fails; a joint that was made stiff is noted, and goes on."""
        self.shown.faults = self.status().faults
        if not self.shown.faults or self.status().phase == "failed":
            super()._check()

    def _fail(self, reason: str) -> Script:
        self._begun_ns = 0
        self.shown.failure = reason
        yield from super()._fail(reason)
