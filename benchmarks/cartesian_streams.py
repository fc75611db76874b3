"""Targets that move, the reference law's own figures, and what a tick costs."""

import math

import numpy as np

from benchmarks.cartesian_moves import PERIOD_S, Move, params_of
from dforc.arrays import Vector
from dforc.cartesian.controller import CartesianController
from dforc.cartesian.params import CartesianParams, CouplingParams, Law
from dforc.cartesian.state import Measurement
from dforc.cartesian.targets import PoseTarget, ReachTarget
from dforc.ik.inverse_kinematics import InverseKinematics
from dforc.ik.problem import TipTarget
from dforc.rotation import matrix
from services.core.clock import thread_cpu_ns
from services.experiments.cartesian.arm import Arm
from services.experiments.rows import Row, at_most, within
from services.reaching.limb import limb_problem

LAG = 0.564  # T v: what the reference law trails a moving target by
FOLLOWING_TIME_S = 0.6  # T of DForC
SPEEDS_MM_S = (23.0, 68.0, 250.0, 500.0)
GAIN_M = 0.06
LOOPS_S = 6.0
LAW_RAD = 0.1  # the way of one joint, and rad/s
TICKS = 3000
TIMES = 3  # the best of so many


def lemniscate(phase: float) -> tuple[Vector, Vector]:
    """Point of a figure of eight in the y-z plane, and its derivative by the phase."""
    s, c = math.sin(phase), math.cos(phase)
    point = GAIN_M * np.array([0.0, s, s * c])
    return point, GAIN_M * np.array([0.0, c, c * c - s * s])


def stream_rows(arm: Arm) -> list[Row]:
    """K5: a figure of eight at four speeds, by both laws."""
    rows = []
    for speed_mm_s in SPEEDS_MM_S:
        for law in Law:
            lag_mm, mean_m_s = _lag_mm(arm, law, speed_mm_s)
            formula_mm = LAG * FOLLOWING_TIME_S * mean_m_s * 1e3
            name = f"{law}, figure of eight at {speed_mm_s:g} mm/s: lag over 0.564 T v"
            share = lag_mm / formula_mm * 100.0
            own = law is Law.TIME_TO_GO
            rows.append(at_most(name, share, "%", 5.0) if own else Row(name, share, "%"))
            rows.append(Row(f"{law}, figure of eight at {speed_mm_s:g} mm/s: lag", lag_mm, "mm"))
    return rows


def _lag_mm(arm: Arm, law: Law, speed_mm_s: float) -> tuple[float, float]:
    """Root mean square of the distance to the target, and the target's mean speed."""
    params = CartesianParams(
        law=law,
        trajectory_time_s=FOLLOWING_TIME_S,
        coupling=CouplingParams(speed_limit_rad_s=6.0),
    )
    controller = CartesianController([arm.tip], arm.limits, params)
    ik = InverseKinematics(limb_problem(arm.robot, arm.limb.name))
    home = arm.pose(arm.home_rad)
    state, q = controller.start(arm.home_rad), arm.home_rad
    stiff, phase, lags, speeds = (False,) * len(q), 0.0, [], []
    periods = round(LOOPS_S / PERIOD_S)
    for period in range(periods):
        point, slope = lemniscate(phase)
        rate = speed_mm_s * 1e-3 / float(np.linalg.norm(slope))
        position = home.position_m + point
        q = ik.track([TipTarget.checked(position, home.rotation)], q).q_rad
        pose = PoseTarget(position_m=position, rotation=home.rotation, velocity_m_s=rate * slope)
        measured = Measurement(q_rad=state.q_plan, compliant=stiff)
        state, output = controller.step(state, measured, ReachTarget(tips=[pose], q_rad=q))
        if period > periods // 4:
            lags.append(float(np.linalg.norm(output.tips[0].plan_position_m - position)))
            speeds.append(speed_mm_s * 1e-3)
        phase += rate * PERIOD_S
    return float(np.sqrt(np.mean(np.square(lags)))) * 1e3, float(np.mean(speeds))


