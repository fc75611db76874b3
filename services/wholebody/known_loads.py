"""What known wrenches of the world add to the readings of the sensors that feel them."""

import numpy as np

from dforc.arrays import Matrix
from dforc.estimation.assumption import KnownWrench
from dforc.estimation.estimator import WholeBodyEstimator
from services.wholebody.body import Body


class KnownLoads:
    """Of one assumption: they belong to what a sensor reads if nothing else touches its limb."""

    def __init__(self, body: Body) -> None:
        self._body = body
        self._felt: tuple[tuple[KnownWrench, tuple[int, ...]], ...] = ()  # with their sensors

    def use(self, known: tuple[KnownWrench, ...]) -> None:
        """These from now on."""
        tree, sensors = self._body.tree, self._body.sensors
        above = [set(tree.joints_above(load.frame)) for load in known]
        felt = [tuple(i for i, s in enumerate(sensors) if s.frame in joints) for joints in above]
        self._felt = tuple(zip(known, felt, strict=True))

    def added_to(self, predicted: Matrix, estimator: WholeBodyEstimator) -> Matrix:
        """Predictions (m, 6) that belong to the estimator's last estimate, with the loads."""
        if not self._felt:
            return predicted
        whole = predicted.copy()
        for load, sensors in self._felt:
            turn, origin = estimator.frame_pose(load.frame)
            at = origin + turn @ np.array(load.point_m)
            force, moment = turn @ load.wrench[:3], turn @ load.wrench[3:]
            for i in sensors:
                sensor_turn, sensor_at = estimator.frame_pose(self._body.sensors[i].frame)
                whole[i, :3] += sensor_turn.T @ force
                whole[i, 3:] += sensor_turn.T @ (moment + np.cross(at - sensor_at, force))
        return whole
