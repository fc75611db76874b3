"""Whole-arm scenes by every law, and each failure with its scene and its cause.

python -m services.experiments.field_arm_scenes --n 1,5 --families wall,cup --scenes 20 --seed 1
    [--laws dforc,ulna] [--from 0]
"""

import argparse
import sys
from collections.abc import Iterable, Iterator, Sequence

import numpy as np

from services.experiments.field_arm_draw import (
    COUNTS,
    FAMILIES,
    ArmScene,
    family_scene,
    random_scene,
)
from services.experiments.field_arm_laws import ArmLaw
from services.experiments.field_arm_lineup import LAWS, make_law
from services.experiments.field_arm_run import TURNED_RAD, Outcome, Trace, run
from services.experiments.field_arm_setting import ArmSetting, arm_setting


def scene_of(setting: ArmSetting, family: str, number: int, seed: int) -> ArmScene:
    """A scene by its name: `5` for five random spheres, or a hard family."""
    if family in FAMILIES:
        return family_scene(setting, family, number, seed)
    return random_scene(setting, int(family), number, seed)


def replay(family: str, number: int, seed: int, law: str = "ulna") -> tuple[Outcome, Trace]:
    """One scene again, with every posture."""
    setting = arm_setting()
    return run(setting, make_law(law, setting), scene_of(setting, family, number, seed))


def outcomes(
    setting: ArmSetting, laws: Sequence[ArmLaw], families: Iterable[str], numbers: range, seed: int
) -> Iterator[Outcome]:
    """Everybody on the same scenes."""
    for family in families:
        for number in numbers:
            scene = scene_of(setting, family, number, seed)
            for law in laws:
                yield run(setting, law, scene)[0]


def summary(found: Sequence[Outcome]) -> str:
    """One law on one family, in a line."""
    count = len(found)
    reached = [o for o in found if o.reached]
    clean = [o for o in found if o.is_clean]
    both = [o for o in reached if o.is_clean]
    turned = [o for o in both if o.angle_rad <= TURNED_RAD]
    nearest = min(min(o.verdict.obstacle.distance_m, o.verdict.itself.distance_m) for o in found)
    ticks = np.array([us for o in found for us in o.ticks_us[1:]])
    times = [o.reached_s for o in reached if o.reached_s is not None]
    return (
        f"{found[0].law:20s} {found[0].family:10s} {count:4d} scenes: reached clean "
        f"{100 * len(both) / count:5.1f} % (turned too {100 * len(turned) / count:5.1f} %), "
        f"contact {100 * (count - len(clean)) / count:5.1f} %, nearest {1e3 * nearest:6.1f} mm, "
        f"median {np.median(times) if times else np.nan:5.2f} s, tick "
        f"{np.median(ticks):.0f} us p99.9 {np.percentile(ticks, 99.9):.0f} us"
    )


def main() -> int:
    """Run what was asked for."""
    parser = argparse.ArgumentParser(description=str(__doc__).partition("\n")[0])
    parser.add_argument("--n", default="", help="spheres, comma between")
    parser.add_argument("--families", default="")
    parser.add_argument("--scenes", type=int, default=20)
    parser.add_argument("--from", type=int, default=0, dest="first")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--laws", default="ulna", help=", ".join(LAWS))
    given = parser.parse_args()
    families = [name for name in (*given.n.split(","), *given.families.split(",")) if name]
    setting = arm_setting()
    laws = [make_law(name, setting) for name in given.laws.split(",")]
    numbers = range(given.first, given.first + given.scenes)
    for family in families or [str(count) for count in COUNTS]:
        found: dict[str, list[Outcome]] = {law.name: [] for law in laws}
        for outcome in outcomes(setting, laws, [family], numbers, given.seed):
            found[outcome.law].append(outcome)
            cause = outcome.cause()
            if cause:
                _say(f"  {outcome.law}, {outcome.family}, scene {outcome.number}: {cause}")
        for each in found.values():
            _say(summary(each))
    return 0


def _say(line: str) -> None:
    sys.stdout.write(line + "\n")
    sys.stdout.flush()


if __name__ == "__main__":
    raise SystemExit(main())
