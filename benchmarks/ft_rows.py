"""Force/torque signals on the model of the iCub: phantom forces, offsets, gain matrices."""

import tempfile
import xml.etree.ElementTree as ElementTree
from collections.abc import Callable
from pathlib import Path

import icub_models
import numpy as np

from benchmarks.derivative_peers import PERIOD_S, REPRODUCED, AdaptiveWindow, NullJerkKalman
from benchmarks.derivative_rows import Ours, counted
from dforc.arrays import Matrix, Vector
from dforc.robot_model import RobotModel
from dforc.signals.delay_match import DELAY_S, MatchedMotion
from dforc.signals.differentiation import Differentiator, JointMotion
from dforc.signals.ft_channel import FtChannel
from dforc.signals.identification import NOISE, GainFit, identify_gain
from dforc.signals.offsets import OffsetCalibration
from services.experiments.rows import Row, at_most

URDF = "iCubLisboa01"
ARM = tuple(f"r_{name}" for name in ("shoulder_pitch", "shoulder_roll", "shoulder_yaw", "elbow"))
ARM = (*ARM, "r_wrist_prosup", "r_wrist_pitch", "r_wrist_yaw")
LEG = ("l_hip_pitch", "l_hip_roll", "l_hip_yaw", "l_knee", "l_ankle_pitch", "l_ankle_roll")
SENSOR = "ft"
MIDDLE_DEG = np.array([-40.0, 45.0, 20.0, 60.0, 0.0, -20.0, 0.0])
SWING_DEG = np.array([15.0, 5.0, 8.0, 20.0, 10.0, 5.0, 3.0])
LOW_PASS_HZ = 3.0  # first order, as shipped for the sensors


def arm_model(urdf: str | None = None) -> RobotModel:
    """Right arm with its sensor."""
    return _model(urdf, ARM, "r_hand_dh_frame", "r_arm_ft_sensor")


def leg_model(urdf: str | None = None) -> RobotModel:
    """Left leg with the sensor in its thigh."""
    return _model(urdf, LEG, "l_foot", "l_leg_ft_sensor")


def _model(urdf: str | None, joints: tuple[str, ...], tip: str, sensor: str) -> RobotModel:
    path = urdf or str(icub_models.get_model_file(URDF))
    return RobotModel(path, joints, tip, {SENSOR: sensor})


def reading(model: RobotModel, motion: JointMotion) -> Vector:
    """What the sensor shows, or should."""
    return model.sensor_wrench(*motion, SENSOR)


def swing(t: Matrix, frequency_hz: float, share: float = 1.0) -> list[JointMotion]:
    """The arm swings about its middle posture, every joint with a phase of its own."""
    w, amplitude = 2.0 * np.pi * frequency_hz, np.radians(SWING_DEG) * share
    angle = w * t[:, None] + np.arange(len(ARM))
    q = np.radians(MIDDLE_DEG) + amplitude * np.sin(angle)
    dq, ddq = amplitude * w * np.cos(angle), -amplitude * w * w * np.sin(angle)
    return [JointMotion(*motion) for motion in zip(q, dq, ddq, strict=True)]


def phantom_forces_n(frequency_hz: float = 1.0, seconds: float = 6.0) -> dict[str, float]:
    """Root mean square of the force that seems to push the arm, by chain of filters."""
    model, rng = arm_model(), np.random.default_rng(8)
    t = np.arange(0.0, seconds, PERIOD_S)
    truth = swing(t, frequency_hz)
    q = counted(np.array([motion.q_rad for motion in truth]))
    clean = np.array([reading(model, motion) for motion in truth])
    raw = clean + rng.normal(size=clean.shape) * np.array(NOISE)
    kept = np.exp(-2.0 * np.pi * LOW_PASS_HZ * PERIOD_S)
    slow = raw[0].copy()
    matched, live, channel = MatchedMotion(len(ARM)), Ours(len(ARM)), FtChannel()
    window, kalman = AdaptiveWindow(len(ARM)), NullJerkKalman(len(ARM), REPRODUCED)
    squares: dict[str, list[float]] = {}
    for tick, at_s in enumerate(t.tolist()):
        matched.push(q[tick], at_s)
        channel.push(raw[tick], at_s)
        slow = kept * slow + (1.0 - kept) * raw[tick]
        late = matched.motion(at_s)
        pairs = {
            "matched": (channel.filtered(at_s), late),
            "unmatched: force as it comes": (raw[tick], late),
            "unmatched: force through 3 Hz": (slow, late),
            "force as it comes, differentiator": (
                raw[tick],
                JointMotion(q[tick], *live.add(q[tick])),
            ),
            "force through 3 Hz, adaptive window": (
                slow,
                JointMotion(q[tick], *window.add(q[tick])),
            ),
            "force through 3 Hz, null-jerk Kalman": (
                slow,
                JointMotion(q[tick], *kalman.add(q[tick])),
            ),
        }
        for name, (wrench, motion) in pairs.items():
            excess = (wrench - reading(model, motion))[:3]
            if at_s > 2.0:
                squares.setdefault(name, []).append(float(excess @ excess))
    return {name: float(np.sqrt(np.mean(values))) for name, values in squares.items()}


