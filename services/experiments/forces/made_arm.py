"""Data made by script: torques of the left arm's seven joints in motion, with friction and noise.

Each rollout is a sum of four sines per joint inside the joint's limits. Torques come from the
model, plus Coulomb and viscous friction, plus noise of 2 % of each torque's spread. What a learner
knows of the model is the regressor and the drawing's parameters; the friction is unknown to it.
"""

from dataclasses import dataclass

import numpy as np

from dforc.arrays import Matrix, Vector, constant
from dforc.robot_model import RobotModel
from services.robotfile.model_file import urdf_path

URDF, TIP = "iCubLisboa01", "l_hand"
JOINTS = (
    "l_shoulder_pitch",
    "l_shoulder_roll",
    "l_shoulder_yaw",
    "l_elbow",
    "l_wrist_prosup",
    "l_wrist_pitch",
    "l_wrist_yaw",
)
COULOMB_NM = np.array([0.3, 0.3, 0.15, 0.15, 0.02, 0.02, 0.02])
VISCOUS_NMS_RAD = np.array([0.1, 0.1, 0.05, 0.05, 0.007, 0.007, 0.007])
COULOMB_AT_RAD_S = 0.05  # the friction has all but its full size at twice this speed
NOISE_SHARE = 0.02
SINES = 4
TURN_RAD_S = (0.6, 4.0)
SAMPLE_HZ = 50
LIMIT_SHARE = 0.9  # of the joint's range that a rollout may use


@dataclass(frozen=True, slots=True, eq=False)
class Motion:
    """Rows of one or several rollouts."""

    x: Matrix  # (rows, 21): angles, velocities, accelerations
    tau_nm: Matrix  # (rows, 7)
    regressors: Matrix  # (rows, 7, 70)

    def __len__(self) -> int:
        return len(self.x)

    def at(self, rows: "np.ndarray[tuple[int], np.dtype[np.intp]]") -> "Motion":
        """Some of the rows."""
        return Motion(self.x[rows], self.tau_nm[rows], self.regressors[rows])


@dataclass(frozen=True, slots=True, eq=False)
class MadeArm:
    """Training rollouts, and others that nobody has seen."""

    train: Motion
    test: Motion
    drawing: Vector  # (70,)

    def errors(self, predicted: Matrix) -> Vector:
        """Mean square over variance of the test, per joint (7,)."""
        squares = ((self.test.tau_nm - predicted) ** 2).mean(0)
        shares: Vector = squares / self.test.tau_nm.var(0)
        return shares


def made_arm(seed: int, rollouts: int, rows: int, unseen: int, unseen_rows: int) -> MadeArm:
    """`rollouts` of `rows` samples to learn from and `unseen` of `unseen_rows` to be tried on."""
    rng = np.random.default_rng(seed)
    model = RobotModel(str(urdf_path(URDF)), JOINTS, TIP, {})
    train = [_rollout(model, rng, rows) for _ in range(rollouts)]
    test = [_rollout(model, rng, unseen_rows) for _ in range(unseen)]
    spread = np.concatenate([motion.tau_nm for motion in train]).std(0)
    return MadeArm(
        _joined(train, spread, rng), _joined(test, spread, rng), constant(model.joint_parameters())
    )


def _rollout(model: RobotModel, rng: np.random.Generator, rows: int) -> Motion:
    at_s = np.arange(rows) / SAMPLE_HZ
    turn = rng.uniform(*TURN_RAD_S, size=(SINES, model.n))
    phase = rng.uniform(0, 2 * np.pi, size=(SINES, model.n))
    share = rng.dirichlet(np.ones(SINES), size=model.n).T
    angle = turn[:, None] * at_s[:, None] + phase[:, None]  # (sines, rows, joints)
    reach = LIMIT_SHARE * (model.upper_rad - model.lower_rad) / 2
    q = (model.upper_rad + model.lower_rad) / 2 + reach * (share[:, None] * np.sin(angle)).sum(0)
    dq = reach * ((share * turn)[:, None] * np.cos(angle)).sum(0)
    ddq = -reach * ((share * turn**2)[:, None] * np.sin(angle)).sum(0)
    states = zip(q, dq, ddq, strict=True)
    regressors = np.array([model.torque_regressor(*state) for state in states])
    friction = COULOMB_NM * np.tanh(dq / COULOMB_AT_RAD_S) + VISCOUS_NMS_RAD * dq
    tau_nm = regressors @ model.joint_parameters() + friction
    return Motion(np.hstack([q, dq, ddq]), tau_nm, regressors)


def _joined(motions: list[Motion], spread_nm: Vector, rng: np.random.Generator) -> Motion:
    clean = np.concatenate([motion.tau_nm for motion in motions])
    noise = NOISE_SHARE * spread_nm * rng.standard_normal(clean.shape)
    return Motion(
        np.concatenate([motion.x for motion in motions]),
        clean + noise,
        np.concatenate([motion.regressors for motion in motions]),
    )
