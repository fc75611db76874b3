"""What happened in one reach: samples over time, the judgement, and the report.

Everything is judged on the plant's true motion, never on an estimate.
"""

import math
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from dforc import rotation
from dforc.collision.clearance import BodyClearance
from dforc.collision.obstacles import sphere
from services.emulated.messages import PlantTruth
from services.fields.messages import FieldStatus
from services.fields.robot_body import robot_body
from services.messages import NAN3, CartesianStatus, DynamicsStatus, Floats, Vector3
from services.reaching.reach_scene import Scene
from services.robot_messages import RobotStatus
from services.robotfile.robot_tables import RobotFile

Vector = NDArray[np.float64]
Report = dict[str, object]

JUDGED_S = 1.0  # the errors reported are the largest of this last stretch of the hold


@dataclass(frozen=True, kw_only=True)
class Sample:
    """What one period of the job saw."""

    now_ns: int
    truth: PlantTruth
    cartesian: CartesianStatus | None
    dynamics: DynamicsStatus | None
    all_truths: tuple[PlantTruth, ...]


@dataclass(kw_only=True)
class Trace:
    """Samples of the reach, one entry per period, seconds from its start."""

    time_s: list[float] = field(default_factory=list)
    tip_m: list[Vector3] = field(default_factory=list)
    point_m: list[Vector3] = field(default_factory=list)
    plan_m: list[Vector3] = field(default_factory=list)
    position_error_m: list[float] = field(default_factory=list)
    orientation_error_rad: list[float] = field(default_factory=list)
    clearance_m: list[float] = field(default_factory=list)
    arm_clearance_m: list[float] = field(default_factory=list)
    estimated_nm: list[tuple[float, ...]] = field(default_factory=list)
    motor_nm: list[tuple[float, ...]] = field(default_factory=list)
    external_force_n: list[float] = field(default_factory=list)
    gated: list[bool] = field(default_factory=list)
    q_rad: list[tuple[float, ...]] = field(default_factory=list)
    dq_rad_s: list[tuple[float, ...]] = field(default_factory=list)


