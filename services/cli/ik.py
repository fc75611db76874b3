"""`ulna ik`: postures for poses, and how the IK service of a running stack does."""

import math
from typing import Literal

from rich.console import Console

from services.cli.complaint import complain
from services.cli.ik_client import IkClient, solve_here
from services.cli.ik_tables import answer_table, status_table, verdict
from services.config import load_robot
from services.core.errors import ConfigError, NotRunningError, ServiceError
from services.messages import Floats
from services.reaching.limb import find_limb, limb_joints
from services.reaching.messages import IkReply, IkRequest, LimbSetup, PoseTarget, TipPose
from services.robotfile.robot_tables import RobotFile
from services.streams import IK_STATUS, STATS

FAILED = 2
REFUSED = 1
STATS_PATIENCE_S = 2.5

Triple = tuple[float, float, float]


def ik_ask(
    *,
    limb: str = "",
    position: Triple | None = None,
    rotation: Triple | None = None,
    axis_angle: tuple[float, float, float, float] | None = None,
    second_position: Triple | None = None,
    second_rotation: Triple | None = None,
    dof: int | None = None,
    hold: list[str] | None = None,
    start: str = "",
    priority: Literal["position", "orientation"] = "position",
    solver: Literal["sqp", "ipopt", "fatrop"] = "sqp",
    deadline_ms: float = 0.0,
    robot: str = "",
    stack: str = "icub",
) -> int:
    """Find a posture for a pose of a hand; nothing moves.

    A running stack is asked, from the measured posture on; without one, or with --robot, the
    robot's model is solved here, from the home posture on.

    Example: ulna ik ask --limb right_arm --position -0.3 0.2 0.1 --rotation -0.4 -2.4 1.8 --dof 7

    Args:
        limb: right_arm, left_arm or both_arms. Default: the main job's.
        position: of the hand, m, base frame; of the left one of both arms. None: anywhere.
        rotation: its orientation as a rotation vector, rad. None: any.
        axis_angle: its orientation as axis and angle, rad, instead; the axis may have any length.
        second_position: of both arms' right hand.
        second_rotation: of both arms' right hand.
        dof: how many joints may move, counted from the hand: 7 leaves the waist where it is.
        hold: joints that may not move.
        start: posture to start from, A,B,C and so on, degrees, one per joint of the limb.
        priority: what is kept where a pose cannot be had as a whole.
        solver: which of the solvers.
        deadline_ms: time for the search, kept by counting its iterations. 0: the solver's own.
        robot: robot file to solve here for, whatever runs.
        stack: name of the stack that is asked if it is up.

    Returns:
        Exit status: 0 when the pose is reached, 1 when not, 2 when nothing was solved.
    """
    if rotation is not None and axis_angle is not None:
        complain("give --rotation or --axis-angle, not both")
        return FAILED
    first = TipPose(position_m=position, rotation_rad=axis_angle or rotation)
    second = TipPose(position_m=second_position, rotation_rad=second_rotation)
    given = (first, second) if second != TipPose() else (first,)
    if given == (TipPose(),):
        complain("no pose is given: --position, --rotation or --axis-angle")
        return FAILED
    try:
        client = None if robot else _client(stack)
        file = load_robot(robot or "icub") if client is None else client.robot
        request = IkRequest(
            poses=(PoseTarget(tips=given),),
            limb=limb,
            setup=LimbSetup(
                limb="", free=_free(file, limb, dof, hold or []), priority=priority, solver=solver
            ),
            start_rad=_posture(start),
            deadline_ms=deadline_ms,
        )
        if client is None:
            reply, took_ms = solve_here(file, request)
            source = f"{robot or 'icub'}'s model, no stack"
        else:
            with client:
                reply, took_ms = client.ask(request), None
            source = f"stack {stack!r}"
    except ServiceError as error:
        complain(error)
        return FAILED
    return _show(file, limb, reply, took_ms, source)


def ik_status(*, stack: str = "icub") -> int:
    """How the IK service of a running stack does: points that it follows, and requests.

    Example: ulna ik status

    Args:
        stack: name of the running stack.

    Returns:
        Exit status: 0, 2 without an answer.
    """
    try:
        with IkClient(stack) as client:
            client.bus.watch(STATS["ik"])
            report = client.wait_for(IK_STATUS)
            stats = client.next_of(STATS["ik"], STATS_PATIENCE_S)
    except ServiceError as error:
        complain(error)
        return FAILED
    Console().print(status_table(report, stats))
    for text in (report.reason, report.setup_refused and f"refused: {report.setup_refused}"):
        if text:
            print(text)
    return 0


def _show(robot: RobotFile, limb: str, reply: IkReply, took_ms: float | None, source: str) -> int:
    if not reply.ok:
        complain(reply.reason)
        return FAILED
    (answer,) = reply.answers
    name = find_limb(robot, limb).name
    Console().print(answer_table(robot, name, reply, source))
    print(verdict(answer, took_ms))
    return 0 if answer.status == "converged" and not answer.reason else REFUSED


def _client(stack: str) -> IkClient | None:
    """A client of the stack, if it is up."""
    try:
        return IkClient(stack)
    except NotRunningError:
        return None


def _posture(text: str) -> Floats:
    """Angles of --start, rad."""
    try:
        return tuple(math.radians(float(angle)) for angle in text.split(",")) if text else ()
    except ValueError as error:
        raise ConfigError(f"--start: {text!r} is no list of angles such as 0,30,-45") from error


def _free(robot: RobotFile, limb: str, dof: int | None, hold: list[str]) -> tuple[bool, ...]:
    """Which joints may move."""
    joints = limb_joints(robot, limb)
    if dof is not None and not 1 <= dof <= len(joints):
        raise ConfigError(f"--dof: {dof} is outside 1..{len(joints)}")
    for name in hold:
        if name not in joints:
            raise ConfigError(f"--hold: unknown joint {name!r}; known: {', '.join(joints)}")
    blocked = 0 if dof is None else len(joints) - dof
    return tuple(i >= blocked and name not in hold for i, name in enumerate(joints))
