"""The HAL's service: which commands it refuses, and what it tells about them."""

import math
from collections.abc import Callable, Iterator
from typing import Any

import numpy as np
import pytest

from firmware_sim.boards.axis_state import Axis
from firmware_sim.boards.motor_board import MotorBoard
from hal.readings import ForceTorqueSample
from services.core.service import Inputs, Outputs, Period, Service
from services.core.stream import AnyStream
from services.emulated.simulation import Simulation
from services.messages import JointCommand, Reply, Wrench
from services.robot import averaged
from services.robot_messages import RobotRequest, RobotStatus
from services.robotfile.robot_tables import RobotFile
from services.robotfile.wiring import robot_description
from services.streams import JOINT_COMMAND, ROBOT_CALL, ROBOT_STATUS

ARM = JOINT_COMMAND["right_arm"]


class Operator(Service):
    """Somebody who sends commands by hand."""

    trigger = Period(0.01)
    reads: tuple[AnyStream, ...] = (ROBOT_STATUS,)
    writes: tuple[AnyStream, ...] = (ARM,)
    calls = (ROBOT_CALL,)

    def __init__(self) -> None:
        self.status: RobotStatus | None = None
        self.replies: list[Any] = []
        self.orders: list[Callable[[int, Outputs], object]] = []

    def step(self, now_ns: int, inputs: Inputs, outputs: Outputs) -> None:
        self.status = inputs.latest(ROBOT_STATUS)
        self.replies += [reply for _, reply in inputs.replies(ROBOT_CALL)]
        for order in self.orders:
            order(now_ns, outputs)
        self.orders.clear()


class Desk:
    """A robot in position-direct mode and its operator."""

    def __init__(self, robot: RobotFile) -> None:
        self.operator = Operator()
        self.robot = robot
        self.simulation = Simulation(robot, guests={"operator": self.operator})
        self.until(lambda status: status.phase == "idle")
        self.ask(RobotRequest(action="calibrate"))
        self.until(lambda status: status.phase == "ready" and not status.busy, 20.0)
        self.ask(RobotRequest(action="mode", value="direct"))
        self.until(lambda status: not status.busy)
        self.simulation.executor.run(2.0)  # come to rest

    def until(self, condition: Callable[[RobotStatus], bool], seconds: float = 3.0) -> None:
        operator = self.operator
        assert self.simulation.executor.run(
            seconds, until=lambda: operator.status is not None and condition(operator.status)
        )

    def ask(self, request: RobotRequest) -> Reply:
        self.operator.orders.append(lambda _now, outputs: outputs.call(ROBOT_CALL, request))
        before = len(self.operator.replies)
        assert self.simulation.executor.run(1.0, until=lambda: len(self.operator.replies) > before)
        reply = self.operator.replies[-1]
        assert isinstance(reply, Reply)
        self.simulation.executor.run(0.05)
        return reply

    def command(
        self,
        *,
        age_ns: int = 0,
        mode: str = "direct",
        q_rad: tuple[float, ...],
        joints: tuple[str, ...] = (),
    ) -> None:
        self.operator.orders.append(
            lambda now_ns, outputs: outputs.put(
                ARM, JointCommand(stamp_ns=now_ns - age_ns, mode=mode, q_rad=q_rad, joints=joints)
            )
        )
        self.simulation.executor.run(0.3)

    def arm_deg(self) -> list[float]:
        return [math.degrees(q) for q in self.simulation.rig.q_rad[3:]]

    def refusals(self) -> dict[str, int]:
        assert self.operator.status is not None
        return dict(self.operator.status.refusals)


def elbow(desk: Desk) -> Axis:
    """The emulated board's own right elbow."""
    spec = next(one for one in robot_description(desk.robot).boards if one.name == "r_elbow")
    board = desk.simulation.rig.board(spec.bus, spec.address)
    assert isinstance(board, MotorBoard)
    return board.axes[1]


@pytest.fixture(scope="module")
def desk(robot: RobotFile) -> Iterator[Desk]:
    desk = Desk(robot)
    yield desk
    desk.simulation.close()