class Recording:
    """Filled by the job while it runs, read by report and plot."""

    def __init__(
        self, robot: RobotFile, seed: int, position_bar_m: float, orientation_bar_rad: float
    ) -> None:
        self._clearance = BodyClearance(robot_body(robot), robot.chain)
        self._seed = seed
        self._bars = (position_bar_m, orientation_bar_rad)
        self.joints = robot.chain
        self.trace = Trace()
        self.notes: list[tuple[float, str]] = []
        self.failure = ""
        self.status: RobotStatus | None = None
        self.truth: PlantTruth | None = None
        self.followed: CartesianStatus | None = None  # the last that followed a point
        self.field: FieldStatus | None = None  # the last before the arm comes down
        self.torque_loop_ms: list[float] = []
        self.scene: Scene | None = None
        self.reached_ns: int | None = None
        self.push_begin_ns: int | None = None
        self.push_end_ns: int | None = None
        self.begin_ns = 0
        self.ended = False  # the arm comes down: no samples from here on
        self.plant_ticks = (0, 0)  # first and last seen
        self._goal_rotation: Vector = np.eye(3)
        self._target: Vector = np.zeros(3)
        self._judged: tuple[float, float] | None = None
        self._min_clearance_m = math.inf
        self._at: tuple[int, ...] = ()  # where the chain's joints stand among all of the robot

    def begin(self, now_ns: int, scene: Scene, goal_rotation: Vector) -> None:
        """The goal has been given: from now on samples are kept."""
        self.begin_ns = now_ns
        self.scene = scene
        self._target = np.array(scene.target_m)
        self._goal_rotation = goal_rotation

    def note(self, now_ns: int, what: str) -> None:
        """A step of the job begins."""
        if not self.notes or self.notes[-1][1] != what:
            self.notes.append((now_ns * 1e-9, what))

    def add(self, sample: Sample) -> None:
        """Keep one period."""
        if self.truth is None:
            self.plant_ticks = (sample.truth.ticks, sample.truth.ticks)
        self.truth = sample.truth
        self.plant_ticks = (self.plant_ticks[0], sample.truth.ticks)
        if sample.cartesian is not None and sample.cartesian.ik_status:
            self.followed = sample.cartesian
        if self.scene is None or self.ended:
            return
        tip = np.array(sample.truth.tip_position_m)
        turned = rotation.matrix(sample.truth.tip_rotation_rad)
        trace, plan = self.trace, sample.cartesian
        trace.time_s.append((sample.now_ns - self.begin_ns) * 1e-9)
        trace.tip_m.append(sample.truth.tip_position_m)
        trace.point_m.append(plan.point_position_m if plan else NAN3)
        trace.plan_m.append(plan.plan_position_m if plan else NAN3)
        trace.position_error_m.append(float(np.linalg.norm(tip - self._target)))
        trace.orientation_error_rad.append(rotation.angle_between(turned, self._goal_rotation))
        trace.external_force_n.append(plan.external_force_n if plan else math.nan)
        trace.gated.append(bool(plan and plan.gated))
        trace.motor_nm.append(self._of_chain(sample.truth, sample.truth.tau_nm))
        trace.q_rad.append(self._of_chain(sample.truth, sample.truth.q_rad))
        trace.dq_rad_s.append(self._of_chain(sample.truth, sample.truth.dq_rad_s))
        trace.estimated_nm.append(sample.dynamics.tau_nm if sample.dynamics else ())
        self._add_clearance(sample)

    def inside(self) -> bool:
        """Whether the hand is inside both bars now."""
        trace = self.trace
        return bool(trace.time_s) and (
            trace.position_error_m[-1] <= self._bars[0]
            and trace.orientation_error_rad[-1] <= self._bars[1]
        )

    def judge(self, now_ns: int) -> None:
        """The hold is over: the errors are the largest of its last second."""
        since_s = (now_ns - self.begin_ns) * 1e-9 - JUDGED_S
        first = int(np.searchsorted(self.trace.time_s, since_s))
        self._judged = (
            max(self.trace.position_error_m[first:]),
            max(self.trace.orientation_error_rad[first:]),
        )

    def report(self) -> Report:
        """One flat object; lengths in mm, angles in degrees."""
        position_m, orientation_rad = self._judged or self._last_errors()
        reached = (
            self.reached_ns is not None
            and not self.failure
            and position_m <= self._bars[0]
            and orientation_rad <= self._bars[1]
        )
        status, truth, followed, field = self.status, self.truth, self.followed, self.field
        lost = (status.frames_lost if status else 0) + (truth.frames_lost if truth else 0)
        return {
            "position_error_mm": _rounded(position_m * 1e3),
            "orientation_error_deg": _rounded(math.degrees(orientation_rad)),
            "min_clearance_mm": _rounded(self._min_clearance_m * 1e3),
            "min_arm_clearance_mm": _rounded(
                min(self.trace.arm_clearance_m, default=math.inf) * 1e3
            ),
            "reached": reached,
            "time_to_target_s": self._time_to_target_s(),
            "limit_violations": truth.limit_violations if truth else 0,
            "joints_not_held_to_limits": list(truth.limits_waiting) if truth else [],
            "board_faults": max(
                truth.board_faults if truth else 0, status.fault_count if status else 0
            ),
            "frames_total": (status.frames_sent + status.frames_received) if status else 0,
            "frames_lost": lost,
            "seed": self._seed,
            "ik_status": followed.ik_status if followed else "none",
            "ik_position_error_mm": (
                _rounded(followed.ik_position_error_m * 1e3) if followed else None
            ),
            "field_mode": field.mode if field else "",
            "field_state": field.state if field else "",
            "field_reason": field.reason if field else "",
            "field_distance_mm": _rounded(field.goal_distance_m * 1e3) if field else None,
            "frames_dropped": status.frames_dropped if status else 0,
            "refused_commands": status.refused_commands if status else 0,
            "foreign_frames": status.foreign_frames if status else 0,
            "faults": list(status.faults) if status else [],
            "target_m": list(self.scene.target_m) if self.scene else None,
            "ball_centre_m": self._ball_centre(),
            "ball_radius_m": self.scene.ball_radius_m if self.scene else None,
            "max_error_while_moving_mm": _rounded(self._worst_tracking_m() * 1e3),
            "failure": self.failure,
        }

    def _add_clearance(self, sample: Sample) -> None:
        assert self.scene is not None
        if self.scene.ball_centre_m is None:
            return
        centre, radius = np.array(self.scene.ball_centre_m), self.scene.ball_radius_m
        ball = sphere("ball", self.scene.ball_centre_m, radius)
        for truth in sample.all_truths:  # every one: a reach passes the ball between two periods
            tip = np.array(truth.tip_position_m)
            clearance = float(np.linalg.norm(tip - centre)) - radius
            self._min_clearance_m = min(self._min_clearance_m, clearance)
        tip = np.array(sample.truth.tip_position_m)
        self.trace.clearance_m.append(float(np.linalg.norm(tip - centre)) - radius)
        q = np.array(self.trace.q_rad[-1])
        self.trace.arm_clearance_m.append(self._clearance.of(q, ball))

    def _of_chain(self, truth: PlantTruth, values: Floats) -> Floats:
        """Those of the reaching chain, out of the values of every joint of the robot."""
        if truth.joints == self.joints:
            return values
        if not self._at:
            self._at = tuple(map(truth.joints.index, self.joints))
        return tuple([values[i] for i in self._at])

    def _ball_centre(self) -> list[float] | None:
        if self.scene is None or self.scene.ball_centre_m is None:
            return None
        return list(self.scene.ball_centre_m)

    def _last_errors(self) -> tuple[float, float]:
        if not self.trace.time_s:
            return math.nan, math.nan
        return self.trace.position_error_m[-1], self.trace.orientation_error_rad[-1]

    def _time_to_target_s(self) -> float | None:
        if self.reached_ns is None:
            return None
        return _rounded((self.reached_ns - self.begin_ns) * 1e-9)

    def _worst_tracking_m(self) -> float:
        if not self.trace.time_s:
            return math.nan
        apart = np.array(self.trace.tip_m) - np.array(self.trace.plan_m)
        apart = apart[np.isfinite(apart).all(axis=1)]
        return float(np.linalg.norm(apart, axis=1).max()) if len(apart) else math.nan


def _rounded(value: float) -> float | None:
    """Six decimals, None where there is no number: JSON has no NaN."""
    return round(value, 6) if math.isfinite(value) else None
