"""`ulna cartesian`: hands of a running stack go to poses, and what the controller says of it."""

import math
from collections.abc import Sequence

from rich.console import Console

from services.cli.cartesian_tables import (
    info_table,
    motion_line,
    pose_lines,
    posture_table,
    status_lines,
    verdict,
)
from services.cli.complaint import complain
from services.cli.stack_client import StackClient
from services.core.errors import ServiceError
from services.reaching.cartesian_messages import MotionState
from services.reaching.client_blocking import BlockingCartesianControl
from services.reaching.client_types import (
    MotionFailedError,
    RequestRefusedError,
    WaitTimeoutError,
    tip_pose,
)
from services.reaching.messages import TipPose
from services.streams import CARTESIAN_STATUS

REFUSED = 1
FAILED = 2
INTERRUPTED = 130
BOTH_ARMS = "both_arms"
PATIENCE_S = 30.0  # beyond the time that a motion is to take

Triple = tuple[float, float, float]
Turn = tuple[float, float, float, float]


def cartesian_status(*, limb: str = "", stack: str = "icub") -> int:
    """What the controller does, the newest motion, and where the hands are.

    Example: ulna cartesian status --limb both_arms

    Args:
        limb: right_arm, left_arm or both_arms. Default: the main job's.
        stack: name of the running stack.

    Returns:
        Exit status: 0, 1 when the pose of the limb is not known, 2 without an answer.
    """
    try:
        with StackClient(stack) as client, BlockingCartesianControl(limb, stack) as control:
            for line in status_lines(client.wait_for(CARTESIAN_STATUS), control.motion()):
                print(line)
            for line in pose_lines(control.poses()):
                print(line)
    except ServiceError as error:
        return _complain(error)
    return 0


def cartesian_go(
    *,
    position: Triple | None = None,
    rotation: Triple | None = None,
    axis_angle: Turn | None = None,
    second_position: Triple | None = None,
    second_rotation: Triple | None = None,
    limb: str = "right_arm",
    time: float = 0.0,
    nearest: bool = False,
    wait: bool = True,
    stack: str = "icub",
) -> int:
    """Move a hand to a pose, or both hands, on a straight line; by default until it is there.

    Its joints have to be calibrated (`ulna joints calibrate`) and to take set-points (`ulna joints
    direct`).

    Example: ulna cartesian go --position -0.3 0.2 0.1 --rotation -0.4 -2.4 1.8 --time 2

    Args:
        position: of the hand, m, base frame; of the left one of both arms. None: anywhere.
        rotation: its orientation as a rotation vector, rad. None: any.
        axis_angle: its orientation as axis and angle, rad, instead.
        second_position: of both arms' right hand.
        second_rotation: of both arms' right hand.
        limb: right_arm, left_arm, both_arms, or auto: the arm with the nearer hand.
        time: how long it takes, s; 0: the limb's trajectory time.
        nearest: where the pose is out of reach, go as near as can be. An orientation out of reach
            is approached without it too, with exit status 1.
        wait: until the motion is done.
        stack: name of the running stack.

    Returns:
        Exit status: 0 there, or begun, 1 refused or not reached, 2 without an answer.
    """
    second = tip_pose(second_position, second_rotation)
    wrong = _wrong_pose(position, rotation, axis_angle, second)
    if not wrong and second != TipPose() and limb != BOTH_ARMS:
        wrong = f"--second-position and --second-rotation are of --limb {BOTH_ARMS}"
    if wrong:
        complain(wrong)
        return FAILED
    try:
        poses = [tip_pose(position, axis_angle or rotation)]
        if limb == BOTH_ARMS:
            poses.append(second)
        asked = [pose if pose != TipPose() else None for pose in poses]
        with BlockingCartesianControl(limb, stack) as control:
            return _go(control, asked, time, nearest=nearest, wait=wait)
    except KeyboardInterrupt:
        complain("the motion goes on in the running stack; `ulna cartesian stop` ends it")
        return INTERRUPTED
    except ServiceError as error:
        return _complain(error)


