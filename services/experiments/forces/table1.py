"""Table 1: how well the model predicts what the force/torque sensors read in free motion.

On the emulated robot, whose masses and levers are not the model's, through the boards' CAN frames;
and for the right arm of a real robot, from the recording icubdyn: by CAD, and with identified
inertial parameters. The paper's own values stand beside. A model of another generation of the robot
must be found out by its error.
"""

from dataclasses import dataclass
from functools import partial
from pathlib import Path

import numpy as np
from rich.console import Console
from rich.table import Table

from services.config import load_robot
from services.core.errors import ConfigError
from services.experiments.forces import icubdyn
from services.experiments.forces.arm_learning import load_task
from services.experiments.forces.free_recording import record
from services.experiments.forces.paper_table1 import PAPER
from services.experiments.forces.recorded_arm import RIGHT, absent, bars, is_at_hand
from services.experiments.forces.wrench_errors import (
    COMPONENTS,
    UNITS,
    WHOLE_ROBOT,
    Comparison,
    limbs,
    of_recording,
    of_samples,
)
from services.experiments.reporting import Tell, tell_motion, working
from services.experiments.rows import Row, at_most, publish, write
from services.robotfile.robot_tables import RobotFile

SECONDS, SHORT_SECONDS = 30.0, 6.0


@dataclass(frozen=True, slots=True, eq=False)
class Errors:
    """Of one limb, on one source of data."""

    limb: str
    source: str  # emulated | recorded
    compared: Comparison


def force_table1(
    *,
    robot: str = WHOLE_ROBOT,
    data: Path | None = None,
    seed: int = 0,
    runs: int = 1,
    short: bool = False,
    json: Path | None = None,
) -> int:
    """Run both halves, print the table, and return 0 when every bar holds.

    Raises:
        ConfigError: the robot has no force/torque sensor, or `data` is not the recording.
        ServiceError: the emulated robot did not carry the motion through.
    """
    recording = icubdyn.load(data) if is_at_hand(data) else None
    robot_file = load_robot(robot)
    if not limbs(robot_file):
        raise ConfigError(f"--robot {robot}: no force/torque sensor among its parts")
    console = Console()
    with working(console, "contact-free motion of the emulated robot") as tell:
        seeds = range(seed, seed + (1 if short else runs))
        seconds = SHORT_SECONDS if short else SECONDS
        errors = emulated(robot_file, seeds, seconds, tell)
        rows = [row for each in errors for row in _rows(each)]
        rows += [row for each in errors for row in _beside_paper(each)]
        if recording is not None:
            tell("predicting the recording")
            real = Errors("right_arm", "recorded", of_recording(recording, RIGHT))
            errors.append(real)
            rows += [*_rows(real), *bars(real.compared, recording, load_task(data))]
    console.print(table(errors))
    for line in interpretation(errors):
        console.print(line, soft_wrap=True)
    if recording is None:
        rows.append(absent())
        console.print(f"Recorded: {absent().value}", soft_wrap=True)
    if json is not None:
        write(rows, json)
    return publish("against the bars", [row for row in rows if row.holds is not None], None)


def emulated(robot: RobotFile, seeds: range, seconds: float, tell: Tell) -> list[Errors]:
    """By limb; the runs of all seeds, each with a plant of its own, follow one another."""
    sensors = limbs(robot)
    runs = []
    for seed in seeds:
        samples = record(robot, seed, seconds, partial(tell_motion, tell, seed))
        runs.append({limb: of_samples(samples, sensor) for limb, sensor in sensors.items()})
    return [
        Errors(
            limb,
            "emulated",
            Comparison(
                measured=np.vstack([run[limb].measured for run in runs]),
                predicted=np.vstack([run[limb].predicted for run in runs]),
                touched=sum(run[limb].touched for run in runs),
            ),
        )
        for limb in sensors
    ]


def table(errors: list[Errors]) -> Table:
    """The paper's table, with its own values below those of each limb."""
    shown = Table(
        "limb",
        "source",
        "",
        *COMPONENTS,
        title="measured minus predicted force [N] and moment [Nm], contact-free motion",
        title_justify="left",
    )
    for limb in dict.fromkeys(each.limb for each in errors):
        name = limb.replace("_", " ")
        for each in errors:
            if each.limb == limb:
                shown.add_row(name, each.source, "mean", *_cells(each.compared.mean))
                shown.add_row("", "", "std", *_cells(each.compared.std))
                name = ""
        shown.add_row("", "paper", "mean", *_cells(PAPER[limb].mean), style="dim")
        shown.add_row("", "", "std", *_cells(PAPER[limb].std), style="dim", end_section=True)
    return shown


def interpretation(errors: list[Errors]) -> list[str]:
    """What the numbers mean against the paper's, one sentence per source of data."""
    lines = []
    of_plant = [each for each in errors if each.source == "emulated"]
    if of_plant:
        ratios = np.array([each.compared.std / PAPER[each.limb].std for each in of_plant])
        lines.append(
            f"Emulated: the spread is {ratios.min():.2f} to {ratios.max():.2f} times the paper's. "
            "The plant differs from the model in masses (5 %), levers (5 mm) and by the noise, "
            "offset and quantisation of the sensors; a real robot also has cables, friction of "
            "covers, imperfect gains of the sensors and a CAD model that errs by more."
        )
    for each in errors:
        if each.source == "recorded":
            ratio = ", ".join(f"{one:.1f}" for one in each.compared.std / PAPER[each.limb].std)
            lines.append(
                f"Recorded: CAD and one constant offset, nothing fitted, on another robot than the "
                f"paper's: the spread is {ratio} times the paper's right arm (fx to mz): the size "
                "of Table 1's errors is what CAD gives on such an arm."
            )
    return lines


def _rows(errors: Errors) -> list[Row]:
    """Everything in the table, and what the errors compare with."""
    compared, paper = errors.compared, PAPER[errors.limb]
    source = f"{errors.limb}, {errors.source}"
    rows = [
        Row(f"{source}: nMSE", compared.nmse),
        Row(f"{source}: rows", len(compared.measured)),
    ]
    for i, (component, unit) in enumerate(zip(COMPONENTS, UNITS, strict=True)):
        name = f"{source}: {component}"
        measured = float(compared.measured[:, i].std())
        rows += [
            Row(f"{name}, mean", float(compared.mean[i]), unit),
            Row(f"{name}, std", float(compared.std[i]), unit),
            Row(f"{name}, std of what was measured", measured, unit),
            Row(f"{name}, mean in the paper", paper.mean[i], unit),
            Row(f"{name}, std in the paper", paper.std[i], unit),
        ]
    return rows


def _beside_paper(errors: Errors) -> list[Row]:
    compared, name = errors.compared, f"{errors.limb}, emulated"
    ratio = float((compared.std / PAPER[errors.limb].std).max())
    return [
        at_most(f"{name}: largest std, of the paper's", ratio, "times", 1.0),
        at_most(f"{name}: contacts found where there are none", compared.touched, "rows", 0),
    ]


def _cells(values: np.ndarray | tuple[float, ...]) -> list[str]:
    return [f"{value:.3f}" for value in values]
