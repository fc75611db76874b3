"""Joints as a command line names them."""

from collections.abc import Sequence

from services.core.errors import ConfigError
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
