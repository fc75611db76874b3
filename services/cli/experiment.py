"""ulna experiment: figures and tables of the papers, made again, and the loops on the boards.

Each prints a table and what its numbers mean beside the paper's, and returns 0 when every bar
holds. What needs a package or a recording that is not here says so, and how to get it.
"""

from importlib.util import find_spec
from pathlib import Path
from typing import Annotated

from cyclopts import Parameter

from services.cli import experiment_dforc
from services.cli.complaint import complain
from services.cli.experiment_request import Json, check

Data = Annotated[Path | None, Parameter(name="--data")]
Several = Annotated[tuple[str, ...], Parameter(negative="", show_default=False)]


def force_table1(
    *,
    robot: str = "icub",
    data: Data = None,
    seed: int = 0,
    runs: int = 1,
    short: bool = False,
    json_file: Json = None,
) -> int:
    """Table 1: measured minus predicted force/torque wrench in free motion, per limb.

    On the emulated robot, whose masses and levers are not the model's; and on a recording of a real
    right arm, where that is at hand.

    Example: ulna experiment force-table1 --data icubdyn.tgz --json table1.json

    Args:
        robot: name[:parts][@site] of a robot in robots/, or a robot file.
        data: the recording icubdyn.tgz. Default: shared/data/icubdyn.tgz beside the checkout.
        seed: draws plant masses and levers, sensor noise and offset.
        runs: plants, one after another, with the seeds that follow.
        short: one plant and a few seconds of motion.
        json_file: write every value there.
    """
    check(runs, json_file)
    from services.experiments.forces import table1 as experiment

    return experiment.force_table1(
        robot=robot, data=data, seed=seed, runs=runs, short=short, json=json_file
    )


def force_fig5(
    *,
    robot: str = "icub",
    limb: str = "left_arm",
    seed: int = 0,
    short: bool = False,
    json_file: Json = None,
    plot: Path = Path("force-fig5.png"),
) -> int:
    """Figure 5: what a limb's force/torque sensor reads in free motion, and the prediction.

    Example: ulna experiment force-fig5 --limb right_leg --plot leg.png

    Args:
        robot: name[:parts][@site] of a robot in robots/, or a robot file.
        limb: left_arm, right_arm, left_leg or right_leg.
        seed: draws plant masses and levers, sensor noise and offset.
        short: a few seconds of motion.
        json_file: write every value there.
        plot: write the figure there.
    """
    check(1, json_file, plot)
    from services.experiments.forces import fig5 as experiment

    return experiment.force_fig5(
        robot=robot, limb=limb, seed=seed, short=short, json=json_file, plot=plot
    )


def force_fig6(
    *,
    runs: int = 25,
    short: bool = False,
    json_file: Json = None,
    plot: Path = Path("force-fig6.png"),
) -> int:
    """Figure 6: learners of inverse dynamics, joint by joint, on motion they have not seen.

    On a data set that a script makes of the model and friction; the paper's own are not published.
    scikit-learn's GPR takes part where it is installed (./ulna setup peers).

    Example: ulna experiment force-fig6 --runs 5 --json fig6.json

    Args:
        runs: seeds of the random features; fewer of the larger sizes.
        short: two runs on a small set.
        json_file: write every value there.
        plot: write the figure there.
    """
    check(runs, json_file, plot)
    if find_spec("sklearn") is None:
        complain("scikit-learn, and so its GPR, is left out; ./ulna setup peers installs it")
    from services.experiments.forces import fig6 as experiment

    return experiment.force_fig6(runs=runs, short=short, json=json_file, plot=plot)


def force_fig7(
    *,
    data: Data = None,
    runs: int = 25,
    short: bool = False,
    json_file: Json = None,
    plot: Path = Path("force-fig7.png"),
) -> int:
    """Figure 7: average error of incremental RFRR and KRR along the recording of a real arm.

    Beside them persistence, the model by itself, labels that come late, and frozen learners.

    Example: ulna experiment force-fig7 --data icubdyn.tgz --runs 5

    Args:
        data: the recording icubdyn.tgz. Default: shared/data/icubdyn.tgz beside the checkout.
        runs: seeds of the random features.
        short: two runs, and 200 features only.
        json_file: write every value there.
        plot: write the figure there.
    """
    check(runs, json_file, plot)
    from services.experiments.forces import fig7 as experiment

    return experiment.force_fig7(data=data, runs=runs, short=short, json=json_file, plot=plot)


