"""Joints as a command line names them."""

from collections.abc import Mapping, Sequence

from hal.wire.modes import ControlMode
from services.core.errors import ConfigError
from services.messages import JointState
from services.robotfile.robot_tables import RobotFile


def chosen_joints(robot: RobotFile, names: Sequence[str]) -> tuple[str, ...]:
    """Joints of that name or of the part of that name, each once; all where none is named.

    Raises:
        ConfigError: there is neither such a part nor such a joint.
    """
    found: dict[str, None] = {}
    for name in names or tuple(robot.parts):
        if name in robot.parts:
            found |= dict.fromkeys(robot.parts[name])
        elif any(name in joints for joints in robot.parts.values()):
            found[name] = None
        else:
            raise ConfigError(
                f"no joint or part {name!r} here; parts: {', '.join(robot.parts)}; joints: "
                f"{', '.join(joint for joints in robot.parts.values() for joint in joints)}"
            )
    return tuple(found)


def in_fault(
    robot: RobotFile, joints: Sequence[str], states: Mapping[str, JointState]
) -> tuple[str, ...]:
    """Those of the joints that their boards hold in hardware fault; `states` are by part."""
    return tuple(
        joint
        for part, state in states.items()
        for joint, mode in zip(robot.parts[part], state.control_mode, strict=True)
        if joint in joints and mode == ControlMode.HW_FAULT
    )


def able_to_comply(
    robot: RobotFile, joints: Sequence[str], names: Sequence[str]
) -> tuple[str, ...]:
    """Those of the joints that can be compliant, and those named one by one.

    Raises:
        ConfigError: there is none.
    """
    fed = {joint for sensor in robot.virtual_sensors.values() for joint in sensor.channels}
    able = tuple(
        joint
        for joint in joints
        if joint in names
        or (
            joint in fed
            and None not in (robot.joints[joint].impedance, robot.joints[joint].torque_pid)
        )
    )
    if not able:
        raise ConfigError(f"no joint of {', '.join(names) or 'this stack'} can be compliant")
    return able
