"""Random moves of a hand between poses, by either law, on an ideal and on a slow arm."""

from dataclasses import dataclass, replace

import numpy as np

from dforc.arrays import Matrix, Vector
from dforc.cartesian.controller import CartesianController
from dforc.cartesian.params import CartesianParams, CouplingParams, Law
from dforc.cartesian.state import CartesianOutput, Measurement
from dforc.cartesian.targets import PoseTarget, ReachTarget
from dforc.limits import JointLimits
from dforc.rotation import angle_between, matrix, rotation_error
from services.core.errors import ServiceError
from services.experiments.cartesian.arm import Arm, Pose, Reached
from services.experiments.cartesian.metrics import MoveFigures, judge_move, minimum_jerk
from services.experiments.cartesian.plants import lagged
from services.experiments.rows import Row, at_most, within

PERIOD_S = 0.01
TIME_S = 1.0  # T
SHORTEST_M, LONGEST_M, MOST_TURN_RAD = 0.12, 0.41, np.radians(120.0)
NEAR_M, NEAR_RAD = 1e-4, 1e-3  # inverse kinematics has to reach both ends
UNHURRIED_RAD_S = 6.0  # T is kept whatever a joint needs; the robot's own limits come last
GAMMAS = (0.05, 10.0, 1000.0, 1e6)


@dataclass(frozen=True, slots=True, kw_only=True)
class Move:
    """From one posture to the pose of another."""

    q_start: Vector
    q_goal: Vector
    start: Pose
    goal: Pose

    @property
    def target(self) -> ReachTarget:
        """What the controller is told."""
        pose = PoseTarget(position_m=self.goal.position_m, rotation=self.goal.rotation)
        return ReachTarget(tips=(pose,), q_rad=self.q_goal)


@dataclass(frozen=True, slots=True, kw_only=True)
class Judged:
    """One move as it was made."""

    figures: MoveFigures
    slow_jerk: float  # on the slow arm
    beside_profile: float  # rms of the way's share against minimum jerk of T, from onset to T
    turned_beside_rad: float  # largest angle from the geodesic in minimum jerk
    outside_rad: float  # largest violation of the planners' limits and rows by the plan
    slow_outside_rad: float  # of the robot's limits by the joints of the slow arm
    joint_jerk_step: float  # largest change of a joint's speed in a period, over its peak
    duration_s: float
    error_m: float
    error_rad: float


def random_moves(arm: Arm, count: int, seed: int) -> list[Move]:
    """Both ends by inverse kinematics from random postures inside everything."""
    draw, found = np.random.default_rng(seed), list[Move]()
    limits = arm.limits
    while len(found) < count:
        ends: list[Pose] = []
        while len(ends) < 2:
            q = draw.uniform(limits.lower_rad, limits.upper_rad)
            if limits.violation(q) < 0.0:
                ends.append(arm.pose(q))
        way_m = float(np.linalg.norm(ends[1].position_m - ends[0].position_m))
        turn_rad = angle_between(ends[0].rotation, ends[1].rotation)
        if not SHORTEST_M <= way_m <= LONGEST_M or turn_rad >= MOST_TURN_RAD:
            continue
        start = reached(arm, ends[0], arm.rest_rad)
        goal = None if start is None else reached(arm, ends[1], start.q_rad)
        if start is None or goal is None:
            continue
        if max(start.off_m, goal.off_m) < NEAR_M and max(start.off_rad, goal.off_rad) < NEAR_RAD:
            found.append(
                Move(q_start=start.q_rad, q_goal=goal.q_rad, start=start.pose, goal=goal.pose)
            )
    return found


def reached(arm: Arm, pose: Pose, q_start: Vector) -> Reached | None:
    """The posture for a pose; None where inverse kinematics came to no end."""
    try:
        return arm.reached(pose, q_start)
    except ServiceError:
        return None


def params_of(
    law: Law, gamma: float | None = None, speeds: tuple[float, ...] | None = None
) -> CartesianParams:
    """Of the moves: T 1 s, joints as quick as they have to be unless `speeds` limits them."""
    limit = UNHURRIED_RAD_S if speeds is None else speeds
    coupling = CouplingParams(gamma=gamma, speed_limit_rad_s=limit)
    return CartesianParams(law=law, period_s=PERIOD_S, trajectory_time_s=TIME_S, coupling=coupling)


def make(arm: Arm, move: Move, params: CartesianParams, periods: int) -> list[CartesianOutput]:
    """The move on an arm that is where its references are."""
    controller = CartesianController([arm.tip], arm.limits, params)
    state, outputs, stiff = controller.start(move.q_start), [], (False,) * len(arm.joints)
    for _ in range(periods):
        measured = Measurement(q_rad=state.q_plan, compliant=stiff)
        state, output = controller.step(state, measured, move.target)
        outputs.append(output)
    return outputs