def law_rows(arm: Arm) -> list[Row]:
    """The reference law by itself: a joint's step and ramp, T 1 s."""
    controller = CartesianController([arm.tip], arm.limits, params_of(Law.REFERENCE))
    joint = int(np.argmax(np.minimum(*_rooms(arm))))
    step, ramp = np.zeros((2, 400))
    for way in (step, ramp):
        state = controller.start(arm.home_rad)
        for period in range(len(way)):
            wanted = arm.home_rad.copy()
            wanted[joint] += LAW_RAD * (1.0 if way is step else period * PERIOD_S)
            measured = Measurement(q_rad=state.q_plan, compliant=(False,) * len(wanted))
            target = ReachTarget(tips=[None], q_rad=wanted)
            gone = float(state.q_plan[joint] - arm.home_rad[joint]) / LAW_RAD
            way[period] = gone if way is step else period * PERIOD_S - gone
            state, _ = controller.step(state, measured, target)
    times = np.arange(len(step)) * PERIOD_S
    t98, at_end = float(np.interp(0.98, step, times)), float(np.interp(1.0, times, step))
    return [
        within("reference, one joint: way at T", at_end, "", 0.89, 0.91),
        within("reference, one joint: 98 % at, over T", t98, "", 1.398, 1.426),
        within("reference, one joint on a ramp: lag over T v", float(ramp[-1]), "", 0.558, 0.57),
        at_most("reference, one joint: overshoot", (float(step.max()) - 1.0) * 100.0, "%", 0.1),
    ]


def _rooms(arm: Arm) -> tuple[Vector, Vector]:
    """How far each joint may go from home, up and down."""
    return arm.limits.upper_rad - arm.home_rad, arm.home_rad - arm.limits.lower_rad


def tick_rows(arm: Arm, moves: list[Move]) -> list[Row]:
    """K7: the controller alone and with inverse kinematics, and an empty loop beside each."""
    rows = []
    for law, bar_us in ((Law.TIME_TO_GO, 100.0), (Law.REFERENCE, 200.0)):
        spent, empty = _tick_us(arm, moves, law, solving=False)
        name = f"{law}, tick without inverse kinematics"
        rows += [
            at_most(f"{name}, median", float(np.percentile(spent, 50)), "us", bar_us),
            Row(f"{name}, p99", float(np.percentile(spent, 99)), "us"),
            *_empty_rows(name, empty),
        ]
    spent, empty = _tick_us(arm, moves, Law.TIME_TO_GO, solving=True)
    name = "time_to_go, full tick (inverse kinematics, references, program)"
    return [
        *rows,
        at_most(f"{name}, median", float(np.percentile(spent, 50)) / 1e3, "ms", 0.3),
        at_most(f"{name}, p99", float(np.percentile(spent, 99)) / 1e3, "ms", 1.0),
        *_empty_rows(name, empty),
    ]


def _empty_rows(name: str, empty_us: Vector) -> list[Row]:
    p50, p99 = np.percentile(empty_us, [50, 99]).tolist()
    return [
        Row(f"{name}, empty loop beside it, median", p50, "us"),
        Row(f"{name}, empty loop beside it, p99", p99, "us"),
    ]


def _tick_us(arm: Arm, moves: list[Move], law: Law, *, solving: bool) -> tuple[Vector, Vector]:
    """Processor time of each tick, the best of three equal runs; and of an empty one beside it."""
    runs = [_run_us(arm, moves, law, solving=solving) for _ in range(TIMES)]
    best = np.min(np.array(runs), axis=0)
    return best[:, 0], best[:, 1]


def _run_us(arm: Arm, moves: list[Move], law: Law, *, solving: bool) -> list[tuple[float, float]]:
    ik = InverseKinematics(limb_problem(arm.robot, arm.limb.name))
    controller = CartesianController([arm.tip], arm.limits, params_of(law))
    stiff, spent = (False,) * len(arm.joints), []
    for move in moves:
        state, q = controller.start(move.q_start), move.q_start
        for period in range(TICKS // len(moves)):
            turn = matrix([0.0, 0.0, 1e-4 * period])
            goal = TipTarget.checked(move.goal.position_m, turn @ move.goal.rotation)
            begin = thread_cpu_ns()
            if solving:
                q = ik.track([goal], q).q_rad
            pose = PoseTarget(position_m=move.goal.position_m, rotation=turn @ move.goal.rotation)
            measured = Measurement(q_rad=state.q_plan, compliant=stiff)
            target = ReachTarget(tips=[pose], q_rad=q if solving else move.q_goal)
            state, _ = controller.step(state, measured, target)
            end = thread_cpu_ns()
            spent.append(((end - begin) / 1e3, (thread_cpu_ns() - end) / 1e3))
    return spent