def test_good_command_moves_the_arm(desk: Desk) -> None:
    q = np.radians(desk.arm_deg())
    q[3] += math.radians(3.0)
    desk.command(q_rad=tuple(q.tolist()))
    desk.simulation.executor.run(1.0)
    assert desk.arm_deg()[3] == pytest.approx(math.degrees(q[3]), abs=0.3)


def test_command_for_one_joint_leaves_the_others_where_they_are(desk: Desk) -> None:
    before = desk.arm_deg()
    desk.command(q_rad=(math.radians(before[3] - 3.0),), joints=("r_elbow",))
    desk.simulation.executor.run(1.0)
    expected = [*before[:3], before[3] - 3.0, *before[4:]]
    assert desk.arm_deg() == pytest.approx(expected, abs=0.3)


def test_command_for_a_joint_of_another_part_is_refused_by_name(desk: Desk) -> None:
    desk.command(q_rad=(0.1,), joints=("torso_yaw",))
    assert desk.refusals()["command for joints that right_arm has not got"] == 1


@pytest.mark.parametrize("bad", [float("nan"), float("inf")])
def test_command_that_is_not_finite_is_refused_and_counted(desk: Desk, bad: float) -> None:
    before, total = desk.arm_deg(), sum(desk.refusals().values())
    q = np.radians(before)
    q[0] = bad
    desk.command(q_rad=tuple(q.tolist()))
    assert desk.arm_deg() == pytest.approx(before, abs=0.2)
    assert sum(desk.refusals().values()) == total + 1


def test_command_that_is_too_old_is_refused_by_name(desk: Desk) -> None:
    before = desk.arm_deg()
    desk.command(age_ns=200_000_000, q_rad=tuple(np.radians(before) + 0.2))
    assert desk.refusals()["command too old"] == 1
    assert desk.arm_deg() == pytest.approx(before, abs=0.2)


def test_command_from_the_future_is_refused_and_shuts_out_no_other(desk: Desk) -> None:
    q_rad = tuple(np.radians(desk.arm_deg()))
    desk.command(age_ns=-3_600_000_000_000, q_rad=q_rad)
    assert desk.refusals()["command from the future"] == 1
    desk.command(q_rad=q_rad)
    assert "command out of order" not in desk.refusals()


def test_a_request_is_finished_only_when_those_before_it_are(desk: Desk) -> None:
    yaw_rad = desk.simulation.rig.q_rad[2] + 0.2
    desk.ask(RobotRequest(action="mode", value="position"))
    long = desk.ask(
        RobotRequest(action="move", joints=("torso_yaw",), q_rad=(yaw_rad,), duration_s=2.0)
    )
    short = desk.ask(RobotRequest(action="mode", joints=("r_elbow",), value="direct"))
    assert long.ok
    assert short.ok
    desk.simulation.executor.run(0.5)
    assert desk.operator.status is not None
    assert desk.operator.status.finished_task < long.task
    desk.until(lambda status: status.finished_task >= short.task, 5.0)
    desk.ask(RobotRequest(action="mode", value="direct"))
    desk.until(lambda status: not status.busy)


def test_command_beyond_a_limit_is_clamped_and_reported(desk: Desk) -> None:
    before = np.radians(desk.arm_deg())
    assert desk.operator.status is not None
    clamped = dict(desk.operator.status.clamped)
    q = before.copy()
    q[3] = 10.0
    desk.command(q_rad=tuple(q.tolist()))
    assert desk.operator.status is not None
    assert dict(desk.operator.status.clamped)["position"] > clamped.get("position", 0)
    desk.command(q_rad=tuple(before.tolist()))
    desk.simulation.executor.run(1.0)


def test_command_in_an_unknown_mode_is_refused_by_name(desk: Desk) -> None:
    desk.command(mode="teleport", q_rad=tuple(np.radians(desk.arm_deg())))
    assert desk.refusals()["unknown command mode 'teleport'"] == 1


