"""The recorded arm with identified inertial parameters: how much of the error CAD is to blame for.

Ten parameters for each of the two bodies beyond the sensor (upper arm; forearm with hand) and six
constant offsets, by least squares from CAD's values on.
"""

import numpy as np

from services.experiments.forces.arm_learning import ArmTask, identified

BLOCK_ROWS = 100  # 3.5 s between two solutions


def identified_nmse(task: ArmTask) -> tuple[float, float]:
    """Errors (nMSE) on the test rows, averaged over the components.

    First with the parameters of the training rows, then with parameters that go on being identified
    from the test rows already predicted.
    """
    parameters = identified(task)
    regressors, measured = task.test.regressors, task.test.y
    once = measured - regressors @ parameters.theta
    online = np.empty_like(measured)
    for start in range(0, len(measured), BLOCK_ROWS):
        block = slice(start, start + BLOCK_ROWS)
        online[block] = measured[block] - regressors[block] @ parameters.solve()
        parameters.add(regressors[block], measured[block])
    return task.error(once), task.error(online)
