"""ulna experiment dforc-...: the force fields' figures, and scenes for every law."""

from pathlib import Path

from services.cli.experiment_request import Json, check
from services.core.errors import ConfigError

MOST_SCENES = 1000


def dforc_scenes(
    *,
    scenes: int = 100,
    level: str = "all",
    seed: int = 0,
    short: bool = False,
    json_file: Json = None,
    plot: Path = Path("dforc-scenes.png"),
) -> int:
    """Seeded scenes: what every law reaches, and what it touches, hand only and whole arm.

    1, 2, 5 and 10 balls at random; head-on, cusp, wall, ring and cup; then a goal that is switched,
    a ball that passes, the other arm at work, a cage around the goal, and both arms at once. An
    independent referee judges every posture, and four between two wherever it may matter. All of
    it takes about half an hour on two cores.

    Example: ulna experiment dforc-scenes --level arm --scenes 20 --plot scenes.png

    Args:
        scenes: of the arm for each number of balls; at most 25 for each of the others.
        level: point, arm or all.
        seed: draws the scenes.
        short: a few scenes of each.
        json_file: write every value there.
        plot: write rates and one scene there.
    """
    if not 1 <= scenes <= MOST_SCENES:
        raise ConfigError(f"--scenes: {scenes} is outside 1..{MOST_SCENES}")
    check(1, json_file, plot)
    from services.experiments.field_scenes import comparison as experiment

    return experiment.dforc_scenes(
        scenes=scenes, level=level, seed=seed, short=short, json=json_file, plot=plot
    )


def dforc_fig6(
    *,
    seed: int = 0,
    runs: int = 10,
    short: bool = False,
    json_file: Json = None,
    plot: Path = Path("dforc-fig6.png"),
) -> int:
    """Figure 6: a hand follows a moving ball past a descending one, both seen with noise.

    By the paper's field with its constants, and by the better point on the same runs; behind each
    an arm that does what the Cartesian controller says. Then, in modes dforc and ulna, on the
    emulated robot's boards in virtual time, which takes some minutes.

    Example: ulna experiment dforc-fig6 --seed 3 --plot trails.png

    Args:
        seed: draws the balls' ways and the noise.
        runs: with one seed after another; the plot shows the first.
        short: two runs, and no boards.
        json_file: write every value there.
        plot: write the four trails there.
    """
    check(runs, json_file, plot)
    from services.experiments.field_figures import fig6 as experiment

    return experiment.dforc_fig6(seed=seed, runs=runs, short=short, json=json_file, plot=plot)


def dforc_fig4(
    *,
    seed: int = 0,
    short: bool = False,
    json_file: Json = None,
    plot: Path = Path("dforc-fig4.png"),
) -> int:
    """Figure 4: how far PMP's point drifts from its arm when it is integrated in task space.

    Both variants of Table I on the same targets, steps of 1 to 20 ms.

    Example: ulna experiment dforc-fig4 --plot drift.png

    Args:
        seed: draws the targets.
        short: fewer targets.
        json_file: write every value there.
        plot: write two paths and the drift over the step there.
    """
    check(1, json_file, plot)
    from services.experiments.field_figures import fig4 as experiment

    return experiment.dforc_fig4(seed=seed, short=short, json=json_file, plot=plot)


def dforc_fig5(
    *,
    robot: str = "icub:reach",
    seed: int = 0,
    runs: int = 10,
    short: bool = False,
    json_file: Json = None,
    plot: Path = Path("dforc-fig5.png"),
) -> int:
    """Figure 5: PMP's reaches and DForC's on the same targets, with the paper's constants.

    PMP on 200 targets a line; DForC's point and inverse kinematics on the same ones; then a reach
    with and without an obstacle through the whole stack, on several plants. Most of the time, some
    minutes, is for the last.

    Example: ulna experiment dforc-fig5 --runs 3 --plot reaches.png

    Args:
        robot: name[:parts][@site] of a robot in robots/, or a robot file.
        seed: draws the targets, and the first plant's masses and levers, sensor noise and offset.
        runs: plants behind the boards, one after another, with the seeds that follow.
        short: fewer targets and one plant.
        json_file: write every value there.
        plot: write the five reaches there.
    """
    check(runs, json_file, plot)
    from services.experiments.field_figures import fig5 as experiment

    return experiment.dforc_fig5(
        robot=robot, seed=seed, runs=runs, short=short, json=json_file, plot=plot
    )


VERBS = (dforc_fig4, dforc_fig5, dforc_scenes, dforc_fig6)
