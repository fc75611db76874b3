"""What the trials of the closed loops come to, as figures with bars.

A figure that is no number fails, and so does a measurement that should be there and is not.
"""

import math
from collections.abc import Iterable, Sequence

import numpy as np

from services.experiments.loops.guiding import Guiding
from services.experiments.loops.impedance import Deflection
from services.experiments.loops.torque import BAND, STEADY_S, STEP_S, TorqueStep
from services.experiments.loops.velocity import Turn
from services.experiments.rows import Row, at_most, within

RATIO_LOW, RATIO_HIGH = 0.9, 1.1
BACK_MM = 5.0
REST_DEG_S = 1.0
OVERSHOOT = 0.3
STEADY = 0.2  # dry friction over loop gain, from one side to the other: 0.3 of 1.5 Nm in a shoulder
DRIFT_DEG = 1.0
LED_N = 15.0
LEFT_MM = 10.0
STOP_DEG = 0.5
GROUPS = (
    ("shoulder and elbow", ("shoulder", "elbow")),
    ("prosup", ("prosup",)),
    ("hip and knee", ("hip", "knee")),
    ("ankle", ("ankle",)),
)


def step_rows(steps: Sequence[TorqueStep], expected: Sequence[str]) -> list[Row]:
    """Torque control, by kind of joint: the worst of each. `expected` joints."""
    rows = _measured("torque steps measured", [step.joint for step in steps], expected)
    for group, names in GROUPS:
        if any(name in joint for joint in expected for name in names):
            chosen = [step for step in steps if any(name in step.joint for name in names)]
            rows += _group_rows(f"torque step, {group} ({len(chosen)} joints)", chosen)
    return rows


def _group_rows(what: str, chosen: Sequence[TorqueStep]) -> list[Row]:
    dead_ms = _most(step.dead_s for step in chosen) * 1e3
    first_ms = _most(step.first_crossing_s for step in chosen) * 1e3
    overshoot = _most(step.overshoot for step in chosen)
    change = _most(step.change_error for step in chosen)
    return [
        _shown(f"{what}: dead time, longest", dead_ms, "ms"),
        _shown(f"{what}: 0.1 to 0.9, first crossings, longest", first_ms, "ms"),
        _settling_row(f"{what}: within {BAND:g} of the step for good, last", chosen),
        at_most(f"{what}: overshoot, largest", overshoot, "", OVERSHOOT),
        at_most(f"{what}: steady error of the change, largest", change, "", STEADY),
        _shown(
            f"{what}: off the commanded torque before or after, over the step, largest",
            _most(step.absolute_error for step in chosen),
            "",
        ),
        _shown(
            f"{what}: off the commanded torque before or after, largest",
            _most(step.absolute_error_nm for step in chosen),
            "Nm",
        ),
        _shown(f"{what}: ripple, largest", _most(step.ripple_nm for step in chosen), "Nm"),
    ]


def _settling_row(name: str, chosen: Sequence[TorqueStep]) -> Row:
    times_s = [step.settling_s for step in chosen]
    late = sum(map(math.isinf, times_s))
    if late:
        others_ms = 1e3 * _most(time_s for time_s in times_s if not math.isinf(time_s))
        watched_ms = (STEP_S - STEADY_S) * 1e3
        told = f"{others_ms:.0f}, but {late} leave it after {watched_ms:.0f}"
        return Row(name, told, "ms")
    return _shown(name, _most(times_s) * 1e3, "ms")


