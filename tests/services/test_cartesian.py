"""The Cartesian service: when it commands, and what it refuses."""

from dataclasses import dataclass

import msgspec
import numpy as np
import pytest

from services.cartesian import Cartesian
from services.core.testing import Bench
from services.messages import DynamicsStatus, IkSolution, JointState, VirtualPoint
from services.robotfile.robot_tables import RobotFile
from services.streams import (
    CARTESIAN_STATUS,
    DYNAMICS_STATUS,
    IK_SOLUTION,
    JOINT_COMMAND,
    JOINT_STATE,
    VIRTUAL_POINT,
)
from tests.services.postures import point

IDLE = 0x00


@dataclass
class Arm:
    """A bench that keeps the joint states fresh."""

    robot: RobotFile
    states: dict[str, JointState]
    bench: Bench

    def run(self, seconds: float, sequence: int | None = None) -> None:
        for _ in range(round(seconds / 0.01)):
            for part, state in self.states.items():
                self.bench.put(JOINT_STATE[part], state)
            if sequence is not None:
                self.answer(point(self.robot, (0.0, 0.0, 0.0), sequence))
                sequence += 1
            self.bench.advance(0.01)

    def answer(self, target: VirtualPoint, nan: bool = False) -> None:
        q = np.radians(self.robot.reach.home_deg)
        self.bench.put(VIRTUAL_POINT, target)
        self.bench.put(
            IK_SOLUTION,
            IkSolution(
                stamp_ns=0,
                sequence=target.sequence,
                q_rad=tuple((q * (np.nan if nan else 1.0)).tolist()),
                status="converged",
                position_error_m=0.0,
                orientation_error_rad=0.0,
                iterations=1,
            ),
        )


@pytest.fixture
def arm(robot: RobotFile, home: dict[str, JointState]) -> Arm:
    return Arm(robot, home, Bench(Cartesian(robot)))


def test_waits_without_a_solution(arm: Arm) -> None:
    arm.run(0.05)
    assert arm.bench.sent(JOINT_COMMAND["right_arm"]) == []
    assert arm.bench.last(CARTESIAN_STATUS).state == "waiting"


def test_holds_a_posture_that_is_the_target_already(arm: Arm) -> None:
    arm.run(0.5, sequence=1)
    command = arm.bench.last(JOINT_COMMAND["right_arm"])
    assert command.mode == "direct"
    assert command.q_rad == pytest.approx(np.radians(arm.robot.reach.home_deg[3:]), abs=1e-6)
    assert arm.bench.last(CARTESIAN_STATUS).state == "in_target"


def test_commands_nothing_while_a_joint_is_in_another_mode(arm: Arm) -> None:
    torso = arm.states["torso"]
    arm.states["torso"] = msgspec.structs.replace(torso, control_mode=(IDLE, 0x08, 0x08))
    arm.run(0.05, sequence=1)
    assert arm.bench.sent(JOINT_COMMAND["torso"]) == []


def test_commands_nothing_while_a_joint_is_not_valid(arm: Arm) -> None:
    arm.states["torso"] = msgspec.structs.replace(arm.states["torso"], valid=False)
    arm.run(0.05, sequence=1)
    assert arm.bench.sent(JOINT_COMMAND["right_arm"]) == []


def test_solution_that_is_not_finite_is_refused_and_the_last_target_holds(arm: Arm) -> None:
    arm.run(0.1, sequence=1)
    arm.answer(point(arm.robot, (0.0, 0.0, 0.0), 100), nan=True)
    arm.run(0.02)
    assert arm.bench.last(CARTESIAN_STATUS).refused == 1
    assert np.isfinite(arm.bench.last(JOINT_COMMAND["right_arm"]).q_rad).all()


def test_solution_without_its_point_is_refused(arm: Arm) -> None:
    arm.run(0.1, sequence=1)
    solution = IkSolution(
        stamp_ns=0,
        sequence=999,
        q_rad=(0.0,) * 10,
        status="converged",
        position_error_m=0.0,
        orientation_error_rad=0.0,
        iterations=1,
    )
    arm.bench.put(IK_SOLUTION, solution)
    arm.run(0.02)
    assert arm.bench.last(CARTESIAN_STATUS).refused == 1


def test_push_freezes_the_outer_loop(arm: Arm) -> None:
    arm.run(0.1, sequence=1)
    pushed = DynamicsStatus(
        stamp_ns=0,
        state="running",
        samples=0,
        offset=(),
        refused=0,
        external_force_n=(0.0, 0.0, -20.0),
    )
    arm.bench.put(DYNAMICS_STATUS, pushed)
    arm.run(0.03, sequence=20)
    status = arm.bench.last(CARTESIAN_STATUS)
    assert status.gated
    assert status.external_force_n == pytest.approx(20.0)


@pytest.mark.parametrize(
    "bad",
    [
        {"velocity_m_s": (np.nan, 0.0, 0.0)},
        {"rotation_rad": (np.inf, 0.0, 0.0)},
        {"position_m": (1e200, 0.0, 0.0)},
    ],
)
def test_point_that_is_not_finite_is_refused_and_the_last_target_holds(
    arm: Arm, bad: dict[str, tuple[float, float, float]]
) -> None:
    arm.run(0.1, sequence=1)
    before = len(arm.bench.sent(JOINT_COMMAND["right_arm"]))
    arm.answer(msgspec.structs.replace(point(arm.robot, (0.0, 0.0, 0.0), 100), **bad))
    arm.run(0.02)
    assert arm.bench.last(CARTESIAN_STATUS).refused == 1
    assert len(arm.bench.sent(JOINT_COMMAND["right_arm"])) == before + 2


def test_solutions_that_are_all_refused_stop_the_plan_as_silence_does(arm: Arm) -> None:
    silent = Arm(arm.robot, arm.states, Bench(Cartesian(arm.robot)))
    far = point(arm.robot, (-0.1, 0.0, 0.0), 50)
    for each in (arm, silent):
        each.run(0.1, sequence=1)
        each.answer(far)
        each.run(0.01)
    for sequence in range(100, 200):
        arm.answer(point(arm.robot, (0.0, 0.0, 0.0), sequence), nan=True)
        arm.run(0.01)
    silent.run(1.0)
    plan_m = arm.bench.last(CARTESIAN_STATUS).plan_position_m
    assert plan_m == silent.bench.last(CARTESIAN_STATUS).plan_position_m
    assert plan_m[0] > far.position_m[0] + 0.01


@pytest.mark.parametrize(
    "bad",
    [{"q_rad": (np.nan, 0.0, 0.0)}, {"q_rad": (0.0,)}, {"compliant": ()}, {"control_mode": ()}],
)
def test_joints_that_are_no_posture_are_refused(arm: Arm, bad: dict[str, tuple[float]]) -> None:
    arm.run(0.1, sequence=1)
    before = len(arm.bench.sent(JOINT_COMMAND["right_arm"]))
    arm.states["torso"] = msgspec.structs.replace(arm.states["torso"], **bad)
    arm.run(0.02, sequence=20)
    assert len(arm.bench.sent(JOINT_COMMAND["right_arm"])) == before
    assert arm.bench.last(CARTESIAN_STATUS).refused > 0
    assert arm.bench.last(CARTESIAN_STATUS).q_rad == ()