def live_phantom_force_n(seconds: float = 4.0) -> float:
    """The matched chain as it runs live: joints at uneven 125 Hz, forces at 1 kHz, read at 100."""
    model, rng = arm_model(), np.random.default_rng(8)
    matched, channel = MatchedMotion(len(ARM)), FtChannel()
    late_s = 0.003 * rng.uniform(size=int(1000 * seconds))
    squares = []
    for tick, truth in enumerate(swing(np.arange(0.0, seconds, 0.001), 1.0)):
        at_s = tick * 0.001
        raw = reading(model, truth) + rng.normal(size=6) * np.array(NOISE)
        channel.push(raw, at_s)
        if tick % 8 == 0:
            moment_s = at_s + float(late_s[tick])  # sampled a little later, and stamped so
            matched.push(counted(swing(np.array([moment_s]), 1.0)[0].q_rad), moment_s)
        if tick % 10 == 9 and at_s > 2.0:
            excess = channel.filtered(at_s) - reading(model, matched.motion(at_s))
            squares.append(float(excess[:3] @ excess[:3]))
    return float(np.sqrt(np.mean(squares)))


def phantom_rows() -> list[Row]:
    """At least halved against every unmatched chain."""
    found = phantom_forces_n()
    least = min(force for name, force in found.items() if name != "matched")
    name = "phantom force, arm swings at 1 Hz"
    return [
        at_most(f"{name}: matched, {1e3 * DELAY_S:g} ms late", found["matched"], "N", least / 2.0),
        at_most(
            f"{name}: matched, joints at uneven 125 Hz, forces at 1 kHz",
            live_phantom_force_n(),
            "N",
            least / 2.0,
        ),
        *(Row(f"{name}: {k}", force, "N") for k, force in found.items() if k != "matched"),
    ]


def offset_errors_n(runs: int) -> tuple[list[float], list[float], float]:
    """Errors of offsets taken in a slow motion: per sample, predicted once; and the spread."""
    model, errors, once, spreads = arm_model(), [], [], []
    for seed in range(runs):
        rng = np.random.default_rng(seed)
        true = rng.normal(size=6) * np.array([10.0] * 3 + [0.5] * 3)
        start_s = rng.uniform(0.0, 10.0)
        t = np.linspace(start_s, start_s + 200 * PERIOD_S, 200, endpoint=False)
        truth = swing(t, 0.1)  # up to 0.22 rad/s
        joints, calibration = Differentiator(len(ARM)), OffsetCalibration(100)
        predicted, sums = np.zeros(6), np.zeros(6)
        for tick, (at_s, motion) in enumerate(zip(t.tolist(), truth, strict=True)):
            measured = reading(model, motion) + true + rng.normal(size=6) * np.array(NOISE)
            seen = joints.add(counted(motion.q_rad), at_s)
            if tick < 100:
                continue
            predicted = reading(model, seen)
            calibration.add(measured, predicted)
            sums += measured
        errors.append(float(np.abs(calibration.offset - true)[:3].max()))
        once.append(float(np.abs(sums / calibration.count - predicted - true)[:3].max()))
        spreads.append(float(calibration.spread[:3].max()))
    return errors, once, max(spreads)


def offset_rows(short: bool) -> list[Row]:
    """100 samples at 0.05 N noise while the arm moves slowly."""
    runs = 20 if short else 200
    errors, once, spread = offset_errors_n(runs)
    name = f"offset error, 100 samples in slow motion, {runs} runs"
    return [
        at_most(f"{name}: worst axis of the worst run", max(errors), "N", 0.02),
        Row(f"{name}: median of the worst axis", float(np.median(errors)), "N"),
        Row(f"{name}: worst, model value of the last sample for all", max(once), "N"),
        Row("spread of the samples, worst axis of the worst run", spread, "N"),
    ]


def sweep(model: RobotModel, seed: int, *, seconds: float = 60.0, rate_hz: float = 25.0) -> Matrix:
    """Angles (k, n) of a slow sweep through 90 % of the joints' ranges."""
    rng = np.random.default_rng(seed)
    t = np.arange(0.0, seconds, 1.0 / rate_hz)[:, None]
    middle, half = (
        (model.lower_rad + model.upper_rad) / 2.0,
        (model.upper_rad - model.lower_rad) / 2,
    )
    w = 2.0 * np.pi * rng.uniform(0.02, 0.06, (2, model.n))
    phase = rng.uniform(0.0, 2.0 * np.pi, (2, model.n))
    q: Matrix = middle + 0.9 * half * (
        0.6 * np.sin(w[0] * t + phase[0]) + 0.4 * np.sin(w[1] * t + phase[1])
    )
    return q