def deflection_rows(deflections: Sequence[Deflection], expected: Sequence[str]) -> list[Row]:
    """Pushes of 20 N, by place. `expected` places."""
    rows = _measured("pushes measured", [one.place for one in deflections], expected)
    for place in dict.fromkeys(expected):
        chosen = [one for one in deflections if one.place == place]
        what = f"20 N at the {place} ({len(chosen)} pushes): deflection over K^-1 J' F"
        for word, ratio in (
            ("smallest", _least(one.ratio for one in chosen)),
            ("largest", _most(one.ratio for one in chosen)),
        ):
            rows.append(within(f"{what}, {word}", ratio, "", RATIO_LOW, RATIO_HIGH))
        sizes = [float(np.linalg.norm(one.predicted_m)) for one in chosen]
        size_mm = float(np.median(sizes)) * 1e3 if sizes else math.nan
        rows.append(_shown(f"20 N at the {place}: deflection, median", size_mm, "mm"))
        back_mm = _most(one.back_m for one in chosen) * 1e3
        rows.append(at_most(f"20 N at the {place}: not come back, largest", back_mm, "mm", BACK_MM))
    if expected:
        mean = float(np.degrees(_most(one.rest_mean_rad_s for one in deflections)))
        rest = float(np.degrees(_most(one.rest_rad_s for one in deflections)))
        what = "compliant joints at rest"
        rows += [
            _shown(f"{what}, the second before the next push: mean |dq|, largest", mean, "deg/s"),
            at_most(f"{what}: fastest 50 ms of half a second, largest", rest, "deg/s", REST_DEG_S),
        ]
    return rows


def guiding_rows(guidings: Sequence[Guiding], expected: Sequence[str]) -> list[Row]:
    """No stiffness, gravity held. `expected` limbs."""
    rows = _measured("limbs led by the hand", [one.limb for one in guidings], expected)
    for kind in ("arm", "leg"):
        if any(kind in limb for limb in expected):
            chosen = [one for one in guidings if kind in one.limb]
            what = f"guiding, {kind}s"
            drift = float(np.degrees(_most(one.drift_rad for one in chosen)))
            mean_n = _most(one.force_n for one in chosen)
            peak_n = _most(one.peak_n for one in chosen)
            left_mm = _most(one.left_m for one in chosen) * 1e3
            rows += [
                at_most(f"{what}: drift untouched, largest", drift, "deg", DRIFT_DEG),
                _shown(f"{what}: force at 0.1 m/s, mean, largest", mean_n, "N"),
                at_most(f"{what}: force, peak of the whole way, largest", peak_n, "N", LED_N),
                at_most(f"{what}: moves on once let go, largest", left_mm, "mm", LEFT_MM),
            ]
    return rows


def turn_rows(turns: Sequence[Turn], expected: Sequence[str]) -> list[Row]:
    """Velocity on top of impedance. `expected` joints."""
    rows = _measured("velocity moves measured", [one.joint for one in turns], expected)
    if not expected:
        return rows
    what = f"velocity on impedance ({len(turns)} joints)"
    pushed = f"{what}: 20 N while moving, deflection over K^-1 J' F"
    least, most = _least(one.push_ratio for one in turns), _most(one.push_ratio for one in turns)
    stop_deg = float(np.degrees(_most(one.stop_error_rad for one in turns)))
    lag_ms = _most(one.lag_s for one in turns) * 1e3
    return [
        *rows,
        _shown(f"{what}: behind the reference, largest", lag_ms, "ms"),
        at_most(f"{what}: error 1 s after a stop, largest", stop_deg, "deg", STOP_DEG),
        within(f"{pushed}, smallest", least, "", RATIO_LOW, RATIO_HIGH),
        within(f"{pushed}, largest", most, "", RATIO_LOW, RATIO_HIGH),
    ]


def _measured(what: str, names: Sequence[str], expected: Sequence[str]) -> list[Row]:
    if not expected and not names:
        return []
    count = len(expected)
    return [Row(what, len(names), "", f"all {count}", sorted(names) == sorted(expected))]


def _shown(name: str, value: float, unit: str) -> Row:
    """A figure without a bar: it must only be a number."""
    return Row(name, value, unit, "", None) if math.isfinite(value) else _no_number(name, unit)


def _no_number(name: str, unit: str) -> Row:
    return Row(name, math.nan, unit, "a number", holds=False)


def _most(values: Iterable[float]) -> float:
    """The largest; NaN of nothing, and where one is NaN: `max()` would drop it."""
    return float(np.max([*values] or [math.nan]))


def _least(values: Iterable[float]) -> float:
    return float(np.min([*values] or [math.nan]))
