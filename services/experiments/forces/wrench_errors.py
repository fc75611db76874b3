"""Measured minus predicted force/torque wrenches of one motion, as in the paper's Table 1."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from dforc.arrays import Matrix, Vector
from dforc.estimation.assumption import Assumption
from dforc.estimation.estimator import WholeBodyEstimator
from dforc.estimation.tree_model import TreeModel
from services.core.errors import ServiceError
from services.experiments.forces.icubdyn import JOINTS, Recording, Samples
from services.robotfile.model_file import urdf_path
from services.robotfile.robot_tables import RobotFile
from services.wholebody.dynamics_messages import DynamicsSamples

WHOLE_ROBOT = "icub"
COMPONENTS = ("fx", "fy", "fz", "mx", "my", "mz")
UNITS = ("N", "N", "N", "Nm", "Nm", "Nm")
RECORDED_FRAME = "r_arm_ft_sensor"


@dataclass(frozen=True, slots=True, eq=False)
class Comparison:
    """One sensor: what it read, less its offset, and what the model says. Both (rows, 6)."""

    measured: Matrix
    predicted: Matrix
    touched: int = 0  # rows in which the contact detector found a touch

    @property
    def errors(self) -> Matrix:
        """Measured minus predicted, (rows, 6)."""
        return self.measured - self.predicted

    @property
    def mean(self) -> Vector:
        """Of the errors, (6,)."""
        mean: Vector = self.errors.mean(axis=0)
        return mean

    @property
    def std(self) -> Vector:
        """Of the errors about their mean, (6,)."""
        std: Vector = self.errors.std(axis=0)
        return std

    @property
    def nmse(self) -> float:
        """Mean square error over the variance of what was measured; 1 is what a constant earns."""
        return nmse(self.predicted, self.measured)


def nmse(predicted: Matrix, measured: Matrix) -> float:
    """Mean square error over the variance of what was measured, averaged over the columns."""
    square: Vector = np.square(measured - predicted).mean(axis=0)
    return float((square / measured.var(axis=0)).mean())


def limbs(robot: RobotFile) -> dict[str, str]:
    """The paper's sensors, one in each arm and leg: sensor by the part that its board is in.

    A sensor in a foot, which the model itself has not got, is not among them.
    """
    return {
        robot.boards[sensor.board].part: name
        for name, sensor in robot.sensors.items()
        if not sensor.behind
    }


def of_samples(samples: Sequence[DynamicsSamples], sensor: str) -> Comparison:
    """One sensor, as the dynamics service tells it; the offset is the one that it found at rest.

    Raises:
        ServiceError: the sensor was never told of, or never valid.
    """
    told = [one for sample in samples for one in sample.sensors if one.name == sensor and one.valid]
    if not told:
        raise ServiceError(f"the dynamics service tells nothing of {sensor}")
    return Comparison(
        measured=np.array([one.measured for one in told]),
        predicted=np.array([one.predicted for one in told]),
        touched=sum(one.touching for one in told),
    )


def of_recording(recording: Recording, urdf: str) -> Comparison:
    """The real right arm, its test rows, by the CAD model of one URDF.

    The recording's axes and signs are those of the URDF's sensor frame and of docs/frames.md: every
    other assignment of axes and signs fits at least 40 times worse. The offset is constant, from
    the training rows; joints that were not recorded are taken to be at zero, the torso upright.
    """
    path = str(urdf_path(urdf))
    train, test = (_of_samples(path, rows) for rows in (recording.train, recording.test))
    offset = (recording.train.wrenches - train).mean(axis=0)
    return Comparison(measured=recording.test.wrenches - offset, predicted=test)


def _of_samples(urdf_file: str, rows: Samples) -> Matrix:
    motion = (rows.q_rad, rows.dq_rad_s, rows.ddq_rad_s2)
    frames = {RECORDED_FRAME: RECORDED_FRAME}
    return _predicted(urdf_file, JOINTS, frames, motion)[RECORDED_FRAME]


def _predicted(
    urdf_file: str,
    joints: tuple[str, ...],
    frames: dict[str, str],
    motion: tuple[Matrix, Matrix, Matrix],
) -> dict[str, Matrix]:
    """What every sensor would read if nothing touched the robot, (rows, 6)."""
    model = TreeModel.from_urdf(urdf_file, joints, frames)
    estimator = WholeBodyEstimator(model, Assumption())
    copies = [part.copy() for part in motion]  # read-only rows would take the long way round
    rows = np.array([estimator.predict(*row) for row in zip(*copies, strict=True)])
    return {sensor: rows[:, i] for i, sensor in enumerate(model.sensors)}
