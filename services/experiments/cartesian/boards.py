"""Random reaches of both hands through boards and CAN, stiff: on time, and how near.

A reach is on time when the minimum-jerk motion that fits the plant's hand best, among those that
begin with the command, lasts T to 5 %: the lag of bus, boards and drives counts. When the hand
passes 98 % of its way is shown beside it (0.865 T on the plan); so close to the end a joint that
is a degree off moves this instant by a tenth of T. The integrators of the boards' position loops
take such a degree away slowly, against the dry friction of the wrist in up to four seconds: then
the errors are judged, and it is shown how large they were when T was over. Since when the hand has
been near for good is a row with the bar that a robot without friction would hold.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from dforc.arrays import Vector
from dforc.rotation import angle_between
from services.config import load_robot
from services.core.errors import ServiceError
from services.emulated.simulation import Progress
from services.experiments.cartesian.arm import Arm, Reached
from services.experiments.cartesian.can import Job, run_on_boards
from services.experiments.cartesian.controllers import CONTENDERS
from services.experiments.cartesian.course import PERIOD_S, Course, to_goals
from services.experiments.cartesian.figures import Run, judged
from services.experiments.cartesian.metrics import MoveFigures, judge_move
from services.experiments.rows import Row, at_least, at_most, within
from services.robotfile.robot_tables import RobotFile

BOTH_ARMS = "icub:arms"
LIMBS = ("right_arm", "left_arm")
REACHES, SHORT_REACHES = 20, 4
TIME_S = 1.5  # T of every reach
SETTLE_S = 4.0  # in which the integrators of the boards' position loops come to an end
NEAR_M, NEAR_RAD = 0.002, math.radians(1.0)
LATE = 0.05  # share of T
COMFORT = 0.6  # of each joint's range, in its middle
TORSO_RAD = math.radians(8.0)
ROW_ROOM_RAD = math.radians(5.0)
SHORTEST_M, LONGEST_M = 0.12, 0.41
MOST_TURN_RAD = math.radians(120.0)
SPEED_SHARE = 0.9  # of what the HAL lets a joint have
PEAK_SPEED = 1.875  # of a minimum-jerk motion, over its mean
MOST_DRAWS = 20000


@dataclass(frozen=True, slots=True, kw_only=True)
class Reach:
    """One reach of one hand, judged by the plant's truth."""

    limb: str
    figures: MoveFigures
    on_time_m: float  # errors when T is over
    on_time_rad: float
    error_m: float  # and SETTLE_S later
    error_rad: float
    near_s: float  # from then on within NEAR_M and NEAR_RAD, since the command; inf when never


def board_rows(
    short: bool = False,
    seed: int = 0,
    progress: Progress | None = None,
) -> list[Row]:
    """Run the reaches and give every figure, with its bar."""
    robot = load_robot(BOTH_ARMS)
    runs = reach_runs(robot, SHORT_REACHES if short else REACHES, seed, progress)
    return [row for run in runs for row in rows_of(run)]


def reach_runs(
    robot: RobotFile, count: int, seed: int, progress: Progress | None = None
) -> list[Run]:
    """One run for each arm, of `count` reaches."""
    own = next(contender for contender in CONTENDERS if contender.name == "ulna")
    arms = [Arm(robot, limb, torso=True) for limb in LIMBS]
    jobs = [
        Job(arm=arm, course=random_course(arm, count, seed + number), contender=own)
        for number, arm in enumerate(arms)
    ]
    return run_on_boards(robot, jobs, seed, progress)


def random_course(arm: Arm, count: int, seed: int) -> Course:
    """From home through `count` random poses that the hand reaches with room to spare."""
    draw = np.random.default_rng(seed)
    q, goals = arm.home_rad, [arm.reached(arm.pose(arm.home_rad), arm.home_rad)]
    for _ in range(MOST_DRAWS):
        if len(goals) > count:
            return to_goals("random reaches", goals, TIME_S, TIME_S + SETTLE_S)
        wanted = _comfortable(arm, draw)
        if wanted is None:
            continue
        found = arm.reached(arm.pose(wanted), q)
        if _is_fair(arm, goals[-1], found):
            goals.append(found)
            q = found.q_rad
    raise ServiceError(f"{arm.limb.name}: no {count} random reaches in {MOST_DRAWS} draws")


def _comfortable(arm: Arm, draw: np.random.Generator) -> Vector | None:
    """A posture away from limits and rows, the hand in front of the body; None: none this time."""
    limits = arm.limits
    middle = 0.5 * (limits.lower_rad + limits.upper_rad)
    half = 0.5 * COMFORT * (limits.upper_rad - limits.lower_rad)
    torso = np.array([joint in arm.robot.parts["torso"] for joint in arm.joints])
    middle, half = np.where(torso, 0.0, middle), np.where(torso, TORSO_RAD, half)
    q: Vector = draw.uniform(middle - half, middle + half)
    if limits.violation(q) > -ROW_ROOM_RAD:
        return None
    forward_m = -float(arm.pose(q).position_m[0])
    return q if forward_m > 0.15 else None


