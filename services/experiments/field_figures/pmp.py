"""PMP on many targets: how near it comes in 3 s, with and without its fields, and what diverges.

K = 4 N/m (4 Nm/rad), alpha = 0.05 Nm, A = 1, tau = 3 s, epsilon = 1e-3, every 10 ms, variant B. The
bars are the medians of the literature notes, a quarter either way.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from dforc.arrays import Matrix, Vector
from dforc.field.force import FieldParams, ball, scene_of
from dforc.field.kernel_force import Scene
from dforc.pmp.motion import NO_OBSTACLES, Pmp, PmpTarget
from dforc.pmp.params import Orientation, PmpParams
from services.experiments.field_figures.pmp_arm import (
    MEASURED,
    OWN,
    HandPose,
    PmpArm,
    arm_of,
    edge,
    leaving_room,
    mid_range,
)
from services.experiments.rows import Row, at_least, within

TARGETS, SHORT_TARGETS = 200, 60
PERIOD_S = 0.01
SHARE = 0.25  # of the notes' median, either way
RADIUS_M, GAIN_N = 0.02, 8.0
ASIDE_M = 0.01  # of the obstacle's centre from the straight line
ROOM_M = 0.06  # of the way at least: the obstacle stands 1 cm clear of both ends
DIVERGED = 33.4  # %


@dataclass(frozen=True, slots=True, kw_only=True)
class Setting:
    """One line of the table: what is switched on, and the notes' figures."""

    key: str
    what: str
    params: PmpParams
    seconds: float
    at_edge: bool
    median_mm: float  # of the notes
    paper: str = ""
    obstacle: bool = False
    times: int = 1  # as many targets: a share needs more of them than a median does


FIELDS, FREE = 0.05, 0.0
SETTINGS = (
    Setting(
        key="A",
        what="A: mid-range, no limit fields, Gamma",
        params=PmpParams(limit_gain_nm=FREE),
        seconds=3.0,
        at_edge=False,
        median_mm=12.3,
        paper="4 mm, a good case",
    ),
    Setting(
        key="A 30 s",
        what="A: mid-range, no limit fields, no Gamma, 30 s",
        params=PmpParams(limit_gain_nm=FREE, has_time_base=False),
        seconds=30.0,
        at_edge=False,
        median_mm=1.8,
    ),
    Setting(
        key="A fields",
        what="A: mid-range, limit fields, Gamma",
        params=PmpParams(limit_gain_nm=FIELDS),
        seconds=3.0,
        at_edge=False,
        median_mm=44.0,
    ),
    Setting(
        key="B blue",
        what="B blue: edge, limit fields, Gamma",
        params=PmpParams(limit_gain_nm=FIELDS),
        seconds=3.0,
        at_edge=True,
        median_mm=31.0,
        paper="3 cm",
    ),
    Setting(
        key="B black",
        what="B black: edge, no limit fields, Gamma, joints clamped",
        params=PmpParams(limit_gain_nm=FREE),
        seconds=3.0,
        at_edge=True,
        median_mm=38.7,
        paper="5 cm",
    ),
    Setting(
        key="B 30 s",
        what="B: edge, no limit fields, no Gamma, 30 s",
        params=PmpParams(limit_gain_nm=FREE, has_time_base=False),
        seconds=30.0,
        at_edge=True,
        median_mm=10.7,
    ),
    Setting(
        key="B log",
        what="B green: edge, orientation by logarithm, limit fields, no Gamma, 30 s",
        params=PmpParams(limit_gain_nm=FIELDS, has_time_base=False, orientation=Orientation.LOG),
        seconds=30.0,
        at_edge=True,
        median_mm=65.0,
    ),
    Setting(
        key="B raw",
        what="B green: edge, orientation by raw difference, limit fields, no Gamma, 30 s",
        params=PmpParams(limit_gain_nm=FIELDS, has_time_base=False, orientation=Orientation.RAW),
        seconds=30.0,
        at_edge=True,
        median_mm=84.0,
        paper="diverges",
        times=5,
    ),
    Setting(
        key="C",
        what="C: mid-range, obstacle on the way, no limit fields, Gamma",
        params=PmpParams(limit_gain_nm=FREE),
        seconds=3.0,
        at_edge=False,
        median_mm=14.0,
        paper="avoided, target missed",
        obstacle=True,
    ),
)


@dataclass(frozen=True, slots=True, eq=False)
class Outcome:
    """One line of the table on one arm: one value per target."""

    setting: Setting
    errors_m: Vector
    started_m: Vector  # from the target
    depths_m: Vector  # into the obstacle; empty without one

    @property
    def diverged(self) -> float:
        """Share of targets [%] from which the hand ends farther away than it began."""
        return 100.0 * float(np.mean(self.errors_m > self.started_m))

    def error_mm(self, percent: float) -> float:
        """A percentile of the final errors."""
        return 1e3 * float(np.percentile(self.errors_m, percent))