def judge(arm: Arm, move: Move, outputs: list[CartesianOutput], seed: int) -> Judged:
    """Every figure of one move."""
    angles = np.vstack([move.q_start] + [output.plan_q_rad for output in outputs])
    poses = [arm.pose(q) for q in angles]
    positions = np.array([pose.position_m for pose in poses])
    references = np.vstack([move.q_start] + [output.q_rad for output in outputs])
    slow = lagged(references, PERIOD_S, seed)
    slow_positions = np.array([arm.pose(q).position_m for q in slow])
    start, goal = move.start.position_m, move.goal.position_m
    duration_s = outputs[0].duration_s
    times_s: Vector = np.arange(len(angles), dtype=np.float64) * PERIOD_S
    ideal = minimum_jerk(times_s / duration_s)
    share = (positions - start) @ (goal - start) / float((goal - start) @ (goal - start))
    until = round(duration_s / PERIOD_S) + 1
    whole = rotation_error(move.start.rotation, move.goal.rotation)
    turned = [
        angle_between(pose.rotation, matrix(s * whole) @ move.start.rotation)
        for pose, s in zip(poses, ideal.tolist(), strict=True)
    ]
    speeds = np.array([output.dq_rad_s for output in outputs])
    return Judged(
        figures=judge_move(positions, start, goal, PERIOD_S),
        slow_jerk=judge_move(slow_positions, start, goal, PERIOD_S).jerk,
        beside_profile=float(np.sqrt(np.square(share - ideal)[:until].mean())),
        turned_beside_rad=max(turned),
        outside_rad=violation(arm.limits, angles),
        slow_outside_rad=violation(arm.hard_limits, slow),
        joint_jerk_step=float(np.abs(np.diff(speeds, axis=0)).max() / np.abs(speeds).max()),
        duration_s=duration_s,
        error_m=float(np.linalg.norm(positions[-1] - goal)),
        error_rad=angle_between(poses[-1].rotation, move.goal.rotation),
    )


def violation(limits: JointLimits, angles: Matrix) -> float:
    """Largest one of a motion [rad]; 0 when none."""
    return max(0.0, max(limits.violation(q) for q in angles))


def move_rows(arm: Arm, moves: list[Move]) -> list[Row]:
    """Both laws side by side; bars on the time-to-go law."""
    rows: list[Row] = []
    for law in Law:
        periods = 160 if law is Law.TIME_TO_GO else 300
        params = params_of(law)
        judged = [
            judge(arm, move, make(arm, move, params, periods), seed)
            for seed, move in enumerate(moves)
        ]
        rows += own_rows(judged) if law is Law.TIME_TO_GO else reference_rows(judged)
    return rows


def own_rows(judged: list[Judged]) -> list[Row]:
    """K1 to K4 of the time-to-go law."""
    figures = [one.figures for one in judged]
    across = [one.perpendicular * 100.0 for one in figures]
    beside = [one.deviation * 100.0 for one in figures]
    what = f"time_to_go, {len(judged)} moves"
    t98 = [one.t98_s / TIME_S for one in figures]
    turned = [np.degrees(one.turned_beside_rad) for one in judged]
    return [
        at_most(f"{what}: off the straight line, largest", max(across), "%", 3.0),
        at_most(f"{what}: off the straight line, median", float(np.median(across)), "%", 1.0),
        at_most(f"{what}: off the minimum-jerk motion, largest", max(beside), "%", 3.0),
        at_most(f"{what}: off the minimum-jerk motion, median", float(np.median(beside)), "%", 1.0),
        at_most(
            f"{what}: profile rms, largest",
            max(one.beside_profile for one in judged) * 100.0,
            "%",
            0.5,
        ),
        within(f"{what}: 98 % of the way, over T, earliest", min(t98), "", 0.862, 0.898),
        within(f"{what}: 98 % of the way, over T, latest", max(t98), "", 0.862, 0.898),
        at_most(
            f"{what}: overshoot, largest", max(one.overshoot for one in figures) * 100.0, "%", 0.01
        ),
        at_most(f"{what}: jerk over the least, largest", max(one.jerk for one in figures), "", 1.1),
        at_most(
            f"{what}: jerk over the least on the slow arm, largest",
            max(one.slow_jerk for one in judged),
            "",
            2.0,
        ),
        at_most(f"{what}: limits and rows crossed by", _degrees(judged, "outside_rad"), "deg", 0.0),
        at_most(
            f"{what}: crossed by the joints of the slow arm",
            _degrees(judged, "slow_outside_rad"),
            "deg",
            0.0,
        ),
        Row(f"{what}: off the geodesic, median", float(np.median(turned)), "deg"),
        Row(f"{what}: off the geodesic, largest", max(turned), "deg"),
        *_ends(what, judged),
    ]


