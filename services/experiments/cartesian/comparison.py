"""The Cartesian controllers against each other: section 4.1 of the Cartesian control paper, again.

A pair of poses taken in turn and a lemniscate, position and orientation controlled, with the torso
blocked (7 DoF) and with it (10 DoF); on an ideal arm, on one that lags, and on the emulated robot
through its boards and CAN frames; and random reaches of both hands there.
"""

from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path

from rich.console import Console

from services.config import load_robot
from services.core.errors import ConfigError
from services.experiments.cartesian.arm import Arm
from services.experiments.cartesian.boards import board_rows
from services.experiments.cartesian.can import BOARDS, Job, run_on_boards
from services.experiments.cartesian.controllers import CONTENDERS, Contender
from services.experiments.cartesian.course import Course, lemniscate, point_to_point
from services.experiments.cartesian.figures import Run, judged, summed_up
from services.experiments.cartesian.plot import draw
from services.experiments.cartesian.rows import OWN, Cell, all_rows, print_tables
from services.experiments.cartesian.runs import IDEAL, LAGGED, offline_runs
from services.experiments.reporting import tell_motion, working
from services.experiments.rows import Row, publish, write
from services.reaching.limb import find_limb
from services.robotfile.robot_tables import RobotFile

LIMB = "right_arm"  # whose poses the public material holds
PLANTS = (IDEAL, LAGGED, BOARDS)
NAMES = tuple(contender.name for contender in CONTENDERS)
RUNS = 3
MOVES, SHORT_MOVES = 4, 2
SHORT_DWELL_S, SHORT_LOOP_S = 5.0, 12.0
LAGGING_ARMS = 5

Tell = Callable[[str], None]


def cartesian(
    *,
    robot: str = "icub:reach",
    seed: int = 0,
    runs: int = RUNS,
    plants: Sequence[str] = (),
    controllers: Sequence[str] = (),
    short: bool = False,
    json: Path | None = None,
    plot: Path = Path("cartesian.png"),
) -> int:
    """Run everything, print the tables, draw the figure, and return 0 when every bar holds.

    Raises:
        ConfigError: unknown plants or controllers, or a robot without a right arm.
        ServiceError: the emulated robot did not carry a course through.
    """
    plants = _known("--plant", plants, PLANTS)
    names = _known("--controller", controllers, NAMES)
    contenders = [contender for contender in CONTENDERS if contender.name in names]
    robot_file = load_robot(robot)
    find_limb(robot_file, LIMB)  # before anything takes time
    console = Console()
    with working(console, "Cartesian controllers on the right hand") as tell:
        work = _work(robot_file, short=short)
        found = _offline(work, contenders, plants, tell)
        if BOARDS in plants:
            for plant_seed in range(seed, seed + (1 if short else runs)):
                found += _on_boards(robot_file, work, contenders, plant_seed, tell)
        reaches: list[Row] = []
        if BOARDS in plants and OWN in names:
            reaches = board_rows(short=short, seed=seed, progress=partial(tell_motion, tell, seed))
        tell("judging the runs")
        cells = _cells(found)
    for contender in contenders:
        console.print(f"{contender.name}: {contender.what}", highlight=False, soft_wrap=True)
    print_tables(console, cells)
    draw(found, plot)
    rows = [*all_rows(cells), *reaches]
    if json is not None:
        write(rows, json)
    shown = [row for row in rows if row.holds is not None or row in reaches]
    status = publish("what this project's controller is held to", shown, None)
    console.print(f"plot: {plot}")
    return status


def _known(option: str, asked: Sequence[str], known: Sequence[str]) -> tuple[str, ...]:
    """What was asked for, or everything."""
    for name in asked:
        if name not in known:
            raise ConfigError(f"{option} {name}: there are: {', '.join(known)}")
    return tuple(asked) or tuple(known)


def _work(robot: RobotFile, *, short: bool) -> list[tuple[Arm, Course]]:
    """Every course with every number of joints."""
    work = []
    for torso in (True,) if short else (True, False):
        arm = Arm(robot, LIMB, torso=torso)
        if short:
            courses = [point_to_point(arm, SHORT_MOVES, SHORT_DWELL_S)]
            courses.append(lemniscate(arm, loop_s=SHORT_LOOP_S))
        else:
            courses = [point_to_point(arm, MOVES), lemniscate(arm)]
        work += [(arm, course) for course in courses]
    return work


def _offline(
    work: Sequence[tuple[Arm, Course]],
    contenders: Sequence[Contender],
    plants: Sequence[str],
    tell: Tell,
) -> list[Run]:
    found = []
    for arm, course in work:
        for contender in contenders:
            if IDEAL in plants or LAGGED in plants:
                joints = arm.degrees_of_freedom
                tell(f"{contender.name}: {course.name}, {joints} DoF, without boards")
                found += offline_runs(arm, course, contender, tuple(plants), LAGGING_ARMS)
    return found


def _on_boards(
    robot: RobotFile,
    work: Sequence[tuple[Arm, Course]],
    contenders: Sequence[Contender],
    seed: int,
    tell: Tell,
) -> list[Run]:
    jobs = [
        Job(arm=arm, course=course, contender=contender)
        for arm, course in work
        for contender in contenders
    ]
    return run_on_boards(robot, jobs, seed, partial(tell_motion, tell, seed))


def _cells(runs: Sequence[Run]) -> list[Cell]:
    """Repetitions summed up, in the order of plants and controllers."""
    groups: dict[tuple[str, int, str, str], list[Run]] = {}
    for run in runs:
        kind = (run.course.name, run.arm.degrees_of_freedom, run.plant, run.controller)
        groups.setdefault(kind, []).append(run)

    def place(kind: tuple[str, int, str, str]) -> tuple[bool, int, int, int]:
        course, joints, plant, controller = kind
        is_curve = course == "lemniscate"
        return is_curve, -joints, PLANTS.index(plant), NAMES.index(controller)

    return [
        Cell(
            course=groups[kind][0].course,
            degrees_of_freedom=kind[1],
            plant=kind[2],
            controller=kind[3],
            figures=summed_up([judged(run) for run in groups[kind]]),
        )
        for kind in sorted(groups, key=place)
    ]