def cartesian_position(
    x: float,
    y: float,
    z: float,
    /,
    *,
    limb: str = "right_arm",
    time: float = 0.0,
    nearest: bool = False,
    wait: bool = True,
    stack: str = "icub",
) -> int:
    """Move a hand to a position, turned as it likes; see `ulna cartesian go`.

    Example: ulna cartesian position -0.3 0.2 0.1

    Args:
        x: m, base frame: backwards.
        y: to the robot's right.
        z: up.
        limb: right_arm, left_arm, or auto: the arm with the nearer hand.
        time: how long it takes, s; 0: the limb's trajectory time.
        nearest: where the position is out of reach, go as near as can be.
        wait: until the motion is done.
        stack: name of the running stack.

    Returns:
        Exit status: 0 there, or begun, 1 refused or not reached, 2 without an answer.
    """
    return cartesian_go(
        position=(x, y, z), limb=limb, time=time, nearest=nearest, wait=wait, stack=stack
    )


def cartesian_stop(*, stack: str = "icub") -> int:
    """Bring the hand that moves to rest.

    Example: ulna cartesian stop

    Args:
        stack: name of the running stack.

    Returns:
        Exit status: 0, 1 when refused, 2 without an answer.
    """
    try:
        with BlockingCartesianControl("", stack) as control:
            control.stop()
    except ServiceError as error:
        return _complain(error)
    print("stopping")
    return 0


def cartesian_ask(
    *,
    position: Triple | None = None,
    rotation: Triple | None = None,
    axis_angle: Turn | None = None,
    limb: str = "right_arm",
    stack: str = "icub",
) -> int:
    """Show the posture that a pose would be reached with, by the limb's settings; nothing moves.

    Example: ulna cartesian ask --position -0.3 0.2 0.1

    Args:
        position: of the hand, m, base frame. None: anywhere.
        rotation: its orientation as a rotation vector, rad. None: any.
        axis_angle: its orientation as axis and angle, rad, instead.
        limb: right_arm, left_arm, or auto: the arm with the nearer hand.
        stack: name of the running stack.

    Returns:
        Exit status: 0 within reach, 1 out of reach or refused, 2 without an answer.
    """
    wrong = _wrong_pose(position, rotation, axis_angle)
    if wrong:
        complain(wrong)
        return FAILED
    try:
        with BlockingCartesianControl(limb, stack) as control:
            posture = control.ask_for_pose(position, axis_angle or rotation)
    except ServiceError as error:
        return _complain(error)
    Console().print(posture_table(posture))
    print(verdict(posture))
    if posture.answer.status == "converged" and not posture.answer.reason:
        return 0
    complain(posture.answer.reason or posture.answer.status)
    return REFUSED


def cartesian_info(*, limb: str = "", stack: str = "icub") -> int:
    """Limbs, and how one of them is used: joints, limits, rest posture, times, tolerances.

    Example: ulna cartesian info --limb left_arm

    Args:
        limb: whose settings. Default: the main job's.
        stack: name of the running stack.

    Returns:
        Exit status: 0, 1 when there is no such limb, 2 without an answer.
    """
    try:
        with BlockingCartesianControl(limb, stack) as control:
            info, settings = control.info(), control.settings()
    except ServiceError as error:
        return _complain(error)
    print(f"limbs: {', '.join(limb.name for limb in info.limbs)}, auto")
    Console().print(info_table(settings))
    print(
        f"trajectory {settings.trajectory_time_s:g} s, in target within "
        f"{settings.in_target_m * 1e3:g} mm and {math.degrees(settings.in_target_rad):g} deg, "
        f"law {settings.law}, priority {settings.priority}, "
        f"tracking {'on' if settings.tracking else 'off'}"
    )
    return 0


def _wrong_pose(
    position: Triple | None,
    rotation: Triple | None,
    axis_angle: Turn | None,
    second: TipPose | None = None,
) -> str:
    if rotation is not None and axis_angle is not None:
        return "give --rotation or --axis-angle, not both"
    if (position, rotation, axis_angle) == (None, None, None) and second in (None, TipPose()):
        return "no pose is given: --position, --rotation or --axis-angle"
    return ""


def _go(
    control: BlockingCartesianControl,
    poses: Sequence[TipPose | None],
    time_s: float,
    *,
    nearest: bool,
    wait: bool,
) -> int:
    motion: MotionState = control.go_to_poses(poses, time_s=time_s, nearest=nearest)
    if wait:
        motion = control.wait_motion_done(time_s + PATIENCE_S)
    print(motion_line(motion))
    return REFUSED if motion.out_of_reach and not nearest else 0


def _complain(error: ServiceError) -> int:
    complain(error)
    refused = (RequestRefusedError, MotionFailedError, WaitTimeoutError)
    return REFUSED if isinstance(error, refused) else FAILED
