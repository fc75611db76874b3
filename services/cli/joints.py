"""`ulna joints`: the joints of a running stack, and what can be asked of them."""

import math
from collections.abc import Sequence

from rich.console import Console

from services.cli.complaint import complain
from services.cli.joint_names import able_to_comply, chosen_joints, in_fault
from services.cli.joint_requests import RefusedError, carry_out
from services.cli.joint_tables import joint_table
from services.cli.stack_client import StackClient
from services.core.errors import ConfigError, ServiceError
from services.messages import JointState
from services.robot_messages import RobotRequest
from services.streams import JOINT_STATE, ROBOT_STATUS

REFUSED = 1
FAILED = 2
INTERRUPTED = 130
HOME_S = 3.0


def joints_status(*names: str, stack: str = "icub") -> int:
    """Angle, speed, torque and mode of joints, once.

    Example: ulna joints status right_arm

    Args:
        names: joints or parts. Default: all.
        stack: name of the running stack.

    Returns:
        Exit status: 0 when every part's joints are valid, 1 when not, 2 without an answer.
    """
    try:
        with StackClient(stack) as client:
            robot = client.robot
            joints = chosen_joints(robot, names)
            status = client.wait_for(ROBOT_STATUS)
            states = _states(client, joints)
    except ServiceError as error:
        complain(error)
        return FAILED
    Console().print(joint_table(robot, joints, states, status))
    return 0 if all(state.valid for state in states.values()) else REFUSED


def joints_calibrate(*names: str, again: bool = False, stack: str = "icub") -> int:
    """Find the zeros of joints and switch them on: position mode, stiff. They may move.

    Joints that are calibrated are only switched on.

    Example: ulna joints calibrate right_arm

    Args:
        names: joints or parts. Default: all.
        again: calibrate those anew that are calibrated.
        stack: name of the running stack.

    Returns:
        Exit status: 0 done, 1 refused or failed, 2 without an answer.
    """
    return _request("calibrate", names, stack, value="again" if again else "")


def joints_home(*, stack: str = "icub") -> int:
    """Move the reaching chain to the posture that reaching starts from, in 3 s.

    Example: ulna joints home

    Args:
        stack: name of the running stack.

    Returns:
        Exit status: 0 done, 1 refused or failed, 2 without an answer.
    """
    return _request("move", (), stack)


def joints_direct(*names: str, stack: str = "icub") -> int:
    """Have joints take set-points as they come: position-direct mode, as the hands' control needs.

    Example: ulna joints direct torso right_arm

    Args:
        names: joints or parts. Default: all.
        stack: name of the running stack.

    Returns:
        Exit status: 0 done, 1 refused or failed, 2 without an answer.
    """
    return _request("mode", names, stack, value="direct")


def joints_compliant(*names: str, stack: str = "icub") -> int:
    """Let joints give way to a push like springs; their torques have to be known.

    Example: ulna joints compliant r_elbow r_wrist_prosup

    Args:
        names: joints, or parts for those of their joints that can. Default: all that can.
        stack: name of the running stack.

    Returns:
        Exit status: 0 done, 1 refused or failed, 2 without an answer.
    """
    return _request("interaction", names, stack, value="compliant")


def joints_stiff(*names: str, stack: str = "icub") -> int:
    """Have joints hold their position with all that they have.

    Example: ulna joints stiff right_arm

    Args:
        names: joints or parts. Default: all.
        stack: name of the running stack.

    Returns:
        Exit status: 0 done, 1 refused or failed, 2 without an answer.
    """
    return _request("interaction", names, stack, value="stiff")


def joints_park(*names: str, stack: str = "icub") -> int:
    """End all tasks, bring joints down to where they rest, and switch them off; 3 s at most.

    Example: ulna joints park

    Args:
        names: joints or parts. Default: all.
        stack: name of the running stack.

    Returns:
        Exit status: 0 done, 1 refused or failed, 2 without an answer.
    """
    return _request("stop", names, stack)


def _request(action: str, names: Sequence[str], stack: str, value: str = "") -> int:
    word = {"interaction": value, "mode": value, "move": "home", "stop": "park"}.get(action, action)
    try:
        with StackClient(stack) as client:
            request = _prepared(client, action, names, value)
            carry_out(client, word, request)
            if action == "interaction":
                _check_able(client, word, request.joints)
    except RefusedError as error:
        complain(error)
        return REFUSED
    except ServiceError as error:
        complain(error)
        return FAILED
    except KeyboardInterrupt:
        complain(f"{word} goes on in the running stack; `ulna joints park` ends it")
        return INTERRUPTED
    count = len(request.joints)
    print(f"{word}: done, {count} joint{'' if count == 1 else 's'}")
    return 0


def _check_able(client: StackClient, word: str, joints: Sequence[str]) -> None:
    """Boards take stiff and compliant also of a joint in hardware fault, which then does neither.

    Raises:
        RefusedError: there is such a joint.
    """
    faulty = in_fault(client.robot, joints, _states(client, joints))
    if faulty:
        raise RefusedError(
            f"{word}: {len(faulty)} of {len(joints)} joints stay in hardware fault, without power: "
            f"{', '.join(faulty)}; once the cause is gone `ulna joints calibrate` switches on again"
        )


def _states(client: StackClient, joints: Sequence[str]) -> dict[str, JointState]:
    """Of every part that one of the joints belongs to."""
    parts = client.robot.parts
    return {
        part: client.wait_for(JOINT_STATE[part]) for part in parts if set(joints) & set(parts[part])
    }


def _prepared(client: StackClient, action: str, names: Sequence[str], value: str) -> RobotRequest:
    robot = client.robot
    if action == "move":
        if not robot.can_reach:
            parts = ", ".join(robot.reach.parts)
            raise ConfigError(f"home is a posture of {parts}, and the stack has not all of them")
        home_rad = tuple(math.radians(angle) for angle in robot.reach.home_deg)
        return RobotRequest(action=action, joints=robot.chain, q_rad=home_rad, duration_s=HOME_S)
    joints = chosen_joints(robot, names)
    if value == "compliant":
        joints = able_to_comply(robot, joints, names)
    return RobotRequest(action=action, joints=joints, value=value)
