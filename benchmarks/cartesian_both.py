"""Both hands at once over one waist: 17 joints, two poses."""

import numpy as np

from benchmarks.cartesian_moves import PERIOD_S, TIME_S, params_of
from dforc.arrays import Matrix, Vector
from dforc.cartesian.controller import CartesianController
from dforc.cartesian.params import Law
from dforc.cartesian.state import Measurement
from dforc.cartesian.targets import PoseTarget, ReachTarget
from dforc.cartesian.warm import warm
from dforc.ik.inverse_kinematics import IkStatus, InverseKinematics
from dforc.ik.problem import IkProblem, TipTarget
from services.core.clock import thread_cpu_ns
from services.experiments.cartesian.metrics import judge_move
from services.experiments.rows import Row, at_most
from services.reaching.limb import limb_problem
from services.robotfile.robot_tables import RobotFile

LIMB = "both_arms"
SHORTEST_M, LONGEST_M = 0.08, 0.41
TIMES = 3  # a tick counts with the best of so many equal runs
SPREAD_RAD = 0.35  # of the goal's posture about the start's


def both_hands_rows(robot: RobotFile, count: int, seed: int) -> list[Row]:
    """Random moves of both hands: straight, together, inside everything; and the time of a tick."""
    problem = limb_problem(robot, LIMB)
    ik, draw = InverseKinematics(problem), np.random.default_rng(seed)
    warm(CartesianController(problem.tips, problem.limits, params_of(Law.TIME_TO_GO)))
    across, beside, outside, spent, ends = [], [], [], [], []
    for q_start, q_goal in (_ends(problem, ik, draw) for _ in range(count)):
        runs = [_run(problem, q_start, q_goal) for _ in range(TIMES)]
        angles = runs[0][0]
        spent += np.min([us for _, us in runs], axis=0).tolist()
        outside.append(max(0.0, max(problem.limits.violation(q) for q in angles)))
        for tip in problem.tips:
            path = np.array([tip.pose(q)[1] for q in angles])
            goal = tip.pose(q_goal)[1]
            figures = judge_move(path, path[0], goal, PERIOD_S)
            across.append(figures.perpendicular * 100.0)
            beside.append(figures.deviation * 100.0)
            ends.append(float(np.linalg.norm(path[-1] - goal)) * 1e3)
    what = f"both hands, {count} moves"
    crossed = float(np.degrees(max(outside))) if max(outside) > 1e-9 else 0.0
    return [
        at_most(f"{what}: off the straight line, largest", max(across), "%", 3.0),
        at_most(f"{what}: off the straight line, median", float(np.median(across)), "%", 1.0),
        at_most(f"{what}: off the minimum-jerk motion, largest", max(beside), "%", 3.0),
        at_most(f"{what}: off the minimum-jerk motion, median", float(np.median(beside)), "%", 1.0),
        Row(f"{what}: end off the goal, largest", max(ends), "mm"),
        at_most(f"{what}: limits and rows crossed by", crossed, "deg", 0.0),
        at_most(
            f"{what}: tick without inverse kinematics, median",
            float(np.percentile(spent, 50)),
            "us",
            200.0,
        ),
        Row(f"{what}: tick without inverse kinematics, p99", float(np.percentile(spent, 99)), "us"),
    ]


def _ends(
    problem: IkProblem, ik: InverseKinematics, draw: np.random.Generator
) -> tuple[Vector, Vector]:
    """Two postures by inverse kinematics whose hands are 8 to 41 cm apart."""
    limits = problem.limits
    while True:
        q = draw.uniform(limits.lower_rad, limits.upper_rad)
        other = q + draw.uniform(-SPREAD_RAD, SPREAD_RAD, problem.n)
        if max(limits.violation(q), limits.violation(other)) >= 0.0:
            continue
        found = []
        start = problem.rest_rad
        for wanted in (q, other):
            poses = [tip.pose(wanted) for tip in problem.tips]
            answer = ik.solve([TipTarget.checked(p, R) for R, p in poses], start)
            if answer.status is IkStatus.CONVERGED and answer.orientation_error_rad < 1e-3:
                found.append(answer.q_rad)
                start = answer.q_rad
        if len(found) < 2:
            continue
        ways = [
            np.linalg.norm(tip.pose(found[1])[1] - tip.pose(found[0])[1]) for tip in problem.tips
        ]
        if all(SHORTEST_M <= way <= LONGEST_M for way in ways):
            return found[0], found[1]


def _run(problem: IkProblem, q_start: Vector, q_goal: Vector) -> tuple[Matrix, list[float]]:
    """Angles of the plan (k, 17), and the processor time of each tick [us]."""
    controller = CartesianController(problem.tips, problem.limits, params_of(Law.TIME_TO_GO))
    poses = [tip.pose(q_goal) for tip in problem.tips]
    target = ReachTarget(
        tips=[PoseTarget(position_m=p, rotation=R) for R, p in poses], q_rad=q_goal
    )
    state, angles, spent = controller.start(q_start), [q_start], []
    for _ in range(round(1.4 * TIME_S / PERIOD_S)):
        measured = Measurement(q_rad=state.q_plan, compliant=(False,) * problem.n)
        begin = thread_cpu_ns()
        state, _ = controller.step(state, measured, target)
        spent.append((thread_cpu_ns() - begin) / 1e3)
        angles.append(state.q_plan)
    return np.array(angles), spent
