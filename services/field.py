"""Force field: moves a virtual point to the goal and around the obstacles (DForC section III-B).

Reads   field/goal, field/objects, cartesian/status (the hand, where the point starts)
Writes  field/virtual_point
The point starts at the hand when a goal becomes active, and is silent while none is. A goal or an
obstacle that is not finite is refused, counted and logged; the previous one holds. Where hand and
goal make no field the point falls silent, and starts at the hand again. It needs no feedback: the
point does not wait for the hand.
"""

import logging

import numpy as np

from dforc.errors import DforcError
from dforc.field.force import Ellipsoid, FieldParams, PointState, Target, ball, scene_of
from dforc.field.rollout import step
from services.core.live import Context, run_process
from services.core.log import OncePerSecond
from services.core.service import Inputs, Outputs, Period, Service
from services.messages import Goal, Objects, VirtualPoint
from services.streams import CARTESIAN_STATUS, GOAL, OBJECTS, VIRTUAL_POINT

logger = logging.getLogger(__name__)

PERIOD_S = 0.01  # the papers' sample time
STATE_AGE_S = 0.1
# DELIBERATE: the papers' K = 4 N/m, D = 8 Ns/m need 7.8 s to come within 5 mm of a target 0.3 m
# away and lag 2 s behind a moving one; K = 9, D = 6 is critically damped (both poles at -3 1/s):
# 2.0 s and 0.67 s. At the boundary G/e = 9.2 N = K 1.02 m holds against goals within 1 m.
PARAMS = FieldParams(stiffness_n_m=9.0, damping_ns_m=6.0, gain_n=25.0, margin_m=0.02)


class Field(Service):
    """One virtual point."""

    reads = (GOAL, OBJECTS, CARTESIAN_STATUS)
    writes = (VIRTUAL_POINT,)
    trigger = Period(PERIOD_S)

    def __init__(self, params: FieldParams | None = None) -> None:
        self._params = params or PARAMS
        self._point: PointState | None = None
        self._goal: Goal | None = None
        self._obstacles: tuple[Ellipsoid, ...] = ()
        self._sequence = 0
        self.refused = 0
        self._throttle = OncePerSecond()

    def step(self, now_ns: int, inputs: Inputs, outputs: Outputs) -> None:
        """Move the point by one period."""
        goal, objects = inputs.new(GOAL), inputs.new(OBJECTS)
        if goal is not None:
            self._take_goal(now_ns, goal)
        if objects is not None:
            self._take_objects(now_ns, objects)
        if self._goal is None or not self._goal.active:
            self._point = None
            return
        if self._point is None:
            self._point = self._hand(inputs)
            if self._point is None:
                return
        try:
            target = Target(position_m=self._goal.position_m)
            scene = scene_of((target,), self._obstacles, self._params)
            self._point = step(self._point, scene, PERIOD_S)
        except DforcError as error:  # a hand that is none, or a goal beyond all numbers
            self._refuse(now_ns, str(error))
            self._point = None
            return
        self._sequence += 1
        outputs.put(
            VIRTUAL_POINT,
            VirtualPoint(
                stamp_ns=now_ns,
                sequence=self._sequence,
                position_m=self._point.position_m,
                velocity_m_s=self._point.velocity_m_s,
                rotation_rad=self._goal.rotation_rad,
            ),
        )

    def _take_goal(self, now_ns: int, goal: Goal) -> None:
        if np.isfinite(goal.position_m + goal.rotation_rad).all():
            self._goal = goal
        else:
            self._refuse(now_ns, f"{goal} is not finite")

    def _take_objects(self, now_ns: int, objects: Objects) -> None:
        obstacles = tuple(ball(o.centre_m, o.radius_m) for o in objects.obstacles)
        try:  # a field of these obstacles must exist at all
            scene_of((), obstacles, self._params)
        except DforcError as error:
            self._refuse(now_ns, str(error))
            return
        self._obstacles = obstacles

    def _refuse(self, now_ns: int, reason: str) -> None:
        self.refused += 1
        if self._throttle.allows("refused", now_ns):
            logger.warning("refused: %s", reason)

    def _hand(self, inputs: Inputs) -> PointState | None:
        status = inputs.fresh(CARTESIAN_STATUS, STATE_AGE_S)
        return PointState(position_m=status.hand_position_m) if status and status.q_rad else None


def build(context: Context) -> Field:  # noqa: ARG001
    """The field needs nothing of the robot."""
    return Field()


if __name__ == "__main__":
    raise SystemExit(run_process("field", build))