def _is_fair(arm: Arm, before: Reached, after: Reached) -> bool:
    way_m = float(np.linalg.norm(after.pose.position_m - before.pose.position_m))
    turn = angle_between(before.pose.rotation, after.pose.rotation)
    speeds = PEAK_SPEED * np.abs(after.q_rad - before.q_rad) / TIME_S
    return (
        SHORTEST_M < way_m < LONGEST_M
        and turn < MOST_TURN_RAD
        and bool((speeds < SPEED_SHARE * np.array(arm.speed_limits_rad_s)).all())
        and after.off_rad < math.radians(0.05)
    )


def reaches_of(run: Run) -> list[Reach]:
    """Every reach of a run."""
    positions, rotations = run.hand
    ends = [*run.course.moves[1:], run.course.periods]
    on_time = round(run.course.trajectory_time_s / PERIOD_S)
    found = []
    start = positions[0]
    for begin, end in zip(run.course.moves, ends, strict=True):
        goal, wanted = run.course.position_m[begin], run.course.rotation[begin]
        hand = positions[begin : end + 1]
        off_m = np.linalg.norm(hand - goal, axis=1)
        off_rad = np.array([angle_between(R, wanted) for R in rotations[begin : end + 1]])
        found.append(
            Reach(
                limb=run.arm.limb.name,
                figures=judge_move(hand, start, goal, PERIOD_S),
                on_time_m=float(off_m[on_time]),
                on_time_rad=float(off_rad[on_time]),
                error_m=float(off_m[-1]),
                error_rad=float(off_rad[-1]),
                near_s=_near_s(off_m, off_rad),
            )
        )
        start = positions[end]
    return found


def _near_s(off_m: Vector, off_rad: Vector) -> float:
    outside = np.flatnonzero((off_m > NEAR_M) | (off_rad > NEAR_RAD))
    if not len(outside):
        return 0.0
    last = int(outside[-1])
    return math.inf if last == len(off_m) - 1 else (last + 1) * PERIOD_S


def rows_of(run: Run) -> list[Row]:
    """Figures of the reaches of one arm, the worst of each."""
    reaches, T = reaches_of(run), TIME_S  # noqa: N806
    limits = judged(run)
    what = f"{run.arm.limb.name.replace('_', ' ')} through boards"

    def values(of: Callable[[Reach], float]) -> list[float]:
        return [of(reach) for reach in reaches]

    lasting = values(lambda reach: reach.figures.since_jump_s / T)
    t98 = values(lambda reach: reach.figures.t98_s / T)
    onset_ms = values(lambda reach: reach.figures.onset_s * 1e3)
    near = values(lambda reach: reach.near_s / T)
    on_time_mm = values(lambda reach: reach.on_time_m * 1e3)
    on_time_deg = values(lambda reach: math.degrees(reach.on_time_rad))
    error_mm = values(lambda reach: reach.error_m * 1e3)
    error_deg = values(lambda reach: math.degrees(reach.error_rad))
    off_line = values(lambda reach: reach.figures.perpendicular * 100.0)
    return [
        at_least(f"{what}: random reaches", len(reaches), "", len(run.course.moves)),
        within(f"{what}: duration over T, shortest", min(lasting), "", 1.0 - LATE, 1.0 + LATE),
        within(f"{what}: duration over T, longest", max(lasting), "", 1.0 - LATE, 1.0 + LATE),
        Row(f"{what}: 98 % of the way, over T, earliest", min(t98)),
        Row(f"{what}: 98 % of the way, over T, latest", max(t98)),
        Row(f"{what}: begins after the command, median", float(np.median(onset_ms)), "ms"),
        Row(f"{what}: position error at T, largest", max(on_time_mm), "mm"),
        Row(f"{what}: orientation error at T, largest", max(on_time_deg), "deg"),
        Row(f"{what}: within 2 mm and 1 deg for good, over T, median", float(np.median(near))),
        at_most(f"{what}: within 2 mm and 1 deg for good, over T, last", max(near), "", 1.0 + LATE),
        Row(f"{what}: position error, median", float(np.median(error_mm)), "mm"),
        at_most(f"{what}: position error, largest", max(error_mm), "mm", NEAR_M * 1e3),
        Row(f"{what}: orientation error, median", float(np.median(error_deg)), "deg"),
        at_most(f"{what}: orientation error, largest", max(error_deg), "deg", 1.0),
        Row(f"{what}: off the straight line, median", float(np.median(off_line)), "%"),
        Row(f"{what}: off the straight line, largest", max(off_line), "%"),
        at_most(f"{what}: joint range exceeded by", limits["range_deg"], "deg", 0.0),
        at_most(f"{what}: row crossed by", limits["row_deg"], "deg", 0.0),
    ]