def reference_rows(judged: list[Judged]) -> list[Row]:
    """The reference law on the same moves: to compare with, without bars but for safety."""
    figures = [one.figures for one in judged]
    across = [one.perpendicular * 100.0 for one in figures]
    beside = [one.deviation * 100.0 for one in figures]
    what = f"reference, {len(judged)} moves"
    return [
        Row(f"{what}: off the straight line, largest", max(across), "%"),
        Row(f"{what}: off the straight line, median", float(np.median(across)), "%"),
        Row(f"{what}: off the minimum-jerk motion, largest", max(beside), "%"),
        Row(f"{what}: off the minimum-jerk motion, median", float(np.median(beside)), "%"),
        Row(
            f"{what}: profile rms, largest",
            max(one.profile_rms for one in figures) * 100.0,
            "%",
        ),
        Row(
            f"{what}: 98 % of the way, over T, median",
            float(np.median([one.t98_s / TIME_S for one in figures])),
        ),
        Row(f"{what}: jerk over the least, median", float(np.median([f.jerk for f in figures]))),
        Row(
            f"{what}: jerk over the least on the slow arm, median",
            float(np.median([one.slow_jerk for one in judged])),
        ),
        at_most(f"{what}: limits and rows crossed by", _degrees(judged, "outside_rad"), "deg", 0.0),
        *_ends(what, judged),
    ]


def _ends(what: str, judged: list[Judged]) -> list[Row]:
    return [
        Row(
            f"{what}: largest change of a joint's speed in 10 ms, over its peak, median",
            float(np.median([one.joint_jerk_step for one in judged])) * 100.0,
            "%",
        ),
        Row(f"{what}: end off the goal, largest", max(one.error_m for one in judged) * 1e3, "mm"),
        Row(f"{what}: end off the goal, largest", _degrees(judged, "error_rad"), "deg"),
    ]


def _degrees(judged: list[Judged], name: str) -> float:
    largest = float(np.degrees(max(getattr(one, name) for one in judged)))
    return largest if largest > 1e-7 else 0.0


def gamma_rows(arm: Arm, moves: list[Move]) -> list[Row]:
    """Limits and rows at any gamma, by both laws, and what the law without rows would do."""
    rows: list[Row] = []
    n = arm.limits.n
    alone = JointLimits.make(arm.limits.lower_rad, arm.limits.upper_rad)
    for law in Law:
        for gamma in GAMMAS:
            params = params_of(law, gamma)
            outside = max(
                violation(arm.limits, np.array([o.plan_q_rad for o in make(arm, m, params, 200)]))
                for m in moves
            )
            name = f"{law}, gamma {gamma:g}: limits and rows crossed by"
            rows.append(at_most(name, float(np.degrees(outside)) * (outside > 1e-9), "deg", 0.0))
    for gamma in (0.05, 100.0):
        controller = CartesianController([arm.tip], alone, params_of(Law.REFERENCE, gamma))
        outside = 0.0
        for move in moves:
            state = controller.start(move.q_start)
            for _ in range(200):
                measured = Measurement(q_rad=state.q_plan, compliant=(False,) * n)
                state, output = controller.step(state, measured, move.target)
                outside = max(outside, arm.limits.violation(output.plan_q_rad))
        name = f"reference, gamma {gamma:g}, as iKin without rows: crossed by"
        rows.append(Row(name, float(np.degrees(outside)), "deg"))
    return rows


def robot_speed_rows(arm: Arm, moves: list[Move]) -> list[Row]:
    """With the robot's own joint speeds T stretches; shape and limits are to stay."""
    params = params_of(Law.TIME_TO_GO, speeds=arm.speed_limits_rad_s)
    judged = []
    for seed, move in enumerate(moves):
        first = make(arm, move, params, 1)[0].duration_s
        outputs = make(arm, move, replace(params), round(1.6 * first / PERIOD_S))
        judged.append(judge(arm, move, outputs, seed))
    what = f"robot's joint speeds, {len(moves)} moves"
    across = [one.figures.perpendicular * 100.0 for one in judged]
    beside = [one.figures.deviation * 100.0 for one in judged]
    t98 = [one.figures.t98_s / one.duration_s for one in judged]
    return [
        Row(
            f"{what}: T stretched to, median", float(np.median([j.duration_s for j in judged])), "s"
        ),
        at_most(f"{what}: off the straight line, largest", max(across), "%", 3.0),
        Row(f"{what}: off the straight line, median", float(np.median(across)), "%"),
        Row(f"{what}: off the minimum-jerk motion, largest", max(beside), "%"),
        Row(f"{what}: off the minimum-jerk motion, median", float(np.median(beside)), "%"),
        Row(f"{what}: 98 % of the way, over the stretched T, median", float(np.median(t98))),
        Row(f"{what}: 98 % of the way, over the stretched T, latest", max(t98)),
        at_most(f"{what}: limits and rows crossed by", _degrees(judged, "outside_rad"), "deg", 0.0),
    ]
