"""What whole-arm scenes come to, as rows: reached and touched by every law, times, answers.

Bars hold for the project's own law. Beside the paper's field stand the figures of the literature
notes, whose scenes were drawn by another generator and whose arm had three capsules.
"""

from collections.abc import Callable, Mapping, Sequence

import numpy as np

from services.experiments.reporting import Tell
from services.experiments.rows import Row, at_least, at_most
from services.experiments.whole_arm.jobs import CHANGING, jobs_of, share
from services.experiments.whole_arm.run import Outcome

Found = dict[tuple[str, str], list[Outcome]]  # by kind of scene and law's name

OURS, EMPTY = "ulna", "empty loop"
RANDOM = ("1", "2", "5", "10")
HARD = ("head-on", "cusp", "wall", "ring", "cup")
LAWS = ("dforc", "dforc-inflated", "pmp", "point", "ulna")
FEW = 100  # scenes: with fewer, one missed would break a bar of percents
REACH_BARS = dict(zip(RANDOM, (100.0, 99.0, 97.0, 95.0), strict=True))
NOTED = {  # reached without contact, touched an obstacle [%], in the literature notes
    ("1", "dforc"): (57, 43),
    ("2", "dforc"): (55, 45),
    ("5", "dforc"): (25, 75),
    ("10", "dforc"): (17, 83),
    ("1", "dforc, hand + 1 cm"): (77, 23),
    ("2", "dforc, hand + 1 cm"): (70, 30),
    ("5", "dforc, hand + 1 cm"): (58, 40),
    ("10", "dforc, hand + 1 cm"): (37, 60),
}
TICK_MEDIAN_US, TICK_P999_US = 1000.0, 5000.0
ANSWER_MS = 100.0


def gather(
    kinds: Sequence[str],
    laws: Sequence[str],
    scenes: int,
    seed: int,
    tell: Tell,
    processes: int = 0,
) -> Found:
    """Run everything; the same scenes for every law."""
    jobs = jobs_of(kinds, laws, range(scenes), seed)
    found: Found = {}
    for done, (job, outcomes) in enumerate(share(jobs, processes), start=1):
        for outcome in outcomes:
            found.setdefault((job.kind, outcome.law), []).append(outcome)
        tell(f"whole arm, {job.kind}: {done} of {len(jobs)} portions")
    return found


def percent(found: Sequence[Outcome], holds: Callable[[Outcome], bool]) -> float:
    """Share of the scenes."""
    return 100.0 * sum(holds(outcome) for outcome in found) / len(found)


def rate_rows(found: Found) -> list[Row]:
    """Reached and touched, by kind of scene and law."""
    rows = []
    for (kind, law), outcomes in in_order(found):
        if law == EMPTY:
            continue
        what = f"{_scenes(kind, len(outcomes))}, {law}"
        rows += _rates(what, kind, law, outcomes)
    return rows


def _rates(what: str, kind: str, law: str, outcomes: Sequence[Outcome]) -> list[Row]:
    clean = percent(outcomes, lambda o: o.reached and o.is_clean)
    turned = percent(outcomes, lambda o: o.turned and o.is_clean)
    obstacle = percent(outcomes, lambda o: o.verdict.obstacle.distance_m <= 0.0)
    itself = percent(outcomes, lambda o: o.verdict.itself.distance_m <= 0.0)
    limits = percent(outcomes, lambda o: not o.keeps_limits)
    depth = 1e3 * min(
        min(o.verdict.obstacle.distance_m, o.verdict.itself.distance_m) for o in outcomes
    )
    noted = NOTED.get((kind, law))
    reached_bar, touched_bar = ("", "") if noted is None else (f"notes: {n}" for n in noted)
    times = [o.reached_s for o in outcomes if o.reached_s is not None]
    turn = Row(f"{what}: and within 3 deg", turned, "%")
    time = Row(f"{what}: time to 5 mm, median", float(np.median(times)) if times else None, "s")
    if law != OURS:
        return [
            Row(f"{what}: reached 5 mm without contact", clean, "%", reached_bar),
            turn,
            Row(f"{what}: touched an obstacle", obstacle, "%", touched_bar),
            Row(f"{what}: touched itself", itself, "%"),
            Row(f"{what}: left its limits", limits, "%"),
            Row(f"{what}: smallest distance", depth, "mm"),
            time,
        ]
    reach = Row(f"{what}: reached 5 mm without contact", clean, "%")
    if kind in REACH_BARS and len(outcomes) >= FEW:
        reach = at_least(reach.name, clean, "%", REACH_BARS[kind])
    rows = [
        reach,
        turn,
        at_most(f"{what}: touched an obstacle", obstacle, "%", 0.0),
        at_most(f"{what}: touched itself", itself, "%", 0.0),
        at_most(f"{what}: left its limits", limits, "%", 0.0),
        Row(f"{what}: smallest distance", depth, "mm"),
        time,
    ]
    if kind == "enclosed":
        said = percent(outcomes, lambda o: "unreachable" in o.states)
        rows.append(at_least(f"{what}: said unreachable while shut", said, "%", 100.0))
    return rows