def targets_of(arm: PmpArm, seed: int, count: int) -> dict[bool, list[HandPose]]:
    """Targets at the edge (True) and mid-range (False)."""
    for_edge, for_middle = (np.random.default_rng(s) for s in np.random.SeedSequence(seed).spawn(2))
    return {
        True: arm.poses(edge(arm, for_edge, count)),
        False: arm.poses(mid_range(arm, for_middle, count)),
    }


def run_setting(arm: PmpArm, setting: Setting, targets: Sequence[HandPose], seed: int) -> Outcome:
    """One line of the table."""
    pmp = Pmp(arm.model, arm.model.lower_rad, arm.model.upper_rad, setting.params)
    steps = round(setting.seconds / PERIOD_S)
    rng = np.random.default_rng(seed)
    home = arm.home_m
    if setting.obstacle:
        targets = leaving_room(arm, targets, ROOM_M)
    errors, depths = [], []
    for target in targets:
        scene, centre = _blocked(home, target, rng) if setting.obstacle else (NO_OBSTACLES, None)
        wanted = PmpTarget(position_m=target.position_m, rotation=target.rotation)
        path = pmp.roll_out(pmp.begin(arm.home_rad), wanted, scene, steps=steps).positions_m
        errors.append(float(np.linalg.norm(path[-1] - target.position_m)))
        if centre is not None:
            depths.append(RADIUS_M - float(np.linalg.norm(path - centre, axis=1).min()))
    started = np.array([np.linalg.norm(t.position_m - home) for t in targets])
    return Outcome(setting, np.array(errors), started, np.array(depths))


def outcomes(urdf: str, seed: int, count: int) -> list[Outcome]:
    """All lines on one model."""
    arm = arm_of(urdf)
    targets = {times: targets_of(arm, seed, times * count) for times in {s.times for s in SETTINGS}}
    return [run_setting(arm, s, targets[s.times][s.at_edge], seed) for s in SETTINGS]


def pmp_rows(short: bool = False, seed: int = 0) -> list[Row]:
    """Every line on both models; bars on the one that the notes measured."""
    count = SHORT_TARGETS if short else TARGETS
    rows = [row for outcome in outcomes(MEASURED, seed, count) for row in rows_of(outcome)]
    for outcome in outcomes(OWN, seed, count):
        rows.append(
            Row(f"PMP {outcome.setting.what}, on {OWN}: median", outcome.error_mm(50), "mm")
        )
    return rows


def rows_of(outcome: Outcome) -> list[Row]:
    """The figures of one line, with bars."""
    setting = outcome.setting
    middle = setting.median_mm
    beside = f" (paper: {setting.paper})" if setting.paper else ""
    low, high = (1.0 - SHARE) * middle, (1.0 + SHARE) * middle
    rows = [
        within(f"PMP {setting.what}: error, median{beside}", outcome.error_mm(50), "mm", low, high),
        Row(f"PMP {setting.key}: error, p90", outcome.error_mm(90), "mm"),
        Row(f"PMP {setting.key}: error, largest", outcome.error_mm(100), "mm"),
    ]
    if setting.params.orientation is Orientation.RAW:
        name = "PMP B raw: ends farther away than it began"
        rows.append(at_least(name, outcome.diverged, "%", DIVERGED))
    elif setting.params.orientation is Orientation.LOG:
        rows.append(Row("PMP B log: ends farther away than it began", outcome.diverged, "%"))
    if setting.key == "A":
        share = 100.0 * float(np.mean(outcome.errors_m < 0.005))
        rows.append(Row("PMP A: below 5 mm", share, "%"))
    if len(outcome.depths_m):
        entered = 100.0 * float(np.mean(outcome.depths_m > 0.0))
        rows.append(Row("PMP C: obstacle entered", entered, "%"))
        rows.append(Row("PMP C: deepest", 1e3 * float(outcome.depths_m.max()), "mm"))
    return rows


def _blocked(home_m: Vector, target: HandPose, rng: np.random.Generator) -> tuple[Scene, Vector]:
    """A ball half way, a little beside the straight line; and its centre."""
    way = target.position_m - home_m
    aside = np.cross(way, rng.normal(size=3))
    centre: Vector = home_m + 0.5 * way + ASIDE_M * aside / np.linalg.norm(aside)
    x, y, z = centre.tolist()
    scene = scene_of((), (ball((x, y, z), RADIUS_M),), FieldParams(gain_n=GAIN_N))
    return scene, centre


def path_of(
    arm: PmpArm, params: PmpParams, target: HandPose, obstacles: Scene | None, seconds: float
) -> Matrix:
    """Path of the virtual hand (k, 3), for a picture."""
    pmp = Pmp(arm.model, arm.model.lower_rad, arm.model.upper_rad, params)
    wanted = PmpTarget(position_m=target.position_m, rotation=target.rotation)
    steps, scene = round(seconds / PERIOD_S), NO_OBSTACLES if obstacles is None else obstacles
    return pmp.roll_out(pmp.begin(arm.home_rad), wanted, scene, steps=steps).positions_m
