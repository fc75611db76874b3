"""What a robot file means for the HAL and for the numerics.

Descriptions, limits, rows.
"""

import math
from collections.abc import Sequence

import msgspec
import numpy as np
from numpy.typing import NDArray

from hal.description import Board, ForceTorqueSensor, Joint, RobotDescription, TorqueSource
from services.core.errors import ConfigError
from services.robot_messages import RobotRequest
from services.robotfile.model_file import model_limits_deg, urdf_path
from services.robotfile.robot_tables import JointTable, RobotFile

Vector = NDArray[np.float64]

SHOULDER_FIRMWARE = ((1, 50), (2, 50), (1, 57), (2, 57))  # exchange PID_VAL frames on the bus
BROADCAST_PID_VAL = 0x02
ADDRESSES = {"bll": 1, "bll_ie": 1, "bll_dc": 1, "dc4": 2}  # of boards that broadcast by mask


def joint_limits_deg(robot: RobotFile, name: str) -> tuple[float, float]:
    """Intersection of the model's and the robot file's limits.

    Raises:
        ConfigError: the model has no such joint, or the two do not meet.
    """
    if robot.joints[name].mechanism != "body":
        return robot.joints[name].limits_deg
    model = model_limits_deg(urdf_path(robot.robot.urdf))
    if name not in model:
        raise ConfigError(f"{robot.path}: joints.{name}: not a joint of {robot.robot.urdf}")
    low = max(model[name][0], robot.joints[name].limits_deg[0])
    high = min(model[name][1], robot.joints[name].limits_deg[1])
    if low >= high:
        raise ConfigError(f"{robot.path}: joints.{name}.limits_deg: no overlap with the model's")
    return low, high


def chain_limits_rad(robot: RobotFile, joints: Sequence[str]) -> tuple[Vector, Vector]:
    """Lower and upper limits of a chain of joints, shape (n,) each."""
    limits = np.radians([joint_limits_deg(robot, name) for name in joints])
    return limits[:, 0].copy(), limits[:, 1].copy()


def chain_rows_rad(
    robot: RobotFile, joints: Sequence[str]
) -> tuple[NDArray[np.float64], Vector, Vector]:
    """The linear rows that lie within a chain of joints.

    A (m, n), lower and upper bounds (m,) in radians, infinite where open.
    """
    at = {joint: column for column, joint in enumerate(joints)}
    rows = [row for row in robot.rows if set(row.coefficients) <= set(at)]
    matrix = np.zeros((len(rows), len(at)))
    for i, row in enumerate(rows):
        for joint, coefficient in row.coefficients.items():
            matrix[i, at[joint]] = coefficient
    lower = np.radians([row.lower_deg for row in rows])
    upper = np.radians([row.upper_deg for row in rows])
    return matrix, lower, upper


def robot_description(robot: RobotFile) -> RobotDescription:
    """The HAL's view of the robot, joints in the order of the chain's parts."""
    return RobotDescription(
        name=robot.robot.name,
        boards=tuple(_board(robot, name) for name in robot.boards),
        joints=tuple(
            _joint(robot, part, name) for part, names in robot.parts.items() for name in names
        ),
        sensors=tuple(_sensor(robot, name) for name in robot.sensors),
        velocity_shift=robot.host.velocity_shift,
        speed_estimate_shift=robot.host.speed_estimate_shift,
        velocity_timeout_ms=robot.host.velocity_timeout_ms,
        allow_missing=robot.allow_missing,
    )


def parked(robot: RobotFile, request: RobotRequest) -> RobotRequest:
    """A request to stop, with the posture to come down to where it names none."""
    joints = request.joints or tuple(joint for names in robot.parts.values() for joint in names)
    if request.action != "stop" or request.q_rad or not set(joints) <= set(robot.joints):
        return request
    posture = tuple(math.radians(robot.joints[joint].park_deg) for joint in joints)
    return msgspec.structs.replace(request, joints=joints, q_rad=posture)


def firmware_of(robot: RobotFile, board: str) -> tuple[int, int]:
    """Firmware number as the board reports it: 2.57 is (0x02, 0x57), a BCD-like word."""
    major, minor = robot.boards[board].firmware.split(".")
    return int(major, 16), int(minor, 16)


def _board(robot: RobotFile, name: str) -> Board:
    table = robot.boards[name]
    mask = table.broadcast
    shoulder = tuple(int(n) for n in table.firmware.split(".")) in SHOULDER_FIRMWARE
    masks = (mask | (BROADCAST_PID_VAL if shoulder else 0),) * ADDRESSES.get(table.type, 0)
    return Board(
        name=name,
        bus=robot.buses[table.bus].number,
        address=table.address,
        type=table.type,
        firmware=firmware_of(robot, name),
        broadcast=masks,
        period_ms=table.period_ms,
        frame=table.frame,
        required=_is_required(robot, name),
        coupled=table.coupled,
    )


def _is_required(robot: RobotFile, board: str) -> bool:
    """A real board of a robot that is emulated otherwise may be plugged in while it runs."""
    mixed = any(robot.is_simulated(other) for other in robot.boards)
    return robot.boards[board].required and (robot.is_simulated(board) or not mixed)


def _joint(robot: RobotFile, part: str, name: str) -> Joint:
    table = robot.joints[name]
    low, high = joint_limits_deg(robot, name)
    bus, address, axis = robot.axis_place(name)
    return Joint(
        name=name,
        part=part,
        bus=bus,
        address=address,
        axis=axis,
        ticks_per_deg=table.ticks_per_deg,
        zero_deg=table.zero_deg,
        min_deg=low,
        max_deg=high,
        margin_deg=table.limit_margin_deg,
        max_velocity_deg_s=table.max_velocity_deg_s,
        position_pid=table.position_pid,
        current_limit_ma=table.current_limit_ma,
        pwm_limit=table.pwm_limit,
        calibration=table.calibration,
        torque_pid=table.torque_pid,
        impedance=table.impedance,
        torque_source=_torque_source(robot, name, table),
        motor_nm=_motor_nm(robot, table),
    )


def _motor_nm(robot: RobotFile, table: JointTable) -> float:
    motor = robot.motors[table.motor]
    nm_per_a = motor.torque_constant_nm_a.value * motor.gear.value
    return nm_per_a * motor.supply_v.value / motor.resistance_ohm.value


def _torque_source(robot: RobotFile, name: str, table: JointTable) -> TorqueSource | None:
    for virtual in robot.virtual_sensors.values():
        if name in virtual.channels and virtual.bus == robot.boards[table.board].bus:
            return TorqueSource(
                address=virtual.address,
                channel=virtual.channels.index(name),
                full_scale_nm=virtual.full_scale_nm,
            )
    return None


def _sensor(robot: RobotFile, name: str) -> ForceTorqueSensor:
    table = robot.sensors[name]
    board = robot.boards[table.board]
    return ForceTorqueSensor(
        name=name,
        frame=table.frame,
        bus=robot.buses[board.bus].number,
        address=board.address,
        full_scale=table.full_scale,
    )
