"""Dynamics and learner together: a sensor that reads too much, and a learner that is replaced."""

from pathlib import Path

import numpy as np
import pytest

from services.core.testing import Bench
from services.learner import Learner
from services.messages import Message
from services.robotfile.robot_tables import RobotFile
from services.streams import (
    DYNAMICS_SAMPLES,
    EXTERNAL,
    LEARNED,
    LEARNER_CALL,
    TORQUE_ESTIMATE,
)
from services.wholebody.dynamics_messages import LearnerRequest
from tests.services.whole_body import Stand, swing

SENSOR = "r_arm_ft"
GAIN = 1.12


class Pair:
    """A swinging arm; the learner hears of it and answers in the next millisecond."""

    def __init__(self, robot: RobotFile) -> None:
        self.robot = robot
        self.stand = Stand(robot)
        self.stand.calibrate()
        self.stand.gains[SENSOR] = np.eye(6) / GAIN  # the reading is GAIN times too large
        self.stand.path = swing(self.stand.q_rad, 0.25, 0.5)
        self.learner: Bench | None = Bench(Learner(robot))
        self.heard = 0

    def run(self, seconds: float) -> float:
        """RMS of the force that dynamics takes for a contact [N], over the second half."""
        forces = []
        for tick in range(round(seconds * 1000)):
            self.stand.run(1)
            samples = self.stand.bench.sent(DYNAMICS_SAMPLES)
            if len(samples) == self.heard:
                continue
            self.heard = len(samples)
            if tick > 500 * seconds:
                forces.append(np.linalg.norm(self.stand.contact(SENSOR).force_n))
            if self.learner is not None:
                self.learner.advance(0.01)
                self.learner.put(DYNAMICS_SAMPLES, samples[-1])
                answer: Message = self.learner.last(LEARNED)
                self.stand.others = {LEARNED: answer}
        return float(np.sqrt(np.mean(np.square(forces))))

    def ask(self, action: str, value: str) -> None:
        assert self.learner is not None
        self.learner.request(LEARNER_CALL, LearnerRequest(action=action, value=value))
        assert self.learner.replies(LEARNER_CALL)[-1][1].ok


@pytest.mark.slow
def test_a_replaced_learner_goes_on_where_the_old_one_was_and_no_torque_is_lost(
    robot: RobotFile, tmp_path: Path
) -> None:
    pair = Pair(robot)
    before = len(pair.stand.bench.sent(TORQUE_ESTIMATE["right_arm"]))
    unlearned = pair.run(1.0)
    pair.run(10.0)
    learned = pair.run(1.0)
    file = str(tmp_path / "arm.state")
    pair.ask("save", file)
    pair.learner = None
    alone = pair.run(1.0)
    pair.learner = Bench(Learner(robot))
    pair.ask("restore", file)
    resumed = pair.run(1.0)
    assert unlearned > 0.5
    assert alone > 0.5
    assert learned < 0.4 * unlearned
    assert resumed < 0.4 * unlearned
    torques = pair.stand.bench.sent(TORQUE_ESTIMATE["right_arm"])[before:]
    stamps_ns = np.array([torque.stamp_ns for torque in torques])
    assert np.all(np.diff(stamps_ns) == 1_000_000)
    assert len(torques) == 14_000
    assert len(pair.stand.bench.sent(EXTERNAL)) > 1400