def test_command_of_the_wrong_length_is_refused(desk: Desk) -> None:
    total = sum(desk.refusals().values())
    desk.command(q_rad=(0.0, 0.1))
    assert sum(desk.refusals().values()) == total + 1


def test_compliance_without_torques_is_refused_with_the_reason(desk: Desk) -> None:
    request = RobotRequest(action="interaction", joints=("r_elbow",), value="compliant")
    reply = desk.ask(request)
    assert not reply.ok
    assert "torque" in reply.reason


def test_unknown_action_is_refused_with_the_known_ones(desk: Desk) -> None:
    reply = desk.ask(RobotRequest(action="dance"))
    assert not reply.ok
    assert "calibrate" in reply.reason


STIFFER = (("stiffness_nm_deg", 0.5), ("damping_nms_deg", 0.03))


def test_a_joint_is_tuned_on_request(desk: Desk) -> None:
    request = RobotRequest(action="tune", joints=("r_elbow",), value="impedance", settings=STIFFER)
    assert desk.ask(request).ok
    desk.until(lambda status: not status.busy)

    status = desk.operator.status
    assert status is not None
    assert not [reason for _, reason in status.failed_tasks if reason.startswith("tune")]
    impedance = elbow(desk).impedance
    # 8 N m are 0x8000 torque units, a degree is 11.375 ticks: 0.5 * 4096 / 11.375, and thousandths.
    assert (impedance.stiffness, impedance.damping) == (180, 10803)


def test_open_loop_duties_reach_the_board(desk: Desk) -> None:
    assert desk.ask(RobotRequest(action="mode", joints=("r_elbow",), value="pwm")).ok
    seen = []
    for _ in range(6):  # without one for 100 ms the joint goes to position mode
        desk.operator.orders.append(
            lambda now_ns, outputs: outputs.put(
                ARM,
                JointCommand(stamp_ns=now_ns, mode="pwm", joints=("r_elbow",), duty_percent=(3.0,)),
            )
        )
        desk.simulation.executor.run(0.05)
        seen.append(elbow(desk).openloop_pwm)
    assert seen == [24] * 6  # of 800
    desk.simulation.executor.run(0.5)
    assert desk.ask(RobotRequest(action="mode", value="direct")).ok
    desk.until(lambda status: not status.busy)


@pytest.mark.parametrize(
    ("joints", "value", "settings", "reason"),
    [
        ((), "impedance", STIFFER, "tune takes one joint, not 0"),
        (("r_elbow",), "colour", STIFFER, "cannot tune 'colour'; known: position_pid"),
        (("r_elbow",), "impedance", STIFFER[:1], "impedance: Object missing required field"),
        (("r_elbow",), "current_limit", (("limit_ma", 0.5),), "current_limit: Expected `int`"),
        (("r_elbow",), "velocity_limit", (("limit_deg_s", 1e6),), "velocity limit 1e+06"),
        (("r_tail",), "impedance", STIFFER, "r_tail"),
    ],
)
def test_what_cannot_be_tuned_is_refused_with_the_reason(
    desk: Desk,
    joints: tuple[str, ...],
    value: str,
    settings: tuple[tuple[str, float], ...],
    reason: str,
) -> None:
    reply = desk.ask(RobotRequest(action="tune", joints=joints, value=value, settings=settings))
    assert not reply.ok
    assert reason in reply.reason


def test_one_wrench_sample_is_passed_on_and_several_are_averaged() -> None:
    first = ForceTorqueSample((1.0, 2.0, 3.0), (0.1, 0.2, 0.3), 5)
    second = ForceTorqueSample((3.0, 4.0, 5.0), (0.3, 0.4, 0.5), 6, saturated=True)
    assert averaged(7, [first]) == Wrench(
        stamp_ns=7, force_n=first.force_n, torque_nm=first.torque_nm, arrival_ns=5
    )
    mean = averaged(7, [first, second])
    assert mean.force_n == pytest.approx((2.0, 3.0, 4.0))
    assert mean.torque_nm == pytest.approx((0.2, 0.3, 0.4))
    assert (mean.arrival_ns, mean.saturated, mean.samples) == (6, True, 2)