def closed_loop(
    *,
    robot: str = "icub",
    seed: int = 0,
    short: bool = False,
    json_file: Json = None,
    plot: Path = Path("closed-loop.png"),
) -> int:
    """Closed loops on the boards: torque steps, pushes, hand guiding, velocity on impedance.

    On the emulated robot in virtual time, over its CAN frames, judged by the plant's true motion.

    Example: ulna experiment closed-loop --seed 3 --plot loops.png

    Args:
        robot: name[:parts][@site] of a robot in robots/, or a robot file.
        seed: draws plant masses and levers, sensor noise and offset.
        short: fewer joints, pushes and seconds.
        json_file: write every value there.
        plot: write the figure there.
    """
    check(1, json_file, plot)
    from services.experiments.loops import closed_loop as experiment

    return experiment.closed_loop(robot=robot, seed=seed, short=short, json=json_file, plot=plot)


def cartesian(
    *,
    robot: str = "icub:reach",
    seed: int = 0,
    runs: int = 3,
    plant: Several = (),
    controller: Several = (),
    short: bool = False,
    json_file: Json = None,
    plot: Path = Path("cartesian.png"),
) -> int:
    """Cartesian controllers side by side: a pair of poses in turn, and a lemniscate.

    This project's, iKin's law, VITE and damped least squares on the right hand, position and
    orientation controlled, with and without the torso; on an ideal arm, on one that lags, and
    through the emulated robot's boards and CAN frames in virtual time, with random reaches of both
    hands. All of it takes about ten minutes, most of it for the boards.

    Example: ulna experiment cartesian --plant ideal --plant lagged --plot paths.png

    Args:
        robot: name[:parts][@site] of a robot in robots/, or a robot file.
        seed: of the first plant: masses and levers, sensor noise and offset.
        runs: plants behind the boards, one after another, with the seeds that follow.
        plant: ideal, lagged or boards; may be given several times. Default: all.
        controller: ulna, reference, vite, vite-loop or dls; may be given several times.
            Default: all.
        short: with the torso only, fewer moves, a faster lemniscate and one plant.
        json_file: write every value there.
        plot: write the figure there.
    """
    check(runs, json_file, plot)
    from services.experiments.cartesian import comparison as experiment

    return experiment.cartesian(
        robot=robot,
        seed=seed,
        runs=runs,
        plants=plant,
        controllers=controller,
        short=short,
        json=json_file,
        plot=plot,
    )


def ik(
    *,
    robot: str = "",
    seed: int = 0,
    short: bool = False,
    json_file: Json = None,
    plot: Path = Path("ik.png"),
) -> int:
    """Solvers of inverse kinematics side by side: how often each is right, and how quickly.

    This project's three, stock IPOPT and fatrop, TRAC-IK, KDL, pink, mink and SciPy where they are
    installed, on poses in reach, on orientations and on positions out of reach. What can at best be
    reached is found by many starts of an independent solver: once, for some minutes.

    Example: ulna experiment ik --short --plot solvers.png

    Args:
        robot: name[:parts][@site] of a robot in robots/, or a robot file. Default: the arm that the
            published figures are of, for which alone there are bars.
        seed: draws the poses.
        short: fewer poses and starts.
        json_file: write every value there.
        plot: write time against success there.
    """
    check(1, json_file, plot)
    from services.experiments.ik import comparison as experiment

    return experiment.ik(robot=robot, seed=seed, short=short, json=json_file, plot=plot)


VERBS = (
    force_table1,
    force_fig5,
    force_fig6,
    force_fig7,
    closed_loop,
    cartesian,
    ik,
    *experiment_dforc.VERBS,
)