def wrenches_at_rest(model: RobotModel, q_rad: Matrix) -> Matrix:
    """Model's wrenches (k, 6)."""
    still = np.zeros(model.n)
    return np.array([reading(model, JointMotion(q, still, still)) for q in q_rad])


def secondary_matrix(rng: np.random.Generator) -> Matrix:
    """A made matrix with the size of Lisboa01's left leg: gains 0.60 and 0.69, strong coupling."""
    C = np.diag([0.60, 0.69, 0.90, 0.80, 0.75, 1.10])
    C[:3, :3] += rng.uniform(-0.1, 0.1, (3, 3)) * (1.0 - np.eye(3))
    C[3:, 3:] += rng.uniform(-0.1, 0.1, (3, 3)) * (1.0 - np.eye(3))
    C[:3, 3:] = rng.uniform(-3.0, 3.0, (3, 3))  # N per Nm
    C[3:, :3] = rng.uniform(-0.03, 0.03, (3, 3))  # Nm per N
    return C


def gain_error(found: Matrix, true: Matrix) -> float:
    """Largest entry of found / true - 1, forces in units of 20 N and moments in units of 2 Nm."""
    unit = np.array([20.0] * 3 + [2.0] * 3)
    return float(np.abs((found @ np.linalg.inv(true) - np.eye(6)) * unit / unit[:, None]).max())


def identified(
    make: Callable[[str | None], RobotModel], seed: int, urdf: str | None = None
) -> tuple[Matrix, GainFit]:
    """The sensor's true matrix and what a sweep finds; `urdf` is the estimator's model."""
    plant, model, rng = make(None), make(urdf), np.random.default_rng(seed)
    C, offset = secondary_matrix(rng), rng.normal(size=6) * np.array([20.0] * 3 + [1.0] * 3)
    q = sweep(plant, seed)
    raw = wrenches_at_rest(plant, q) @ np.linalg.inv(C).T + offset
    raw += rng.normal(size=raw.shape) * np.array(NOISE)
    return C, identify_gain(raw, wrenches_at_rest(model, counted(q)))


def gain_rows(short: bool) -> list[Row]:
    """A gain error of 40 % and more, before and after; then with a model that is wrong."""
    rows: list[Row] = []
    seeds = range(2 if short else 10)
    for limb, make in (("leg", leg_model), ("arm", arm_model)):
        pairs = [identified(make, seed) for seed in seeds]
        before = [gain_error(np.eye(6), C) for C, _ in pairs]
        after = [gain_error(fit.matrix, C) for C, fit in pairs]
        fits = [fit for _, fit in pairs]
        name = f"gain error, sweep of the {limb}, {len(seeds)} sensors"
        rows += [
            Row(f"{name}: smallest before", min(before), "relative"),
            at_most(f"{name}: largest after", max(after), "relative", 0.02),
            Row(f"{name}: rank, smallest", float(min(fit.rank for fit in fits))),
            Row(f"{name}: condition, largest", max(fit.condition for fit in fits)),
            Row(f"{name}: force residual before", _force(fits[0].residual_before), "N"),
            Row(f"{name}: force residual after", _force(fits[0].residual), "N"),
        ]
        with tempfile.TemporaryDirectory() as folder:
            wrong = wrong_model(Path(folder), np.random.default_rng(1))
            pairs = [identified(make, seed, wrong) for seed in seeds]
        after = [gain_error(fit.matrix, C) for C, fit in pairs]
        name += ", masses 5 % and centres 5 mm off"
        rows.append(Row(f"{name}: largest after", max(after), "relative"))
        rows.append(Row(f"{name}: force residual after", _force(pairs[0][1].residual), "N"))
    return rows


def _force(wrench: Vector) -> float:
    return float(np.linalg.norm(wrench[:3]))


def wrong_model(folder: Path, rng: np.random.Generator) -> str:
    """A copy of the model with every mass up to 5 % and every centre of mass up to 5 mm off."""
    tree = ElementTree.parse(str(icub_models.get_model_file(URDF)))
    for inertial in tree.getroot().iter("inertial"):
        mass, origin = inertial.find("mass"), inertial.find("origin")
        if mass is None or origin is None:
            continue
        mass.set("value", str(float(mass.get("value", "0")) * rng.uniform(0.95, 1.05)))
        centre = np.array(origin.get("xyz", "0 0 0").split(), dtype=float)
        origin.set("xyz", " ".join(map(str, centre + rng.uniform(-0.005, 0.005, 3))))
    path = folder / "wrong.urdf"
    tree.write(path)
    return str(path)
