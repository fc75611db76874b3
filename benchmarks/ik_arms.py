"""Other arms, without a bar: both at once over one waist, and the robot file's own."""

from dataclasses import replace

import numpy as np

from benchmarks.ik_setting import Setting
from benchmarks.ik_tracking import LAP
from dforc.ik.inverse_kinematics import InverseKinematics
from dforc.ik.problem import TipTarget
from services.core.clock import NS_PER_MS, thread_cpu_ns
from services.experiments.ik.arm import TOLERANCE_M, both_arms, robot_arm
from services.experiments.ik.contenders import problem_of
from services.experiments.ik.field import ours, reference
from services.experiments.ik.measure import (
    KEPT_RAD,
    REPEATS,
    ROUNDING,
    follow,
    largest_step_rad,
    percent,
    worth,
)
from services.experiments.ik.paths import joint_path, lemniscate
from services.experiments.ik.poses import OURS, SETS, bars, sample
from services.experiments.ik.sets import SHORT, Sizes
from services.experiments.ik.table import times
from services.experiments.rows import Row

PAIRS, TICKS = 200, 500
FEWER = Sizes(reachable=200, unreachable=50, objective_starts=30, starts=20)


def rows(setting: Setting) -> list[Row]:
    """Pairs of poses, then the robot's own arm on the sets and paths."""
    return _pairs(setting) + _robot(setting)


def _pairs(setting: Setting) -> list[Row]:
    arm = both_arms()
    ik = InverseKinematics(problem_of(arm))
    rng = np.random.default_rng([setting.seed, 8])
    good, ms = [], []
    for q in arm.postures(rng, PAIRS // 5 if setting.short else PAIRS):
        poses = [arm.pose(q, tip) for tip in range(2)]
        targets = [TipTarget.checked(p, R) for R, p in poses]
        best_ns = 1 << 62
        for _ in range(REPEATS):
            begin_ns = thread_cpu_ns()
            result = ik.solve(targets, arm.rest)
            best_ns = min(best_ns, thread_cpu_ns() - begin_ns)
        ms.append(best_ns / NS_PER_MS)
        found = np.array(result.q_rad)
        off_m = max(arm.distance_m(found, p, tip) for tip, (_, p) in enumerate(poses))
        good.append(off_m <= ROUNDING * TOLERANCE_M and arm.violation(found) <= KEPT_RAD)
    what = f"both arms, {len(ms)} pairs of poses in reach"
    return [
        Row(f"{what}: 1 mm, all limits kept", percent(np.array(good)), "%"),
        Row(
            f"{what}: median/p99", f"{np.percentile(ms, 50):.3g}/{np.percentile(ms, 99):.3g}", "ms"
        ),
    ]


def _robot(setting: Setting) -> list[Row]:
    arm = robot_arm()
    sizes = SHORT if setting.short else FEWER
    field = ours(arm)[:1] if setting.short else [*ours(arm)[:1], reference(arm)]
    found: list[Row] = []
    for name in SETS:
        part = sample(name, arm, field, setting.seed, sizes, setting.say)
        found += [
            replace(row, bar="no bar on this arm", holds=None)
            for row in bars(part, f"{arm.name}: ")
        ]
        for who, run in part.runs.items():
            found.append(Row(f"{arm.name}, {name}: {who}, median/p99", times(run), "ms"))
    for path in (
        lemniscate(arm, setting.ticks(TICKS)),
        joint_path(arm, setting.seed, setting.ticks(TICKS)),
        lemniscate(arm, max(LAP, setting.ticks(TICKS)), far=True),
    ):
        run = follow(field[:1], path)[OURS]
        w = worth(arm, path.position, path.rotation, run)
        what = f"{arm.name}, {path.name}"
        found += [
            Row(f"{what}: in reach", percent(path.reached()), "%"),
            Row(f"{what}: 1 mm, limits kept, of those", percent(w.feasible()[path.reached()]), "%"),
            Row(f"{what}: largest joint step", float(np.degrees(largest_step_rad(run))), "deg"),
            Row(f"{what}: median/p99", times(run), "ms"),
        ]
    return found
