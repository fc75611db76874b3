"""The recorded arm's inertial parameters, identified: how much of the error CAD is to blame for.

Ten parameters for each of the two bodies beyond the sensor (upper arm; forearm with hand) and six
constant offsets, by least squares from CAD's values on.
"""

import numpy as np

from dforc.arrays import Matrix
from dforc.learning.semi_parametric import RigidParameters
from dforc.robot_model import RobotModel
from services.experiments.icubdyn import Recording, Samples
from services.experiments.wrench_errors import RECORDED_FRAME, nmse, recorded_arm

NOISE = (0.8, 0.7, 0.4, 0.07, 0.06, 0.05)  # what CAD leaves over: N, Nm
SPREAD = (0.3, 0.05, 0.05, 0.05, *(0.01,) * 6)  # of a body about CAD: kg, kg m, kg m2; wide
OFFSET_SPREAD = 100.0
BLOCK_ROWS = 100  # 3.5 s between two solutions


def identified_nmse(recording: Recording, urdf: str) -> tuple[float, float]:
    """Errors (nMSE) on the test rows, averaged over the components.

    First with the parameters of the training rows, then with parameters that go on being identified
    from the test rows already predicted.
    """
    model = recorded_arm(urdf)
    train, test = (_regressors(model, rows) for rows in (recording.train, recording.test))
    measured = recording.test.wrenches
    cad = model.inertial_parameters(RECORDED_FRAME)
    spread = [*SPREAD * (len(cad) // len(SPREAD)), *(OFFSET_SPREAD,) * 6]
    parameters = RigidParameters(np.append(cad, np.zeros(6)), spread, NOISE)
    parameters.add(train, recording.train.wrenches)
    once = test @ parameters.solve()
    online = []
    for start in range(0, len(test), BLOCK_ROWS):
        block = slice(start, start + BLOCK_ROWS)
        online.append(test[block] @ parameters.solve())
        parameters.add(test[block], measured[block])
    return nmse(once, measured), nmse(np.vstack(online), measured)


def _regressors(model: RobotModel, rows: Samples) -> Matrix:
    """Per row: the wrench's dependence on the parameters and on the offset, (rows, 6, 10 k + 6)."""
    states = zip(rows.q_rad, rows.dq_rad_s, rows.ddq_rad_s2, strict=True)
    bodies = np.array([model.sensor_regressor(*state, RECORDED_FRAME) for state in states])
    offsets = np.broadcast_to(np.eye(6), (len(bodies), 6, 6))
    return np.concatenate([bodies, offsets], axis=2)
