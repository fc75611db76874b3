"""Checks of a robot file that one table alone cannot make: references, addresses, signs."""

from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np

from services.core.errors import ConfigError
from services.robotfile.robot_tables import JointTable, LimbTable, RobotFile

RATED_STREAMS = ("hal", "wrench", "joint_state", "plant_truth")
MOST_GAIN = 1000.0  # determinant: three times too much in each of six channels
BOARD_AXES = {"bll": 2, "bll_ie": 2, "bll_dc": 2, "dc4": 4}


def check_references(robot: RobotFile) -> None:
    """Refuse names that point nowhere, addresses used twice, and signs of positive feedback."""
    for name, board in robot.boards.items():
        _known(robot, f"boards.{name}.bus", board.bus, robot.buses)
        _within(robot, f"boards.{name}.address", board.address, 1, 14)
        _firmware(robot, name, board.firmware)
    _check_addresses(robot)
    for name, sensor in robot.sensors.items():
        _known(robot, f"sensors.{name}.board", sensor.board, robot.boards)
        if sensor.behind:
            _known(robot, f"sensors.{name}.behind", sensor.behind, robot.joints)
        check_gain(sensor.gain, robot.path, f"sensors.{name}.gain")
    _check_rates(robot)
    _check_names(robot)
    for name, joint_table in robot.joints.items():
        _check_joint(robot, name, joint_table)
    _check_limbs(robot)


def check_gain(gain: Sequence[float], path: Path, key: str) -> None:
    """Refuse what is no matrix, or so far from the identity that no sensor is so wrong."""
    if not gain:
        return
    if len(gain) != 36:
        raise ConfigError(f"{path}: {key}: has {len(gain)} numbers; six rows of six are needed")
    size = float(np.linalg.det(np.reshape(np.array(gain, dtype=np.float64), (6, 6))))
    if not 1.0 / MOST_GAIN <= size <= MOST_GAIN:
        raise ConfigError(
            f"{path}: {key}: determinant {size:.2g}; a gain is near the identity, whose is 1"
        )


def _check_names(robot: RobotFile) -> None:
    """Names in virtual sensors, parts and selections."""
    for name, virtual in robot.virtual_sensors.items():
        _known(robot, f"virtual_sensors.{name}.bus", virtual.bus, robot.buses)
        for joint in virtual.channels:
            _known(robot, f"virtual_sensors.{name}.channels", joint, robot.joints)
    for part, joints in robot.parts.items():
        for joint in joints:
            _known(robot, f"parts.{part}", joint, robot.joints)
    for name, parts in robot.selections.items():
        for part in parts:
            _known(robot, f"selections.{name}", part, dict.fromkeys(robot.groups))


def _check_rates(robot: RobotFile) -> None:
    for stream in RATED_STREAMS:
        if stream not in robot.rates:
            _refuse(robot, f"rates.{stream}", "this table is missing")
        rate = robot.rates[stream]
        _within(robot, f"rates.{stream}.virtual_hz", rate.virtual_hz, 1, 1000)
        _within(robot, f"rates.{stream}.live_hz", rate.live_hz, 1, 1000)


def _check_joint(robot: RobotFile, name: str, joint: JointTable) -> None:
    key = f"joints.{name}"
    _known(robot, f"{key}.board", joint.board, robot.boards)
    _known(robot, f"{key}.motor", joint.motor, robot.motors)
    axes = BOARD_AXES.get(robot.boards[joint.board].type, 0)
    _within(robot, f"{key}.axis", joint.axis, 0, axes - 1)
    if joint.ticks_per_deg == 0.0:
        _refuse(robot, f"{key}.ticks_per_deg", "must not be 0")
    if joint.limits_deg[0] >= joint.limits_deg[1]:
        _refuse(robot, f"{key}.limits_deg", f"lower {joint.limits_deg[0]} is not below upper")
    low, high = joint.limits_deg
    if not low <= joint.park_deg <= high:
        _refuse(robot, f"{key}.park_deg", f"{joint.park_deg} is outside {low}..{high}")
    _within(robot, f"{key}.pwm_limit", joint.pwm_limit, 1, 1333)
    if (joint.mechanism == "tendon") != bool(joint.fingers):
        _refuse(robot, f"{key}.fingers", "a tendon pulls some, and nothing else does")
    positive = joint.position_pid.kp * joint.ticks_per_deg > 0
    if positive != (joint.motor_polarity > 0):
        _refuse(
            robot,
            f"{key}.position_pid.kp",
            "positive feedback: sign(kp * ticks_per_deg) must equal motor_polarity",
        )
    if joint.torque_pid and (joint.torque_pid.kp > 0) != (joint.motor_polarity > 0):
        _refuse(
            robot,
            f"{key}.torque_pid.kp",
            "positive feedback: sign(kp) must equal motor_polarity",
        )


