"""Figure 4: the point that PMP integrates in task space drifts away from the arm that it moves.

Variant A's point is the integral of J dq (eq. 6), the arm's hand kin(integral of dq) (eq. 7);
variant B's point is the hand. The figure of the paper shows two paths that part visibly and says
neither the step nor the distance.
"""

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from rich.console import Console

from dforc.arrays import Matrix, Vector
from dforc.pmp.motion import Pmp, PmpTarget
from dforc.pmp.params import PmpParams, Variant
from services.experiments.field_figures.fig4_plot import Example, draw
from services.experiments.field_figures.pmp_arm import (
    MEASURED,
    HandPose,
    PmpArm,
    arm_of,
    edge,
    mid_range,
)
from services.experiments.reporting import Tell, working
from services.experiments.rows import Row, at_most, publish, within

STEPS_MS = (1.0, 2.0, 5.0, 10.0, 20.0)
NOTES_MM = {1.0: 0.02, 5.0: 0.12, 10.0: 0.25, 20.0: 0.50}  # medians of the literature notes
TARGETS, SHORT_TARGETS = 120, 20
PAPER_MS = 10.0
COARSE_MS = 100.0  # a step at which the two paths part for the eye
DURATION_S = 3.0
NO_DRIFT_M = 1e-9

EXPLANATION = """\
Drift: between variant A's point and the hand of its arm, at the end of a reach of 3 s, K = 4 N/m,
no limit fields, Gamma. It is first order in the step; at the paper's 10 ms a millimetre at most
(mid-range targets; up to 1.2 mm in the literature notes) or two (edge of the workspace). Paths that
part as visibly as in the paper's picture need a step ten times as long, or a coarse Jacobian."""


@dataclass(frozen=True, slots=True, eq=False)
class Drifts:
    """At the end of every reach, for one step: (k,) each [m]."""

    step_ms: float
    of_a: Vector
    of_b: Vector


def dforc_fig4(
    *,
    seed: int = 0,
    short: bool = False,
    json: Path | None = None,
    plot: Path = Path("dforc-fig4.png"),
) -> int:
    """The table and the plot; 0 when every bar holds."""
    console = Console()
    arm = arm_of(MEASURED)
    with working(console, f"drift on {MEASURED}, seed {seed}") as tell:
        drifts = measure(arm, seed, SHORT_TARGETS if short else TARGETS, tell)
        farthest = _farthest(arm, seed)
        examples = [_example(arm, farthest, step_ms) for step_ms in (COARSE_MS, PAPER_MS)]
        at_edge = edge_row(arm, seed, SHORT_TARGETS if short else TARGETS)
    draw([(one.step_ms, one.of_a) for one in drifts], examples, plot)
    status = publish(f"DForC figure 4, {MEASURED}, seed {seed}", [*rows_of(drifts), at_edge], json)
    console.print(EXPLANATION)
    console.print(f"plot: {plot}")
    return status


def drift_rows(short: bool = False, seed: int = 0) -> list[Row]:
    """The same figures without table and plot."""
    arm, count = arm_of(MEASURED), SHORT_TARGETS if short else TARGETS
    return [*rows_of(measure(arm, seed, count)), edge_row(arm, seed, count)]


def measure(arm: PmpArm, seed: int, count: int, tell: Tell | None = None) -> list[Drifts]:
    """Every step on the same targets."""
    targets = arm.poses(mid_range(arm, np.random.default_rng(seed), count))
    found = []
    for step_ms in STEPS_MS:
        if tell is not None:
            tell(f"drift on {arm.name}: {count} reaches with a step of {step_ms:g} ms")
        ends = [
            [_drift(arm, target, variant, step_ms) for target in targets]
            for variant in (Variant.A, Variant.B)
        ]
        found.append(Drifts(step_ms, np.array(ends[0]), np.array(ends[1])))
    return found


def edge_row(arm: PmpArm, seed: int, count: int) -> Row:
    """Largest drift at the paper's step among targets at the edge of the workspace."""
    targets = arm.poses(edge(arm, np.random.default_rng(seed), count))
    drifts = [_drift(arm, target, Variant.A, PAPER_MS) for target in targets]
    name = f"drift of variant A at {PAPER_MS:g} ms, edge targets, largest"
    return Row(name, 1e3 * max(drifts), "mm")


def slope(drifts: list[Drifts]) -> float:
    """Of the median drift over the step, both as logarithms."""
    steps = np.log([one.step_ms for one in drifts])
    medians = np.log([np.median(one.of_a) for one in drifts])
    return float(np.polyfit(steps, medians, 1)[0])


def rows_of(drifts: list[Drifts]) -> list[Row]:
    """Figures with their bars."""
    rows = []
    for one in drifts:
        notes = NOTES_MM.get(one.step_ms)
        beside = "" if notes is None else f" (notes: {notes:g})"
        name = f"drift of variant A at {one.step_ms:g} ms"
        rows.append(Row(f"{name}, median{beside}", 1e3 * float(np.median(one.of_a)), "mm"))
        rows.append(Row(f"{name}, largest", 1e3 * float(one.of_a.max()), "mm"))
    largest_b = max(float(one.of_b.max()) for one in drifts)
    return [
        *rows,
        within("drift over step, slope of the logarithms", slope(drifts), "", 0.9, 1.1),
        at_most("drift of variant B, largest", largest_b, "m", NO_DRIFT_M),
    ]


def _pmp(arm: PmpArm, variant: Variant) -> Pmp:
    params = PmpParams(variant=variant, limit_gain_nm=0.0, duration_s=DURATION_S)
    return Pmp(arm.model, arm.model.lower_rad, arm.model.upper_rad, params)


def _paths(
    arm: PmpArm, target: HandPose, variant: Variant, step_ms: float
) -> tuple[Matrix, Matrix]:
    """Postures (k, n) and the point that the variant says (k, 3)."""
    pmp = _pmp(arm, variant)
    wanted = PmpTarget(position_m=target.position_m)
    steps = round(DURATION_S * 1e3 / step_ms)
    path = pmp.roll_out(pmp.begin(arm.home_rad), wanted, steps=steps, dt_s=step_ms * 1e-3)
    return path.q_rad, path.positions_m


def _drift(arm: PmpArm, target: HandPose, variant: Variant, step_ms: float) -> float:
    q, x = _paths(arm, target, variant, step_ms)
    return float(np.linalg.norm(x[-1] - arm.model.tip_pose(q[-1])[1]))


def _example(arm: PmpArm, target: HandPose, step_ms: float) -> Example:
    q, x = _paths(arm, target, Variant.A, step_ms)
    hand = np.array([arm.model.tip_pose(row)[1] for row in q])
    return Example(step_ms, x, hand, target.position_m)


def _farthest(arm: PmpArm, seed: int) -> HandPose:
    targets = arm.poses(edge(arm, np.random.default_rng(seed), SHORT_TARGETS))
    home = arm.home_m
    return max(targets, key=lambda target: float(np.linalg.norm(target.position_m - home)))
