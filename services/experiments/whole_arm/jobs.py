"""Whole-arm scenes by name, in portions that several processes can share.

A kind is a number of random spheres ("5"), a hard family ("wall"), or a scene in which something
changes ("passing", "other arm", "enclosed", "both arms", "switch").
"""

import multiprocessing
import os
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from dataclasses import dataclass
from functools import lru_cache

from services.experiments.whole_arm.courses import (
    both_arms_scene,
    enclosed_scene,
    other_arm_scene,
    passing_scene,
    switch_scene,
)
from services.experiments.whole_arm.draw import FAMILIES, ArmScene, family_scene, random_scene
from services.experiments.whole_arm.lineup import make_law
from services.experiments.whole_arm.run import Course, Outcome, Trace, run
from services.experiments.whole_arm.setting import ArmSetting, arm_setting

PORTION = 5  # scenes
WARM_S, WARM_KIND, WARM_NUMBER = 3.0, "wall", 1_000_000  # a scene that needs everything
REACH, ARMS = "icub:reach", "icub:arms"

CHANGING: dict[str, Callable[[ArmSetting, int, int], tuple[ArmScene, Course | None]]] = {
    "passing": passing_scene,
    "other arm": other_arm_scene,
    "enclosed": enclosed_scene,
    "both arms": lambda setting, number, seed: (both_arms_scene(setting, number, seed), None),
    "switch": switch_scene,
}
LIMBS = {"other arm": (ARMS, "right_arm"), "both arms": (ARMS, "both_arms")}
LONGEST_S = {"enclosed": 28.0}
USUAL_S = 20.0


@dataclass(frozen=True)
class Job:
    """Some scenes of one kind, by some laws."""

    kind: str
    laws: tuple[str, ...]
    numbers: tuple[int, ...]
    seed: int


def setting_for(kind: str) -> ArmSetting:
    """The limb that a kind of scene is for."""
    return _setting(*LIMBS.get(kind, (REACH, "right_arm")))


def scene_of(kind: str, number: int, seed: int) -> tuple[ArmScene, Course | None]:
    """A scene, and what changes in it."""
    setting = setting_for(kind)
    if kind in CHANGING:
        return CHANGING[kind](setting, number, seed)
    if kind in FAMILIES:
        return family_scene(setting, kind, number, seed), None
    return random_scene(setting, int(kind), number, seed), None


def replay(kind: str, number: int, seed: int, law: str = "ulna") -> tuple[Outcome, Trace]:
    """One scene again, with every posture."""
    setting = setting_for(kind)
    scene, course = scene_of(kind, number, seed)
    return run(setting, make_law(law, setting), scene, LONGEST_S.get(kind, USUAL_S), course)


def do(job: Job) -> list[Outcome]:
    """All laws on all scenes of a portion."""
    _warm(job)
    return [
        replay(job.kind, number, job.seed, law)[0] for number in job.numbers for law in job.laws
    ]


def jobs_of(
    kinds: Sequence[str], laws: Sequence[str], numbers: Sequence[int], seed: int
) -> list[Job]:
    """Portions of the work, the kinds in turn."""
    return [
        Job(kind, tuple(laws), tuple(numbers[first : first + PORTION]), seed)
        for first in range(0, len(numbers), PORTION)
        for kind in kinds
    ]


def share(jobs: Sequence[Job], processes: int = 0) -> Iterator[tuple[Job, list[Outcome]]]:
    """Do the work, by as many processes as there are cores (or as many as said); as it is done."""
    workers = min(processes or len(os.sched_getaffinity(0)), len(jobs))
    if workers <= 1:
        for job in jobs:
            yield job, do(job)
        return
    context = multiprocessing.get_context("spawn")  # compiled code and threads do not fork
    with ProcessPoolExecutor(workers, mp_context=context) as pool:
        waiting = {pool.submit(do, job): job for job in jobs}
        for done in as_completed(waiting):
            yield waiting[done], done.result()


@lru_cache
def _setting(robot: str, limb: str) -> ArmSetting:
    return arm_setting(robot, limb)


_warmed: set[tuple[str, str, str]] = set()


def _warm(job: Job) -> None:
    """Compile what the laws need: the first tick is nobody's time."""
    limb = LIMBS.get(job.kind, (REACH, "right_arm"))
    kind = job.kind if job.kind in LIMBS else WARM_KIND
    for law in job.laws:
        if (law, *limb) not in _warmed:
            _warmed.add((law, *limb))
            setting = setting_for(kind)
            scene, course = scene_of(kind, WARM_NUMBER, job.seed)
            run(setting, make_law(law, setting), scene, WARM_S, course)
