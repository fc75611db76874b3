"""The dynamics service: nothing before the offset is known, then torques and gravity."""

import msgspec
import numpy as np
import pytest

from services.core.testing import Bench
from services.dynamics import Dynamics
from services.limb import limb_model
from services.messages import FtRequest, JointState, Wrench
from services.robot_tables import RobotFile
from services.streams import (
    DYNAMICS_STATUS,
    FT_CALL,
    IMPEDANCE_OFFSET,
    JOINT_STATE,
    TORQUE_ESTIMATE,
    WRENCH,
)

SENSOR = "r_arm_ft"
OFFSET = np.array([1.5, -1.0, 0.7, 0.05, -0.08, 0.02])


def reading(robot: RobotFile, stamp_ns: int = 0, fault: float = 0.0) -> Wrench:
    """What the sensor shows at home, at rest and without contact, with its offset."""
    model = limb_model(robot)
    zero = np.zeros(len(robot.chain))
    wrench = model.sensor_wrench(np.radians(robot.reach.home_deg), zero, zero, SENSOR) + OFFSET
    fx, fy, fz, mx, my, mz = (wrench + fault).tolist()
    return Wrench(
        stamp_ns=stamp_ns, force_n=(fx, fy, fz), torque_nm=(mx, my, mz), arrival_ns=stamp_ns
    )


@pytest.fixture
def bench(robot: RobotFile, home: dict[str, JointState]) -> Bench:
    bench = Bench(Dynamics(robot))
    for part, state in home.items():
        bench.put(JOINT_STATE[part], state)
    return bench


def calibrated(robot: RobotFile, bench: Bench) -> None:
    bench.request(FT_CALL, FtRequest(samples=10))
    for _ in range(10):
        bench.put(WRENCH[SENSOR], reading(robot))


def test_is_silent_before_the_offset_is_known(robot: RobotFile, bench: Bench) -> None:
    bench.put(WRENCH[SENSOR], reading(robot))
    assert bench.sent(TORQUE_ESTIMATE["right_arm"]) == []


def test_torque_at_rest_is_gravity_once_the_offset_is_removed(
    robot: RobotFile, bench: Bench
) -> None:
    calibrated(robot, bench)
    bench.put(WRENCH[SENSOR], reading(robot))
    gravity = limb_model(robot).gravity(np.radians(robot.reach.home_deg))
    estimate = bench.last(TORQUE_ESTIMATE["right_arm"])
    assert estimate.tau_nm == pytest.approx(gravity[3:], abs=1e-6)
    bench.clock.sleep_until(20_000_000)
    bench.put(WRENCH[SENSOR], reading(robot))
    status = bench.last(DYNAMICS_STATUS)
    assert status.external_force_n == pytest.approx((0.0, 0.0, 0.0), abs=1e-6)
    assert status.tau_nm == pytest.approx(gravity, abs=1e-6)
    assert bench.last(IMPEDANCE_OFFSET["torso"]).tau_nm == pytest.approx(gravity[:3], abs=1e-6)


def test_reading_that_is_not_finite_is_refused_and_counted(robot: RobotFile, bench: Bench) -> None:
    calibrated(robot, bench)
    before = len(bench.sent(TORQUE_ESTIMATE["right_arm"]))
    bench.put(WRENCH[SENSOR], reading(robot, fault=float("nan")))
    bench.clock.sleep_until(100_000_000)
    bench.request(FT_CALL, FtRequest(samples=10))
    assert len(bench.sent(TORQUE_ESTIMATE["right_arm"])) == before
    assert bench.last(DYNAMICS_STATUS).refused == 1


def test_old_joint_state_stops_the_estimate(robot: RobotFile, bench: Bench) -> None:
    calibrated(robot, bench)
    before = len(bench.sent(TORQUE_ESTIMATE["right_arm"]))
    bench.clock.sleep_until(50_000_000)
    bench.put(WRENCH[SENSOR], reading(robot))
    assert len(bench.sent(TORQUE_ESTIMATE["right_arm"])) == before


def test_stream_goes_on_during_a_later_calibration(robot: RobotFile, bench: Bench) -> None:
    calibrated(robot, bench)
    bench.request(FT_CALL, FtRequest(samples=1000))
    before = len(bench.sent(TORQUE_ESTIMATE["right_arm"]))
    bench.put(WRENCH[SENSOR], reading(robot))
    assert len(bench.sent(TORQUE_ESTIMATE["right_arm"])) == before + 1


def test_unknown_sensor_is_refused_by_name(bench: Bench) -> None:
    bench.request(FT_CALL, FtRequest(sensors=("l_arm_ft",)))
    _, reply = bench.replies(FT_CALL)[-1]
    assert not reply.ok
    assert "l_arm_ft" in reply.reason


def test_joints_of_the_wrong_number_are_refused(
    robot: RobotFile, home: dict[str, JointState], bench: Bench
) -> None:
    calibrated(robot, bench)
    before = len(bench.sent(TORQUE_ESTIMATE["right_arm"]))
    short = msgspec.structs.replace(home["torso"], q_rad=(0.0,), dq_rad_s=(0.0,))
    bench.put(JOINT_STATE["torso"], short)
    bench.put(WRENCH[SENSOR], reading(robot))
    bench.request(FT_CALL, FtRequest(samples=10))
    bench.put(WRENCH[SENSOR], reading(robot))
    assert len(bench.sent(TORQUE_ESTIMATE["right_arm"])) == before


@pytest.mark.parametrize("trouble", ["saturated", "frozen"])
def test_a_sensor_that_repeats_itself_gives_no_torque(
    robot: RobotFile, bench: Bench, trouble: str
) -> None:
    calibrated(robot, bench)
    before = len(bench.sent(TORQUE_ESTIMATE["right_arm"]))
    bench.put(WRENCH[SENSOR], msgspec.structs.replace(reading(robot), **{trouble: True}))
    assert len(bench.sent(TORQUE_ESTIMATE["right_arm"])) == before
    bench.put(WRENCH[SENSOR], reading(robot))
    assert len(bench.sent(TORQUE_ESTIMATE["right_arm"])) == before + 1
