"""What the trials of the closed loops come to, as figures with bars."""

from collections.abc import Iterable, Sequence

import numpy as np

from services.experiments.loop_guiding import Guiding
from services.experiments.loop_impedance import Deflection
from services.experiments.loop_torque import TorqueStep
from services.experiments.loop_velocity import Turn
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


def step_rows(steps: Sequence[TorqueStep]) -> list[Row]:
    """Torque control, by kind of joint: the worst of each."""
    rows = []
    for group, names in GROUPS:
        chosen = [step for step in steps if any(name in step.joint for name in names)]
        if not chosen:
            continue
        what = f"torque step, {group} ({len(chosen)} joints)"
        rise_ms = max(step.rise_s for step in chosen) * 1e3
        rows += [
            Row(f"{what}: rise, longest", rise_ms, "ms"),
            at_most(
                f"{what}: overshoot, largest", _most(s.overshoot for s in chosen), "", OVERSHOOT
            ),
            at_most(
                f"{what}: steady error, largest", _most(s.steady_error for s in chosen), "", STEADY
            ),
            Row(f"{what}: ripple, largest", _most(s.ripple_nm for s in chosen), "Nm"),
        ]
    return rows


def deflection_rows(deflections: Sequence[Deflection]) -> list[Row]:
    """Pushes of 20 N, by place."""
    rows = []
    for place in dict.fromkeys(one.place for one in deflections):
        chosen = [one for one in deflections if one.place == place]
        what = f"20 N at the {place} ({len(chosen)} pushes): deflection over K^-1 J' F"
        for word, ratio in (
            ("smallest", min(one.ratio for one in chosen)),
            ("largest", max(one.ratio for one in chosen)),
        ):
            rows.append(within(f"{what}, {word}", ratio, "", RATIO_LOW, RATIO_HIGH))
        size_mm = np.median([np.linalg.norm(one.predicted_m) for one in chosen]) * 1e3
        rows.append(Row(f"20 N at the {place}: deflection, median", float(size_mm), "mm"))
        back_mm = _most(one.back_m for one in chosen) * 1e3
        rows.append(at_most(f"20 N at the {place}: not come back, largest", back_mm, "mm", BACK_MM))
    if deflections:
        rest = float(np.degrees(_most(one.rest_rad_s for one in deflections)))
        rows.append(at_most("compliant joints at rest: speed, largest", rest, "deg/s", REST_DEG_S))
    return rows


def guiding_rows(guidings: Sequence[Guiding]) -> list[Row]:
    """No stiffness, gravity held."""
    rows = []
    for kind in ("arm", "leg"):
        chosen = [one for one in guidings if kind in one.limb]
        if chosen:
            drift = float(np.degrees(_most(one.drift_rad for one in chosen)))
            force = _most(one.force_n for one in chosen)
            left_mm = _most(one.left_m for one in chosen) * 1e3
            rows += [
                at_most(f"guiding, {kind}s: drift untouched, largest", drift, "deg", DRIFT_DEG),
                at_most(f"guiding, {kind}s: force at 0.1 m/s, largest", force, "N", LED_N),
                at_most(f"guiding, {kind}s: moves on once let go, largest", left_mm, "mm", LEFT_MM),
            ]
    return rows


def turn_rows(turns: Sequence[Turn]) -> list[Row]:
    """Velocity on top of impedance."""
    if not turns:
        return []
    what = f"velocity on impedance ({len(turns)} joints)"
    ratios = [one.push_ratio for one in turns]
    stop_deg = float(np.degrees(_most(one.stop_error_rad for one in turns)))
    return [
        Row(f"{what}: behind the reference, largest", _most(t.lag_s for t in turns) * 1e3, "ms"),
        at_most(f"{what}: error 1 s after a stop, largest", stop_deg, "deg", STOP_DEG),
        within(
            f"{what}: 20 N while moving, deflection over K^-1 J' F, smallest",
            *(min(ratios), "", RATIO_LOW, RATIO_HIGH),
        ),
        within(
            f"{what}: 20 N while moving, deflection over K^-1 J' F, largest",
            *(max(ratios), "", RATIO_LOW, RATIO_HIGH),
        ),
    ]


def _most(values: Iterable[float]) -> float:
    return max(values)
