"""Requests to the IK service, as several tests make them."""

import math

import numpy as np

from dforc import rotation
from services.core.testing import Bench
from services.ik import Ik
from services.messages import NAN3, CartesianStatus
from services.reaching.limb import limb_model
from services.reaching.messages import IkAnswer, IkReply, IkRequest, PoseTarget, TipPose
from services.robotfile.robot_tables import RobotFile
from services.streams import IK_CALL, JOINT_STATE
from tests.services.postures import arms_at

ARM_ALONE = (False,) * 3 + (True,) * 7
HOME_DEG = (0.0, 0.0, 0.0, -30.0, 30.0, 0.0, 45.0, 0.0, 0.0, 0.0)
HOME_RAD = tuple(math.radians(angle) for angle in HOME_DEG)


BENT = (5.0, 3.0, -8.0, -50.0, 45.0, 10.0, 70.0, 10.0, -5.0, 4.0)


def standing(robot: RobotFile) -> Bench:
    """The service, told that torso and arms are at home."""
    bench = Bench(Ik(robot))
    for part, state in arms_at(robot).items():
        bench.put(JOINT_STATE[part], state)
    return bench


def pose_of(robot: RobotFile, q_deg: tuple[float, ...], limb: str = "") -> PoseTarget:
    """The pose of the hand in a posture."""
    turned, (x, y, z) = limb_model(robot, limb).tip_pose(np.radians(q_deg))
    vector = tuple(rotation.rotation_vector(turned).tolist())
    return PoseTarget(tips=(TipPose(position_m=(x, y, z), rotation_rad=vector),))


def at(x: float, y: float, z: float) -> PoseTarget:
    """A position, whatever the orientation."""
    return PoseTarget(tips=(TipPose(position_m=(x, y, z)),))


def ask(bench: Bench, request: IkRequest) -> IkReply:
    """The reply to a request that one step answers."""
    token = bench.request(IK_CALL, request)
    replies = dict(bench.replies(IK_CALL))
    return replies[token]


def answer_to(bench: Bench, request: IkRequest) -> IkAnswer:
    """The answer to the one pose of a request."""
    reply = ask(bench, request)
    assert reply.ok, reply.reason
    (answer,) = reply.answers
    return answer


def refusal(bench: Bench, request: IkRequest) -> str:
    """Why a request is refused as a whole."""
    reply = ask(bench, request)
    assert not reply.ok
    assert reply.answers == ()
    return reply.reason


def heartbeat() -> CartesianStatus:
    """What tells the service that time goes by."""
    return CartesianStatus(
        stamp_ns=0, state="waiting", q_rad=(), hand_position_m=NAN3, hand_rotation_rad=NAN3
    )


HERE = at(-0.3, 0.2, 0.05)
