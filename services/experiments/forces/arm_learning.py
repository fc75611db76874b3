"""What there is to learn of the recorded right arm: its wrench, beside what rigid bodies make.

The recording icubdyn has four joints (three of the shoulder, and the elbow) of an arm of the first
mechanical generation; its model is iCubLisboa01 with the base upright and all other joints at zero.
"""

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from dforc.arrays import Matrix, Vector, constant
from dforc.learning.feature_ridge import FeatureRidge, Kernel, fit_kernels, fit_noise
from dforc.learning.semi_parametric import RigidParameters, SemiParametric
from dforc.robot_model import RobotModel
from services.experiments.forces import icubdyn
from services.robotfile.model_file import urdf_path

URDF, SENSOR_FRAME, TIP = "iCubLisboa01", "r_arm_ft_sensor", "r_hand"
# How far a body may be from its drawing: kg, kg m, kg m2; then the offsets' size in N and Nm.
MASS_SPREAD, LEVER_SPREAD, INERTIA_SPREAD = 1.0, 0.1, 0.02
OFFSET_SPREAD = (50.0, 50.0, 50.0, 5.0, 5.0, 5.0)
MODEL_NOISE = (0.6, 0.6, 0.4, 0.06, 0.06, 0.05)  # what a rigid body leaves over, N and Nm
NEVER = 1 << 60


@dataclass(frozen=True, slots=True, eq=False)
class Rows:
    """One table of the recording."""

    x: Matrix  # (rows, 12): angles, velocities, accelerations
    y: Matrix  # (rows, 6): the sensor's reading
    regressors: Matrix  # (rows, 6, 26): two bodies, then an offset for each channel

    def __len__(self) -> int:
        return len(self.x)


@dataclass(frozen=True, slots=True, eq=False)
class ArmTask:
    """The three tables, with the parameters of the drawing; offsets are zero in it."""

    hyper: Rows
    train: Rows
    test: Rows
    drawing: Vector  # (26,)

    def error(self, errors: Matrix) -> float:
        """Mean square over variance of the whole test (nMSE), averaged over the six channels."""
        return float(((errors**2).mean(0) / self.test.y.var(0)).mean())

    def curve(self, errors: Matrix) -> Vector:
        """The same over the first 1, 2, ... rows."""
        counts = np.arange(1, len(errors) + 1)[:, None]
        averages: Vector = (np.cumsum(errors**2, 0) / counts / self.test.y.var(0)).mean(1)
        return averages


def load_task(data: Path | None = None) -> ArmTask:
    """The recording with the model's regressors.

    Raises:
        ConfigError: the recording is not there.
    """
    recording = icubdyn.load(data)
    model = RobotModel(str(urdf_path(URDF)), icubdyn.JOINTS, TIP, {"arm": SENSOR_FRAME})

    def rows(samples: icubdyn.Samples) -> Rows:
        states = zip(samples.q_rad, samples.dq_rad_s, samples.ddq_rad_s2, strict=True)
        bodies = np.array([model.sensor_regressor(*state, "arm") for state in states])
        offsets = np.broadcast_to(np.eye(6), (len(samples), 6, 6))
        return Rows(samples.inputs, samples.wrenches, np.concatenate([bodies, offsets], axis=2))

    drawing = constant(np.r_[model.inertial_parameters("arm"), np.zeros(6)])
    return ArmTask(rows(recording.hyper), rows(recording.train), rows(recording.test), drawing)


def drawing_errors(task: ArmTask) -> Matrix:
    """Errors over the test of the drawing and a constant offset, from the training rows."""
    offset = (task.train.y - task.train.regressors @ task.drawing).mean(0)
    errors: Matrix = task.test.y - task.test.regressors @ task.drawing - offset
    return errors


def identified(task: ArmTask) -> RigidParameters:
    """Parameters of both bodies and offsets by least squares on the training rows."""
    body = [MASS_SPREAD] + [LEVER_SPREAD] * 3 + [INERTIA_SPREAD] * 6
    spread = np.array(body * 2 + list(OFFSET_SPREAD))
    rigid = RigidParameters(task.drawing, spread, MODEL_NOISE)
    rigid.add(task.train.regressors, task.train.y)
    rigid.solve()
    return rigid


def kernels_of(task: ArmTask) -> tuple[Kernel, ...]:
    """A kernel for the forces and one for the moments, by the 500 rows set aside for it."""
    return fit_kernels(task.hyper.x, task.hyper.y)


def rest_kernels(
    task: ArmTask, rigid: RigidParameters, kernels: tuple[Kernel, ...]
) -> tuple[Kernel, ...]:
    """The same kernels for what the rigid bodies leave over, with the noise of that."""
    rest = task.hyper.y - task.hyper.regressors @ rigid.theta
    return fit_noise(task.hyper.x, rest, kernels)


def predict_then_update(
    predict: Callable[[int], Vector],
    update: Callable[[int], object],
    y: Matrix,
    late: int = 0,
    last: int = NEVER,
) -> Matrix:
    """Errors of a learner that is shown the truth of row i after its guess of row i + late.

    Args:
        predict: the guess of a row.
        update: learns a row.
        y: the truth.
        late: how many rows the labels are late.
        last: no row from here on is learned.
    """
    errors = np.empty_like(y)
    for i in range(len(y)):
        errors[i] = y[i] - predict(i)
        if 0 <= i - late < last:
            update(i - late)
    return errors


def features_run(task: ArmTask, learner: FeatureRidge, late: int = 0) -> Matrix:
    """Errors over the test of a learner that has seen the training rows."""
    learner.fit(task.train.x, task.train.y)
    return features_only(task, learner, late)


def features_only(
    task: ArmTask, learner: FeatureRidge, late: int = 0, y: Matrix | None = None
) -> Matrix:
    """The same of a learner as it is; `y` in the place of the wrenches of the test."""
    x = task.test.x
    y = task.test.y if y is None else y
    return predict_then_update(
        lambda i: learner.predict(x[i]), lambda i: learner.update(x[i], y[i]), y, late
    )


def semi_parametric_run(
    task: ArmTask, learner: SemiParametric, late: int = 0, last: int = NEVER
) -> Matrix:
    """The same for the form with rigid bodies."""
    x, y, regressors = task.test.x, task.test.y, task.test.regressors
    learner.fit(task.train.x, task.train.regressors, task.train.y)
    return predict_then_update(
        lambda i: learner.predict(x[i], regressors[i]),
        lambda i: learner.update(x[i], regressors[i], y[i]),
        y,
        late,
        last,
    )
