"""Pose sweeps of FT sensors: which samples count, and which gain matrix is believed.

A sample counts while the joints around the sensor are heard and slow, no touch precedes or follows
it within `HELD` looks, and no look before it came late: joints and readings that have waited for a
busy machine are filtered as if they were of when they came, each by another error. Touch is known
only of a sensor whose offset is. A gain is believed if it leaves little unexplained and changes no
wrench by more than the factor `MOST_GAIN`.
"""

import math
from collections.abc import Callable

import numpy as np

from dforc.arrays import Matrix, Vector
from dforc.errors import DforcError
from dforc.signals.identification import NOISE, GainFit, identify_gain
from services.core.errors import ServiceError
from services.wholebody.body import BodySensor
from services.wholebody.sensor_bank import SensorBank

MOST_SAMPLES = 20_000  # more than three minutes
FEWEST_DIRECTIONS = 4  # of six that a sweep has to excite
HELD = 15  # looks: a step of force is past the filter
LATE_S = 0.015  # after the look before; one is due each 10 ms, and comes with the next reading
FAST_RAD_S = 2.0  # what the filter leaves of faster swings is not one and the same for all signals
MOST_LEFT_N, MOST_LEFT_NM = 0.5, 0.05  # that a gain may leave unexplained in any case
MOST_LEFT_SHARE = 0.5  # of what was unexplained before, where that is more
MOST_GAIN = 2.0  # and 1 / 2 at least, in units of the sensor's noise


class TaskRefusedError(ServiceError):
    """The sensors cannot be worked on now; the text says why and what to do."""


class _Sweep:
    """Samples of one sensor: readings before gain and offset, and what the model says."""

    __slots__ = ("left_out", "quiet", "samples")

    def __init__(self) -> None:
        self.samples: list[tuple[Vector, Vector]] = []
        self.left_out = 0  # in touch, fast, late or not heard
        self.quiet = 0  # looks since the last touch or late look; negative until samples count


class PoseSweeps:
    """Those that are under way, by sensor."""

    def __init__(self, sensors: tuple[BodySensor, ...], bank: SensorBank) -> None:
        self._names = tuple(sensor.name for sensor in sensors)
        self._bank = bank
        self._sweeps: dict[int, _Sweep] = {}
        self._looked_s = math.inf  # the first look is not late

    def __bool__(self) -> bool:
        return bool(self._sweeps)

    def __contains__(self, sensor: int) -> bool:
        return sensor in self._sweeps

    def count(self, sensor: int) -> int:
        """Samples that were taken."""
        return len(self._sweeps[sensor].samples)

    def start(self, sensor: int) -> None:
        """Begin, anew where one is under way."""
        self._sweeps[sensor] = _Sweep()

    def end(self, sensor: int) -> None:
        """Forget a sweep, if there is one."""
        self._sweeps.pop(sensor, None)

    def add(
        self,
        internal: Matrix,
        now_s: float,
        heard: tuple[bool, ...],
        fastest_rad_s: float,
        is_touched: Callable[[int], bool],
    ) -> None:
        """A filtered look, with what the model says of it.

        `heard` says of which sensors the joints around them are known.
        """
        is_late, self._looked_s = now_s - self._looked_s > LATE_S, now_s
        for i, sweep in self._sweeps.items():
            if self._bank.valid[i] and is_touched(i):
                if sweep.quiet >= 0:  # it has grown unnoticed
                    sweep.left_out += len(sweep.samples[-HELD:])
                    del sweep.samples[-HELD:]
                sweep.quiet = -HELD
            elif is_late:
                sweep.quiet = -HELD
            else:
                sweep.quiet = min(sweep.quiet + 1, 0)
            if not self._bank.is_filtered(i) or len(sweep.samples) >= MOST_SAMPLES:
                continue
            if sweep.quiet < 0 or not heard[i] or fastest_rad_s > FAST_RAD_S:
                sweep.left_out += 1
                continue
            channel = self._bank.channels[i]
            wrench = channel.filtered(now_s) + channel.offset
            raw: Vector = np.asarray(np.linalg.solve(channel.matrix, wrench), dtype=np.float64)
            sweep.samples.append((raw, internal[i].copy()))

    def fit(self, sensor: int) -> GainFit:
        """Gain and offset from a sweep.

        Raises:
            TaskRefusedError: no sweep, or one that cannot be believed; it goes on.
        """
        name, sweep = self._names[sensor], self._sweeps.get(sensor)
        if sweep is None:
            raise TaskRefusedError(f"{name}: no sweep is under way; start one first")
        try:
            raw = np.array([raw for raw, _ in sweep.samples]).reshape(-1, 6)
            fit = identify_gain(raw, np.array([p for _, p in sweep.samples]).reshape(-1, 6))
        except DforcError as error:
            left_out = f" ({sweep.left_out} in touch, fast or late)" if sweep.left_out else ""
            raise TaskRefusedError(f"{name}: {error}{left_out}; move the limb on") from error
        trouble = trouble_with(fit)
        if trouble:
            raise TaskRefusedError(f"{name}: {trouble}")
        return fit

    def summary(self, sensor: int, fit: GainFit) -> str:
        """What to say of a fit that is taken."""
        before, after = _size(fit.residual_before, 0), _size(fit.residual, 0)
        left_out = self._sweeps[sensor].left_out
        text = f"{fit.rank} of 6 directions, {before:.2f} N unexplained before, {after:.2f} N now"
        return text + (f", {left_out} samples in touch, fast or late left out" if left_out else "")


def trouble_with(fit: GainFit) -> str:
    """Why a gain is not to be believed; empty = it is."""
    if fit.rank < FEWEST_DIRECTIONS:
        return (
            f"the sweep shows {fit.rank} of 6 directions, {FEWEST_DIRECTIONS} are "
            f"needed; move the limb through more postures"
        )
    for first, unit, least in ((0, "N", MOST_LEFT_N), (3, "Nm", MOST_LEFT_NM)):
        before, after = _size(fit.residual_before, first), _size(fit.residual, first)
        most = max(least, MOST_LEFT_SHARE * before)
        if after > most:
            return (
                f"{after:.2f} {unit} would stay unexplained, at most {most:.2f} may "
                f"({before:.2f} before); the gain stays as it was: touched? move on, or start anew"
            )
    scale = np.array(NOISE)
    stretches = np.linalg.svd(fit.matrix / scale[:, None] * scale, compute_uv=False)
    if stretches[0] > MOST_GAIN or stretches[-1] < 1.0 / MOST_GAIN:
        return (
            f"the gain would stretch wrenches by {stretches[-1]:.2f} to {stretches[0]:.2f}, "
            f"{1.0 / MOST_GAIN} to {MOST_GAIN} are believed; it stays as it was: touched, or "
            f"moved too little? move on, or start anew"
        )
    return ""


def _size(residual: Vector, first: int) -> float:
    return float(np.linalg.norm(residual[first : first + 3]))
