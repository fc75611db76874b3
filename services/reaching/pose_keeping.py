"""A pose that is gone to or kept although somebody moves the joints that are blocked.

Inverse kinematics is asked again once they have moved by a degree, all together.
"""

import math
from dataclasses import dataclass

import numpy as np

from dforc.cartesian.targets import ReachTarget
from services.core.service import Outputs
from services.messages import Floats
from services.reaching.ik_questions import IkQuestions
from services.reaching.ik_targets import pose_targets
from services.reaching.limb_control import LimbControl
from services.reaching.limb_driver import LimbDriver, Mode
from services.reaching.limb_reading import Reading
from services.reaching.messages import IkAnswer, PoseTarget, TipPose
from services.reaching.tip_poses import reached_poses

MOVED_RAD = math.radians(1.0)


@dataclass(frozen=True, slots=True)
class Goal:
    """What a limb was sent to."""

    limb: str
    poses: tuple[TipPose | None, ...]
    blocked_rad: Floats  # where the blocked joints were


class PoseKeeping:
    """The goal of the newest motion."""

    def __init__(self, driver: LimbDriver, questions: IkQuestions) -> None:
        self._driver = driver
        self._questions = questions
        self._goal: Goal | None = None
        self._asked = False

    def begin(self, poses: tuple[TipPose | None, ...], reading: Reading) -> None:
        """A motion of the limb in use has begun."""
        driver = self._driver
        self._goal = Goal(driver.limb, poses, blocked_angles(driver.control, reading))

    def look(self, reading: Reading, outputs: Outputs) -> None:
        """Every period, with the reading of the limb in use."""
        goal, driver = self._goal, self._driver
        if goal is None or self._asked or not self._holds(goal) or reading.missing:
            return
        control = driver.control
        blocked = blocked_angles(control, reading)
        if len(blocked) != len(goal.blocked_rad) or not blocked:
            return
        if math.dist(blocked, goal.blocked_rad) < MOVED_RAD:
            return
        self._goal = goal = Goal(goal.limb, goal.poses, blocked)
        targets = pose_targets(PoseTarget(tips=goal.poses), len(control.shape.tips))

        def heard(now_ns: int, answer: IkAnswer | None, reason: str) -> None:  # noqa: ARG001
            self._asked = False
            if answer is not None and self._goal is goal and self._holds(goal):
                q = np.array(answer.q_rad)
                poses = reached_poses(control.problem.tips, targets, q)
                driver.retarget(ReachTarget(tips=poses, q_rad=q))

        start = tuple(control.start_posture(reading).tolist())
        self._questions.ask(outputs, control, goal.poses, start, heard)
        self._asked = True

    def _holds(self, goal: Goal) -> bool:
        driver = self._driver
        return driver.limb == goal.limb and driver.mode in (Mode.POSE, Mode.TRACKING)


def blocked_angles(control: LimbControl, reading: Reading) -> Floats:
    """Angles of the joints that may not move."""
    return tuple(q for q, free in zip(reading.q_rad, control.free, strict=True) if not free)
