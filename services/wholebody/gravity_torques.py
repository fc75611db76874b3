"""Torques that hold the robot against gravity, wherever its base says that down is."""

from dataclasses import replace

import numpy as np

from dforc.arrays import Vector
from dforc.estimation.assumption import Assumption, BaseMotion
from dforc.estimation.estimator import WholeBodyEstimator
from dforc.estimation.tree_model import TreeModel

NO_TURN = (0.0, 0.0, 0.0)


class GravityTorques:
    """Of all joints, at rest, with nothing touching the robot."""

    def __init__(self, model: TreeModel) -> None:
        self._none = np.zeros(model.m, dtype=np.bool_)
        self._unread = np.zeros((model.m, 6))
        self._still: Vector = np.zeros(model.n)
        self._estimator = WholeBodyEstimator(model, Assumption(mainstay=False))

    def use(self, frame: str) -> None:
        """Frame of the IMU that says where down is; empty: the base is upright."""
        self._estimator.assume(Assumption(source=frame, mainstay=False))

    def torques(self, q_rad: Vector, motion: BaseMotion | None) -> Vector:
        """Torques (n,), Nm; `motion` is the IMU's, of which only the acceleration counts."""
        held = None
        if motion is not None:
            held = replace(motion, omega_rad_s=NO_TURN, domega_rad_s2=NO_TURN)
        still = self._still
        estimate = self._estimator.estimate(q_rad, still, still, self._unread, self._none, held)
        return estimate.tau_nm
