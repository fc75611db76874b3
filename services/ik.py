"""Inverse kinematics: one posture of the limb for every virtual point (eq. 11, by IPOPT).

Reads   field/virtual_point (trigger), cartesian/status (the posture where the search starts)
Writes  ik/ik_solution
Each search starts from the previous answer, and no joint moves by more than a few degrees from one
answer to the next. A position out of reach gives the nearest feasible posture, and says so. A point
or a posture that is not finite is refused, counted and logged.
"""

import logging
import math

import numpy as np

from dforc import rotation
from dforc.arrays import Vector
from dforc.errors import DforcError
from dforc.ik import IkSettings, InverseKinematics
from services.config import load_robot
from services.core.live import Context, run_process
from services.core.log import OncePerSecond
from services.core.service import Inputs, Outputs, Service
from services.messages import IkSolution, VirtualPoint
from services.reaching.limb import limb_limits, limb_model
from services.robotfile.robot_tables import RobotFile
from services.streams import CARTESIAN_STATUS, IK_SOLUTION, VIRTUAL_POINT

logger = logging.getLogger(__name__)

STATE_AGE_S = 0.1
STEP_LIMIT_RAD = math.radians(5.0)  # per 10 ms; a larger step is a jump to another posture
FORGET_AFTER_S = 0.5  # without points, the next search starts from the measured posture again


class Ik(Service):
    """One solver, warm-started."""

    reads = (VIRTUAL_POINT, CARTESIAN_STATUS)
    writes = (IK_SOLUTION,)
    trigger = VIRTUAL_POINT

    def __init__(self, robot: RobotFile) -> None:
        self._solver = InverseKinematics(
            limb_model(robot),
            limb_limits(robot),
            np.radians(robot.reach.rest_deg),
            robot.reach.rest_weights,
            IkSettings(beta=robot.reach.rest_beta),
        )
        self._answer: Vector | None = None
        self._answered_ns = 0
        self.refused = 0
        self._throttle = OncePerSecond()

    def step(self, now_ns: int, inputs: Inputs, outputs: Outputs) -> None:
        """Answer the newest point; older ones that queued up meanwhile are history."""
        point = inputs.new(VIRTUAL_POINT)
        if point is None:
            return
        if self._answer is None or now_ns - self._answered_ns > FORGET_AFTER_S * 1e9:
            self._answer = self._measured(inputs)
            self._solver.reset()
            if self._answer is None:
                return
        try:
            solution = self._solve(now_ns, point, self._answer)
        except DforcError as error:  # not finite, or a posture or rotation that is none
            self.refused += 1
            if self._throttle.allows("point", now_ns):
                logger.warning("point refused: %s", error)
            return
        outputs.put(IK_SOLUTION, solution)

    def _solve(self, now_ns: int, point: VirtualPoint, start: Vector) -> IkSolution:
        result = self._solver.solve(
            point.position_m, rotation.matrix(point.rotation_rad), start, STEP_LIMIT_RAD
        )
        self._answer = result.q_rad
        self._answered_ns = now_ns
        return IkSolution(
            stamp_ns=now_ns,
            sequence=point.sequence,
            q_rad=tuple(result.q_rad.tolist()),
            status=str(result.status),
            position_error_m=result.position_error_m,
            orientation_error_rad=result.orientation_error_rad,
            iterations=result.iterations,
        )

    def _measured(self, inputs: Inputs) -> Vector | None:
        status = inputs.fresh(CARTESIAN_STATUS, STATE_AGE_S)
        return None if status is None or not status.q_rad else np.array(status.q_rad)


def build(context: Context) -> Ik:
    """Build the optimisation problem of the robot's limb."""
    return Ik(load_robot(context.robot))


if __name__ == "__main__":
    raise SystemExit(run_process("ik", build))
