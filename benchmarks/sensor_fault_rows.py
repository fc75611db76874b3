"""Random faults of a force/torque sensor and of the encoders: flagged when, recovered when.

Good readings carry noise and the board's step. Between bursts of one to six faulty ticks lie two to
six good ones. Every reading, flagged or not, is also thrown at a filter, which must refuse what is
not finite by itself.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from statistics import median

import numpy as np

from benchmarks.derivative_rows import costs_us
from dforc.arrays import Vector
from dforc.errors import NotFiniteError
from dforc.signals.differentiation import Differentiator
from dforc.signals.ft_channel import FtChannel
from dforc.signals.offsets import OffsetCalibration
from dforc.signals.sensor_watch import Flag, SensorWatch
from services.experiments.rows import Row, at_most

PERIOD_S = 0.001
FULL_SCALE = (1500.0,) * 3 + (35.0,) * 3
NOISE = np.array([0.05] * 3 + [0.002] * 3)
STEP = np.array([0.046] * 3 + [0.0011] * 3)  # full scale / 2^15
FAULTS: tuple[Flag, ...] = (
    "nan",
    "inf",
    "saturated",
    "frozen",
    "late",
    "reordered",
    "missing",
)


LOOK_EVERY = 8  # faults; a NaN would stay in the filter for 160 readings


@dataclass(slots=True)
class Tally:
    """What came of the faults."""

    faulty: int = 0
    unflagged: int = 0  # faulty readings without their cause in the same tick
    believed: int = 0  # faulty readings with `valid`
    false_alarms: int = 0
    not_finite: int = 0  # filter, offset or joints
    recoveries: list[int] = field(default_factory=list)  # good readings until valid


@dataclass(slots=True)
class Tick:
    """Arguments of one check."""

    wrench: tuple[float, ...] | None
    age_s: float
    saturated: bool
    frozen: bool
    stamp_s: float


def faulty_tick(kind: Flag, good: Tick, before: Tick, rng: np.random.Generator) -> Tick:
    """A good tick, spoilt."""
    assert good.wrench is not None
    values, at = list(good.wrench), int(rng.integers(6))
    tick = Tick(good.wrench, good.age_s, saturated=False, frozen=False, stamp_s=good.stamp_s)
    if kind == "nan":
        values[at] = math.nan
        tick.wrench = tuple(values)
    elif kind == "inf":
        values[at] = math.inf if rng.random() < 0.5 else -math.inf
        tick.wrench = tuple(values)
    elif kind == "saturated" and rng.random() < 0.5:
        values[at] = -FULL_SCALE[at]
        tick.wrench = tuple(values)
    elif kind == "saturated":
        tick.saturated = True
    elif kind == "frozen":
        tick.wrench, tick.frozen = before.wrench, True
    elif kind == "late":
        tick.age_s = float(rng.uniform(0.021, 0.099))
    elif kind == "reordered":
        tick.stamp_s = before.stamp_s - float(rng.uniform(0.1, 5.0)) * PERIOD_S
    else:
        tick.wrench, tick.age_s = None, float(rng.choice([0.03, 0.5, math.inf, math.nan]))
    return tick


def fault_tally(faulty: int, seed: int) -> Tally:
    """Throw that many faulty readings at a watch, a filter and an offset."""
    rng = np.random.default_rng(seed)
    watch, tally = SensorWatch(full_scale=FULL_SCALE), Tally()
    channel, open_channel, offset = FtChannel(), FtChannel(), OffsetCalibration(1)
    at_s, before, since_fault = 0.0, good_tick(0.0, rng), 0
    kind: Flag | None = None
    left = 3
    while tally.faulty < faulty:
        if left == 0:
            kind = None if kind else FAULTS[int(rng.integers(len(FAULTS)))]
            left = int(rng.integers(1, 7)) if kind else int(rng.integers(2, 7))
        left -= 1
        at_s += PERIOD_S
        good = good_tick(at_s, rng)
        tick = good if kind is None else faulty_tick(kind, good, before, rng)
        flags = watch.check(tick.wrench, tick.age_s, tick.saturated, tick.frozen, tick.stamp_s)
        if kind is None:
            since_fault = _judge_good(tally, flags, watch.valid, since_fault)
            before = good
        else:
            tally.faulty += 1
            tally.unflagged += kind not in flags
            tally.believed += watch.valid
            since_fault = 1
        if tick.wrench is not None:
            _feed(open_channel, offset, tick.wrench, at_s)
            if watch.valid:
                channel.push(tick.wrench, at_s)
        if tally.faulty % LOOK_EVERY == 0:
            tally.not_finite += _spoilt(channel, open_channel, offset, at_s)
    return tally


def good_tick(at_s: float, rng: np.random.Generator) -> Tick:
    """A healthy reading."""
    values = np.round((np.arange(6.0) + NOISE * rng.normal(size=6)) / STEP) * STEP
    return Tick(tuple(values.tolist()), 0.0005, saturated=False, frozen=False, stamp_s=at_s)


def _judge_good(tally: Tally, flags: Sequence[Flag], valid: bool, since_fault: int) -> int:
    tally.false_alarms += bool(flags)
    if since_fault and valid:
        tally.recoveries.append(since_fault)
        return 0
    return since_fault + 1 if since_fault else 0


def _feed(
    channel: FtChannel, offset: OffsetCalibration, wrench: tuple[float, ...], at_s: float
) -> None:
    """Nothing was watched: the state itself must refuse."""
    try:
        channel.push(wrench, at_s)
        offset.add(wrench, (0.0,) * 6)
    except NotFiniteError:
        pass


def _spoilt(
    channel: FtChannel, open_channel: FtChannel, offset: OffsetCalibration, at_s: float
) -> bool:
    found = (channel.filtered(at_s), open_channel.filtered(at_s), offset.offset, offset.spread)
    return not all(np.isfinite(part).all() for part in found)


def silent_freeze_readings() -> int:
    """Equal readings until a sensor is found frozen whose board says nothing."""
    rng, watch = np.random.default_rng(2), SensorWatch()
    for tick in range(20):
        good = good_tick(tick * PERIOD_S, rng)
        watch.check(good.wrench, 0.0, stamp_s=good.stamp_s)
    for equal in range(1, 100):
        if watch.check(good.wrench, 0.0, stamp_s=good.stamp_s + equal * PERIOD_S):
            return equal + 1
    return 100


def joint_faults_not_finite(ticks: int, seed: int) -> int:
    """NaN, jumps, garbage, gaps, late and doubled joint states: outputs that are not finite."""
    rng, joints, bad, at_s = np.random.default_rng(seed), Differentiator(4), 0, 0.0
    for _ in range(ticks):
        draw = rng.random()
        at_s += float(rng.choice([0.0, -0.01, 0.0001, 5.0])) if draw < 0.05 else 0.004
        q: Vector = np.sin(at_s + np.arange(4.0))
        if draw > 0.9:
            q[int(rng.integers(4))] = float(rng.choice([math.nan, math.inf, 1e6, 3.0, -0.5]))
        try:
            motion = joints.add(q, at_s)
        except NotFiniteError:
            continue
        bad += not all(np.isfinite(part).all() for part in motion)
    return bad


def fault_rows(short: bool) -> list[Row]:
    """Flags within the tick, recovery within two readings, never a NaN."""
    count = 10_000 if short else 100_000
    tally = fault_tally(count, 1)
    name = f"{tally.faulty} faulty readings"
    channel, watch = FtChannel(), SensorWatch(full_scale=FULL_SCALE)
    readings = [good_tick(tick * PERIOD_S, np.random.default_rng(tick)) for tick in range(2000)]
    wrenches = [reading.wrench or () for reading in readings]
    empty, check, push, read = costs_us(
        [
            lambda _: None,
            lambda k: watch.check(wrenches[k], 0.0, stamp_s=k * PERIOD_S),
            lambda k: channel.push(wrenches[k], k * PERIOD_S),
            lambda k: channel.filtered(k * PERIOD_S),
        ],
        2000,
    )
    return [
        at_most(f"{name}: cause not flagged in the same tick", tally.unflagged, "", 0),
        at_most(f"{name}: believed all the same", tally.believed, "", 0),
        at_most(f"{name}: filter, offset not finite", tally.not_finite, "", 0),
        at_most(f"{name}: readings until valid again, most", max(tally.recoveries), "", 2),
        at_most(f"{name}: false alarms among good readings", tally.false_alarms, "", 0),
        Row("frozen, the board silent: equal readings until flagged", silent_freeze_readings()),
        at_most(
            f"{count} joint states, 15 % faulty: not finite",
            joint_faults_not_finite(count, 1),
            "",
            0,
        ),
        Row("empty call", median(empty), "us"),
        at_most("watch, one reading", median(check), "us", 20),
        at_most("force/torque filter, one reading in", median(push), "us", 20),
        at_most("force/torque filter, read out", median(read), "us", 60),
    ]
