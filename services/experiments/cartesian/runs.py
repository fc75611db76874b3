"""Runs of the Cartesian experiment without boards: a plan once, and what each arm makes of it."""

import numpy as np

from services.experiments.cartesian.arm import Arm
from services.experiments.cartesian.controllers import Contender
from services.experiments.cartesian.course import PERIOD_S, Course
from services.experiments.cartesian.figures import Run
from services.experiments.cartesian.plants import ideal, lagged

IDEAL, LAGGED = "ideal", "lagged"


def offline_runs(
    arm: Arm, course: Course, contender: Contender, plants: tuple[str, ...], repetitions: int
) -> list[Run]:
    """One run on the ideal arm, `repetitions` on lagging ones.

    The arm is stiff: no controller looks at it, and one plan serves every arm.
    """
    moving = contender.begin(arm, course)
    q = course.q_start_rad
    planned = [q]
    for period in range(course.periods):
        q, _ = moving.step(period, q)
        planned.append(q)
    plan = np.array(planned)

    def run(plant: str, seed: int) -> Run:
        angles = ideal(plan) if plant == IDEAL else lagged(plan, PERIOD_S, seed)
        return Run(
            controller=contender.name,
            plant=plant,
            seed=seed,
            arm=arm,
            course=course,
            references_rad=plan[1:],
            angles_rad=angles,
        )

    seeds = {IDEAL: 1, LAGGED: repetitions}
    return [run(plant, seed) for plant in seeds if plant in plants for seed in range(seeds[plant])]
