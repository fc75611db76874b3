"""Figure 6: a hand follows a moving ball past a descending one, in the paper's field and ours.

Ours is the better point (`dforc/field/point.py`) before a perfect arm, and mode ulna on boards.
"""

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from rich.console import Console

from services.config import load_robot
from services.experiments.cartesian.arm import Arm
from services.experiments.field_figures.fig6_arm import PerfectArm
from services.experiments.field_figures.fig6_draw import fig6_scene
from services.experiments.field_figures.fig6_plot import draw
from services.experiments.field_figures.fig6_stack import run_stack
from services.experiments.field_scenes.moving import Measured, MovingRunner, measure
from services.experiments.field_scenes.moving_draw import MovingScene
from services.experiments.reporting import Tell, tell_motion, working
from services.experiments.rows import Row, at_most, publish

Array = NDArray[np.float64]

ROBOT, LIMB = "icub:reach", "right_arm"
RUNS, SHORT_RUNS = 10, 2
DFORC, BETTER, ULNA = "dforc", "better point", "ulna"
POINTS = DFORC, BETTER  # before a perfect arm
MODES = DFORC, ULNA  # on boards
TITLES = {DFORC: "dforc, the paper's field", BETTER: "better point, not mode ulna"}

EXPLANATION = """\
K = 4 N/m, D = 8 Ns/m, G = 10 N, obstacle 5 cm, T = 0.6 s, places with 10 mm of noise on each axis
every 10 ms. Both fields see the same places; distances are from the true balls, of the bare point
and of the hand's frame. The paper shows one run of this and gives no numbers. The better point is
the law of a bare point and not mode ulna; it has K = 9, D = 6 and filters what it sees. The arm is
perfect: where the Cartesian controller puts it. On boards, in the first run only, the field service
moves the hand in its modes dforc and ulna; ulna moves the whole arm."""


@dataclass(frozen=True, eq=False)
class Run:
    """One run of one field."""

    scene: MovingScene
    point: Array  # (k, 3)
    hand: Array  # (k, 3)

    @property
    def measured(self) -> tuple[Measured, Measured]:
        """Of the virtual point and of the hand."""
        return measure(self.scene, self.point), measure(self.scene, self.hand)


def dforc_fig6(
    *,
    seed: int = 0,
    runs: int = RUNS,
    short: bool = False,
    json: Path | None = None,
    plot: Path = Path("dforc-fig6.png"),
) -> int:
    """Table and plot; 0 when every bar on the better point and on ulna holds."""
    console = Console()
    with working(console, f"figure 6, seed {seed}") as tell:
        found = both_fields(seed, SHORT_RUNS if short else runs, tell)
        rows = [row for law in POINTS for row in figure_rows(law, found[law])]
        trails = [(TITLES[law], found[law][0].point, found[law][0].hand) for law in POINTS]
        scene = found[BETTER][0].scene
        if not short:
            boards = on_boards(seed, scene, tell)
            rows += [row for law in MODES for row in figure_rows(f"{law} on boards", [boards[law]])]
            trails += [(f"{law} on boards", boards[law].point, boards[law].hand) for law in MODES]
        draw(scene, trails, plot)
    status = publish(f"figure 6, seed {seed}", rows, json)
    console.print(EXPLANATION)
    console.print(f"plot: {plot}")
    return status


def both_fields(seed: int, runs: int, tell: Tell) -> dict[str, list[Run]]:
    """The same scenes through both."""
    arm = PerfectArm(Arm(load_robot(ROBOT), LIMB, torso=True))
    runner = MovingRunner()
    found: dict[str, list[Run]] = {DFORC: [], BETTER: []}
    for number in range(runs):
        scene = fig6_scene(np.random.default_rng([seed, 600 + number]))
        for law, roll in ((DFORC, runner.paper), (BETTER, runner.field)):
            tell(f"run {number + 1} of {runs}, {law}")
            point = roll(scene)
            found[law].append(Run(scene, point, arm.hand(point)))
    return found


def on_boards(seed: int, scene: MovingScene, tell: Tell) -> dict[str, Run]:
    """One scene through the emulated robot in virtual time."""

    def progress(at_s: float, what: str) -> None:
        tell_motion(tell, seed, at_s, what)

    paths = run_stack(load_robot(ROBOT), scene, seed, progress)
    return {law: Run(scene, *paths[law]) for law in MODES}


def figure_rows(law: str, runs: list[Run]) -> list[Row]:
    """Of all runs of one law; there are bars on ours."""
    points, hands = zip(*(run.measured for run in runs), strict=True)
    rows: list[Row] = []
    point = BETTER if law == BETTER else f"{law}, virtual point"
    for name, measured in ((point, points), (f"{law}, hand", hands)):
        touched = float(sum(one.clearance_m < 0.0 for one in measured))
        lag = 1e3 * float(np.mean([one.lag_m for one in measured]))
        final = 1e3 * float(np.mean([one.final_m for one in measured]))
        jerk = float(np.sqrt(np.mean([one.jerk_m_s3**2 for one in measured])))
        is_ours = not law.startswith(DFORC)
        rows += [
            at_most(f"{name}: touched", touched, "runs", 0.0)
            if is_ours
            else Row(f"{name}: touched", touched, "runs"),
            Row(f"{name}: nearest", 1e3 * min(one.clearance_m for one in measured), "mm"),
            Row(f"{name}: mean distance from the target, 2 to 6 s", lag, "mm"),
            at_most(f"{name}: final error, mean", final, "mm", 5.0)
            if is_ours
            else Row(f"{name}: final error, mean", final, "mm"),
            Row(f"{name}: jerk, rms", jerk, "m/s^3"),
        ]
    return rows