def _check_limbs(robot: RobotFile) -> None:
    _known(robot, "reach.limb", robot.main_job.limb, robot.limb_tables)
    for name, limb in robot.limb_tables.items():
        _check_limb(robot, f"limbs.{name}", limb)
    for row in robot.rows:
        for joint in row.coefficients:
            _known(robot, f"rows.{row.name}.coefficients", joint, robot.joints)
        if not any(row.coefficients.values()):
            _refuse(robot, f"rows.{row.name}.coefficients", "one must not be 0")


def _check_limb(robot: RobotFile, key: str, limb: LimbTable) -> None:
    if len(set(limb.parts)) != len(limb.parts) or not limb.parts:
        _refuse(robot, f"{key}.parts", "needs parts, each once")
    for part in limb.parts:
        _known(robot, f"{key}.parts", part, robot.parts)
    _known(robot, f"{key}.sensor", limb.sensor, robot.sensors)
    joints = dict.fromkeys(joint for part in limb.parts for joint in robot.parts[part])
    for joint in limb.compliant:
        _known(robot, f"{key}.compliant", joint, joints)
    for field in ("home_deg", "rest_deg", "rest_weights"):
        if len(getattr(limb, field)) != len(joints):
            wanted = f"needs {len(joints)} values, one per joint of {', '.join(limb.parts)}"
            _refuse(robot, f"{key}.{field}", wanted)
    if min(limb.rest_weights) < 0.0:
        _refuse(robot, f"{key}.rest_weights", "must not be negative")
    for field in ("rest_beta", "trajectory_time_s"):
        if getattr(limb, field) <= 0.0:
            _refuse(robot, f"{key}.{field}", "must be above 0")


def _check_addresses(robot: RobotFile) -> None:
    numbers: dict[int, str] = {}
    for name, bus in robot.buses.items():
        if numbers.setdefault(bus.number, name) != name:
            _refuse(robot, f"buses.{name}.number", f"{bus.number} is {numbers[bus.number]}'s")
    taken: dict[tuple[str, int], str] = {}
    for name, board in robot.boards.items():
        for address in range(board.address, board.address + (2 if board.type == "dc4" else 1)):
            other = taken.setdefault((board.bus, address), name)
            if other != name:
                _refuse(
                    robot, f"boards.{name}.address", f"{address} on bus {board.bus} is {other}'s"
                )


def _firmware(robot: RobotFile, name: str, text: str) -> None:
    major, dot, minor = text.partition(".")
    if not (dot and major.isdigit() and minor.isdigit()):
        _refuse(
            robot, f"boards.{name}.firmware", f"{text!r} is not of the form major.minor, e.g. 2.50"
        )


def _known(robot: RobotFile, key: str, value: str, allowed: Mapping[str, object]) -> None:
    if value not in allowed:
        _refuse(robot, key, f"unknown name {value!r}; allowed: {', '.join(allowed)}")


def _within(robot: RobotFile, key: str, value: int, low: int, high: int) -> None:
    if not low <= value <= high:
        _refuse(robot, key, f"{value} is outside {low}..{high}")


def _refuse(robot: RobotFile, key: str, why: str) -> None:
    raise ConfigError(f"{robot.path}: {key}: {why}")