def tick_rows(found: Found) -> list[Row]:
    """Time of a tick, the loop's own beside it; thread time of a processor."""
    rows = []
    for law in (OURS, EMPTY):
        mine = [o for (kind, name), each in found.items() if name == law for o in each]
        if not mine:
            continue
        ticks = np.concatenate([o.ticks_us for o in mine])
        what = f"tick, field and whole arm, {law}, {len(ticks)} ticks"
        median, p999 = (float(np.percentile(ticks, share)) for share in (50.0, 99.9))
        if law == OURS:
            rows += [
                at_most(f"{what}: median", median, "us", TICK_MEDIAN_US),
                at_most(f"{what}: p99.9", p999, "us", TICK_P999_US),
                Row(f"{what}: largest", float(ticks.max()), "us"),
            ]
        else:
            rows += [Row(f"{what}: median", median, "us"), Row(f"{what}: p99.9", p999, "us")]
    return rows


def answer_rows(found: Found) -> list[Row]:
    """From a goal's arrival until the arm draws nearer to it, or says why it does not."""
    rows = []
    for kinds, what in ((RANDOM, "from rest"), (("switch",), "in motion")):
        mine = [o for kind in kinds for o in found.get((kind, OURS), [])]
        if not mine:
            continue
        said = [1e3 * (np.inf if o.said_s is None else o.said_s) for o in mine]
        moved = [1e3 * (np.inf if o.moved_s is None else o.moved_s) for o in mine]
        name = f"new goal {what}, {len(mine)} scenes"
        rows += [
            at_most(f"{name}: nearer, or word of what is done, latest", max(said), "ms", ANSWER_MS),
            Row(f"{name}: nearer, median", float(np.median(moved)), "ms"),
            Row(
                f"{name}: nearer within 100 ms",
                100.0 * float(np.mean(np.array(moved) <= ANSWER_MS + 1e-6)),
                "%",
            ),
        ]
    return rows


def in_order(found: Found) -> list[tuple[tuple[str, str], list[Outcome]]]:
    """Kinds of scenes as they are listed, and the laws in theirs."""
    return sorted(found.items(), key=_order)


def _scenes(kind: str, count: int) -> str:
    if kind in RANDOM:
        return f"whole arm, {kind} balls, {count} scenes"
    if kind in CHANGING or kind in HARD:
        return f"whole arm, {kind}, {count} scenes"
    return f"whole arm, {kind}"


def _order(item: tuple[tuple[str, str], list[Outcome]]) -> tuple[int, int]:
    kinds = [*RANDOM, *HARD, *CHANGING]
    (kind, law), _ = item
    names = ["dforc", "dforc, hand + 1 cm", "pmp B", "point", OURS, EMPTY]
    return kinds.index(kind), names.index(law)


def by_law(found: Found, laws: Sequence[str], kinds: Sequence[str]) -> Mapping[str, list[float]]:
    """Percent reached without contact of each law, over the kinds (NaN where not run)."""
    return {
        law: [
            percent(found[kind, law], lambda o: o.reached and o.is_clean)
            if (kind, law) in found
            else float("nan")
            for kind in kinds
        ]
        for law in laws
    }
