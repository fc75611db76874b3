"""Work on FT sensors that takes time: finding offsets, and gain matrices from a pose sweep.

Calibration runs on the unfiltered readings at their full rate and ends by itself; a sweep collects
filtered readings until it is told to stop (pose_sweeps.py). Neither stops anything else: the old
offset and gain hold until the new ones are complete, and sensors that are not named are not
touched.
"""

from collections.abc import Callable, Sequence

from dforc.arrays import Matrix, Vector
from dforc.signals.offsets import Calibrations
from services.wholebody.body import BodySensor
from services.wholebody.pose_sweeps import PoseSweeps, TaskRefusedError
from services.wholebody.sensor_bank import SensorBank

SLOW_RAD_S = 0.35  # the accelerations of slower motion weigh less than a sensor's noise
SILENT_NS = 500_000_000  # without a good reading, and a calibration is given up
PATIENCE_NS = 10_000_000_000  # with readings, but none of use
MOST_SAMPLES = 100_000
MOST_SPREAD_N = 3.0  # of the samples: more than slow motion and noise can be
MOST_SPREAD_NM = 0.3
TOUCHED = "something touches the limb"  # so says a refusal that may pass by itself


class SensorTasks:
    """Calibrations and sweeps of one robot's sensors."""

    def __init__(self, sensors: tuple[BodySensor, ...], bank: SensorBank) -> None:
        self._bank = bank
        self._names = tuple(sensor.name for sensor in sensors)
        self._calibrations = Calibrations(self._names)
        self._heard_ns = [0] * len(sensors)  # of a calibration's last good reading
        self._useful_ns = [0] * len(sensors)  # of the last that was of use
        self._why = [""] * len(sensors)  # readings are of no use
        self._sweeps = PoseSweeps(sensors, bank)
        self.outcome = dict.fromkeys(self._names, "")  # of each sensor's last task

    @property
    def is_calibrating(self) -> bool:
        """Whether the offset of some sensor is being looked for."""
        return bool(self._calibrations.running)

    @property
    def is_sweeping(self) -> bool:
        """Whether some sensor collects a pose sweep."""
        return bool(self._sweeps)

    def chosen(self, names: Sequence[str]) -> tuple[int, ...]:
        """The sensors of that name; all where none is named.

        Raises:
            TaskRefusedError: there is no such sensor.
        """
        for name in names:
            if name not in self._names:
                known = ", ".join(self._names)
                raise TaskRefusedError(f"no sensor {name!r} here; there is {known}")
        return tuple(i for i, name in enumerate(self._names) if not names or name in names)

    def calibrate(
        self,
        names: Sequence[str],
        samples: int,
        now_ns: int,
        trouble_around: Callable[[int], str],
        is_touched: Callable[[int], bool],
    ) -> None:
        """Begin to look for offsets.

        Args:
            names: sensors; none = all.
            samples: readings to average.
            now_ns: when it begins.
            trouble_around: why the joints around a sensor are not known; empty = they are.
            is_touched: whether something touches the limb beyond it.

        Raises:
            TaskRefusedError: nothing was begun.
        """
        chosen = self.chosen(names)
        if not 1 <= samples <= MOST_SAMPLES:
            raise TaskRefusedError(f"samples must be 1..{MOST_SAMPLES}, not {samples}")
        for i in chosen:
            name, trouble = self._names[i], trouble_around(i)
            if trouble:
                raise TaskRefusedError(f"{name}: {trouble}; `ulna joints calibrate` first")
            if not self._bank.is_heard(i):
                flags = [flag for flag in self._bank.flags(i) if flag != "uncalibrated"]
                seek = "; see `ulna can scan`" if {"missing", "late"} & set(flags) else ""
                raise TaskRefusedError(f"{name} gives no good readings ({', '.join(flags)}){seek}")
            self._refuse_touch(i, is_touched)
        self._calibrations.start([self._names[i] for i in chosen], samples)
        for i in chosen:
            self._heard_ns[i] = self._useful_ns[i] = now_ns
            self._why[i] = ""
            self.outcome[self._names[i]] = ""

    def add_readings(
        self,
        now_ns: int,
        internal: Matrix,
        fastest_rad_s: float,
        heard: tuple[bool, ...],
        is_touched: Callable[[int], bool],
    ) -> None:
        """A step's new readings, with what the model says of them.

        `heard` says of which sensors the joints around them are known.
        """
        for i, name in enumerate(self._names):
            running = self._calibrations.progress(name)
            if running is None:
                continue
            useful = self._bank.new[i] and heard[i] and fastest_rad_s <= SLOW_RAD_S
            if self._bank.valid[i] and is_touched(i):
                self._give_up(name, TOUCHED)
            elif useful:
                self._useful_ns[i] = now_ns
                measured = self._bank.without_offset(i)
                if self._calibrations.add(name, measured, internal[i]) is not None:
                    self._finish(i, name, running.offset, running.spread)
            elif not heard[i]:
                self._why[i] = "the joints around it are not known"
            elif fastest_rad_s > SLOW_RAD_S:
                self._why[i] = (
                    f"a joint moves at {fastest_rad_s:.2f} rad/s, at most {SLOW_RAD_S} is slow "
                    f"enough"
                )

    def look(self, now_ns: int, trouble_around: Callable[[int], str]) -> None:
        """Once per step, with readings or without: give up calibrations that get nowhere."""
        for i, name in enumerate(self._names):
            if self._calibrations.progress(name) is None:
                continue
            if self._bank.new[i]:
                self._heard_ns[i] = now_ns
            if now_ns - self._heard_ns[i] > SILENT_NS:
                flags = ", ".join(self._bank.flags(i))
                self._give_up(name, f"no good readings for {SILENT_NS / 1e9} s ({flags})")
            elif now_ns - self._useful_ns[i] > PATIENCE_NS:
                self._give_up(name, trouble_around(i) or self._why[i])

    def sweep(self, names: Sequence[str], is_touched: Callable[[int], bool]) -> None:
        """Begin to collect poses, anew where that goes on already.

        Raises:
            TaskRefusedError: something touches a limb; nothing was begun.
        """
        chosen = self.chosen(names)
        for i in chosen:
            self._refuse_touch(i, is_touched)
        for i in chosen:
            self._sweeps.start(i)
            self.outcome[self._names[i]] = ""

    def add_pose(
        self,
        internal: Matrix,
        now_s: float,
        heard: tuple[bool, ...],
        fastest_rad_s: float,
        is_touched: Callable[[int], bool],
    ) -> None:
        """A filtered sample, with what the model says of it.

        `heard` says of which sensors the joints around them are known.
        """
        self._sweeps.add(internal, now_s, heard, fastest_rad_s, is_touched)

    def solve(self, names: Sequence[str]) -> str:
        """Gain and offset of the sensors from their sweeps, in use from now on; a summary.

        A calibration of such a sensor ends: its samples are of the old gain.

        Raises:
            TaskRefusedError: no sweep, or one that is not to be believed; it goes on.
        """
        chosen = [i for i in self.chosen(names) if i in self._sweeps or names]
        fits = [(i, self._sweeps.fit(i)) for i in chosen]
        if not fits:
            raise TaskRefusedError("no sweep is under way; start one first")
        for i, fit in fits:
            self._calibrations.cancel(self._names[i])
            self.outcome[self._names[i]] = self._sweeps.summary(i, fit)
            self._sweeps.end(i)
            self._bank.set_gain(i, fit.matrix)
            self._bank.set_offset(i, fit.offset)
        return "; ".join(f"{self._names[i]}: {self.outcome[self._names[i]]}" for i, _ in fits)

    def discard(self, names: Sequence[str]) -> None:
        """Forget the sweeps."""
        for i in self.chosen(names):
            self._sweeps.end(i)

    def reset(self, names: Sequence[str]) -> None:
        """Forget offsets and found gains, and end what is under way."""
        for i in self.chosen(names):
            self._calibrations.cancel(self._names[i])
            self._sweeps.end(i)
            self._bank.forget(i)
            self.outcome[self._names[i]] = ""

    def progress(self, sensor: int) -> tuple[str, int, int]:
        """Task of a sensor, and its samples: those taken, and those wanted (0 = open)."""
        running = self._calibrations.progress(self._names[sensor])
        if running is not None:
            return "calibrating", running.count, running.wanted
        if sensor in self._sweeps:
            return "identifying", self._sweeps.count(sensor), 0
        return "", 0, 0

    def _refuse_touch(self, sensor: int, is_touched: Callable[[int], bool]) -> None:
        if self._bank.valid[sensor] and is_touched(sensor):
            raise TaskRefusedError(
                f"{self._names[sensor]}: {TOUCHED}; free it, or, if nothing does, reset the sensor "
                f"first"
            )

    def _finish(self, sensor: int, name: str, offset: Vector, spread: Vector) -> None:
        force, moment = float(spread[:3].max()), float(spread[3:].max())
        if force > MOST_SPREAD_N or moment > MOST_SPREAD_NM:
            self._give_up(name, f"readings differ by {force:.1f} N, {moment:.2f} Nm: touched?")
        else:
            self._bank.set_offset(sensor, offset)

    def _give_up(self, name: str, reason: str) -> None:
        self._calibrations.cancel(name)
        self.outcome[name] = f"calibration given up: {reason}"
