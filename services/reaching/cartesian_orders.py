"""Requests to the Cartesian controller that need inverse kinematics or move a limb.

A request to move is answered once the motion begins, or with the reason why it does not. The newest
one counts: one before it that waits is refused, and so is every one that waits when a stop comes;
answers of inverse kinematics that belong to them are dropped.
"""

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass

import msgspec
import numpy as np

from dforc.cartesian.targets import ReachTarget, SpeedTarget, TipSpeed
from services.core.clock import NS_PER_S
from services.core.service import Inputs, Outputs
from services.messages import Floats
from services.reaching.cartesian_errors import RefusedError
from services.reaching.cartesian_messages import CartesianReply, CartesianRequest
from services.reaching.ik_questions import IkQuestions
from services.reaching.ik_targets import Targets, pose_targets
from services.reaching.limb_control import LimbControl
from services.reaching.limb_driver import LimbDriver
from services.reaching.limb_names import AUTO, LimbNames
from services.reaching.limb_readings import LimbReadings
from services.reaching.limb_settings import LONGEST_TRAJECTORY_S, SHORTEST_TRAJECTORY_S
from services.reaching.messages import IkAnswer, PoseTarget, TipPose
from services.reaching.pose_keeping import PoseKeeping
from services.reaching.tip_poses import reached_poses, tip_pose
from services.streams import CARTESIAN_CALL

PATIENCE_NS = 4 * NS_PER_S  # with inverse kinematics and a hand that has to stop first
FARTHEST_M = 10.0  # beyond it no number is meant as a place to go to
VELOCITY_S = 0.5
LONGEST_VELOCITY_S = 10.0


@dataclass(slots=True, kw_only=True)
class Move:
    """A request to move that is not answered yet."""

    token: int
    limb: str
    by_ns: int
    question: int = 0  # token of inverse kinematics
    begin: Callable[[int], CartesianReply] | None = None  # once nothing but a limb is waited for


class CartesianOrders:
    """Takes requests, speaks with inverse kinematics, and starts the driver."""

    def __init__(
        self,
        limbs: Mapping[str, LimbControl],
        names: LimbNames,
        driver: LimbDriver,
        readings: LimbReadings,
    ) -> None:
        self._limbs = limbs
        self._names = names
        self._driver = driver
        self._readings = readings
        self._questions = IkQuestions()
        self._keeping = PoseKeeping(driver, self._questions)
        self._move: Move | None = None
        self._outputs: Outputs

    def take(self, now_ns: int, token: int, request: CartesianRequest, outputs: Outputs) -> None:
        """A request of this kind.

        Raises:
            ServiceError: refused, and why.
        """
        self._outputs = outputs
        if request.action == "go":
            self._go(now_ns, token, request)
        elif request.action == "velocity":
            self._velocity(now_ns, token, request)
        elif request.action == "ask":
            self._ask(token, request)
        else:
            self._stop(now_ns, token)

    def advance(self, now_ns: int, inputs: Inputs, outputs: Outputs) -> None:
        """Look at answers, and at what waits."""
        self._outputs = outputs
        self._questions.hear(now_ns, inputs)
        move = self._move
        if move is not None and now_ns > move.by_ns:
            what = "no limb comes to rest" if move.begin else "inverse kinematics does not answer"
            self._refuse(f"{what} within {PATIENCE_NS / NS_PER_S:g} s")
        elif move is not None and move.begin is not None:
            self._begin(now_ns, move, move.begin)
        self._keeping.look(self._readings.of(self._driver.limb), outputs)

    def _go(self, now_ns: int, token: int, request: CartesianRequest) -> None:
        limb = self._chosen(request)
        control = self._ready(limb)
        targets = checked_targets(request.poses, control)
        duration_s = request.duration_s or control.settings.trajectory_time_s
        if not SHORTEST_TRAJECTORY_S <= duration_s <= LONGEST_TRAJECTORY_S:
            span = f"{SHORTEST_TRAJECTORY_S:g} to {LONGEST_TRAJECTORY_S:g} s"
            raise RefusedError(f"a motion takes {span}, not {duration_s} s")
        start = tuple(control.start_posture(self._readings.recent(limb)).tolist())

        def heard(now_ns: int, answer: IkAnswer | None, reason: str) -> None:  # noqa: ARG001
            if answer is None or not is_good_enough(answer, request.nearest):
                self._refuse(why_not(answer, reason), answer)
                return
            q = np.array(answer.q_rad)
            target = ReachTarget(tips=reached_poses(control.problem.tips, targets, q), q_rad=q)

            def begin(now_ns: int) -> CartesianReply:
                self._driver.go(now_ns, limb, target, duration_s, answer.reason)
                self._keeping.begin(request.poses, self._readings.recent(limb))
                motion = self._driver.motions.current
                return CartesianReply(
                    ok=True, reason=reason, limb=limb, motion=motion, answer=answer
                )

            move.begin = begin

        question = self._questions.ask(self._outputs, control, request.poses, start, heard)
        move = self._instead(now_ns, token, limb)
        move.question = question

    def _velocity(self, now_ns: int, token: int, request: CartesianRequest) -> None:
        limb = self._names.one(request.limb)
        control = self._ready(limb)
        duration_s = request.duration_s or VELOCITY_S
        if not 0.0 < duration_s <= LONGEST_VELOCITY_S:
            most = f"{LONGEST_VELOCITY_S:g} s"
            raise RefusedError(f"a velocity holds for at most {most}, not {duration_s} s")
        speeds = checked_speeds(request, control)

        def begin(now_ns: int) -> CartesianReply:
            self._driver.move(now_ns, limb, speeds, duration_s)
            return CartesianReply(ok=True, limb=limb)

        self._instead(now_ns, token, limb).begin = begin

    def _ask(self, token: int, request: CartesianRequest) -> None:
        limb = self._chosen(request)
        control = self._limbs[limb]
        checked_targets(request.poses, control)
        start = request.start_rad or self._measured(limb)
        if len(start) != control.shape.n or not all(math.isfinite(q) for q in start):
            raise RefusedError(f"a posture of {limb} has {control.shape.n} angles, not {start}")

        def heard(now_ns: int, answer: IkAnswer | None, reason: str) -> None:  # noqa: ARG001
            told = CartesianReply(
                ok=answer is not None, reason=reason, limb=limb, joints=control.shape.joints
            )
            if answer is not None:
                q = np.array(answer.q_rad)
                poses = tuple(tip_pose(tip.pose(q)) for tip in control.problem.tips)
                told = msgspec.structs.replace(told, poses=poses, q_rad=answer.q_rad, answer=answer)
            self._outputs.reply(CARTESIAN_CALL, token, told)

        self._questions.ask(self._outputs, control, request.poses, start, heard)

    def _stop(self, now_ns: int, token: int) -> None:
        self._refuse("a stop came before the motion began")
        self._driver.stop(now_ns, "stopped", "by request")
        motion = self._driver.motions.current
        told = CartesianReply(ok=True, limb=self._driver.limb, motion=motion)
        self._outputs.reply(CARTESIAN_CALL, token, told)

    def _chosen(self, request: CartesianRequest) -> str:
        """The limb of a request with poses; for auto the arm with the nearer hand."""
        if request.limb != AUTO:
            return self._names.one(request.limb)
        pose = request.poses[0] if len(request.poses) == 1 else None
        place = None if pose is None else pose.position_m
        if place is None or not is_place(place):
            raise RefusedError("auto chooses the hand by the position of one pose")
        hands = {}
        for arm in self._names.arms:
            reading, tip = self._readings.recent(arm), self._limbs[arm].problem.tips[0]
            if not reading.missing:
                hands[arm] = tip.pose(np.array(reading.q_rad))[1]
        if not hands:
            raise RefusedError(f"the place of no hand is known: {reading.missing}")
        return self._names.nearest(place, hands)

    def _measured(self, limb: str) -> Floats:
        reading = self._readings.recent(limb)
        if reading.missing:
            raise RefusedError(f"no posture to start from: {reading.missing}")
        return reading.q_rad

    def _ready(self, limb: str) -> LimbControl:
        """A limb that takes set-points."""
        control, reading = self._limbs[limb], self._readings.recent(limb)
        if reading.missing:
            raise RefusedError(f"{limb} cannot move: {reading.missing}")
        other = reading.not_direct(control.shape.joints, control.free)
        if other:
            raise RefusedError(f"{limb} cannot move: {other}")
        if not any(control.free):
            raise RefusedError(f"{limb} cannot move: all its joints are blocked")
        return control

    def _instead(self, now_ns: int, token: int, limb: str) -> Move:
        """A new move in the place of the one that waits."""
        self._refuse("a newer request took its place")
        self._move = Move(token=token, limb=limb, by_ns=now_ns + PATIENCE_NS)
        return self._move

    def _begin(self, now_ns: int, move: Move, begin: Callable[[int], CartesianReply]) -> None:
        if not self._driver.may_take(move.limb):
            self._driver.stop(now_ns, "replaced", f"{move.limb} is to move")
            return
        try:
            self._ready(move.limb)
        except RefusedError as error:
            self._refuse(str(error))
            return
        self._move = None
        self._outputs.reply(CARTESIAN_CALL, move.token, begin(now_ns))

    def _refuse(self, reason: str, answer: IkAnswer | None = None) -> None:
        """The move that waits does not begin."""
        move, self._move = self._move, None
        if move is not None:
            self._questions.drop(move.question)
            told = CartesianReply(ok=False, reason=reason, limb=move.limb, answer=answer)
            self._outputs.reply(CARTESIAN_CALL, move.token, told)


def is_place(position_m: tuple[float, float, float]) -> bool:
    """Whether a hand could be meant to go there; NaN is none."""
    return all(abs(x) < FARTHEST_M for x in position_m)


def is_good_enough(answer: IkAnswer, nearest: bool) -> bool:
    """Whether to go to an answer; `nearest` is content with the nearest posture there is."""
    return answer.status == "converged" or (nearest and answer.status == "infeasible")


def why_not(answer: IkAnswer | None, reason: str) -> str:
    """Why a move does not begin, for who asked for it."""
    if answer is None:
        return reason
    what = "out of reach" if answer.status == "infeasible" else "no posture found in time"
    return f"{what}: {reason}" if reason else what


def checked_targets(poses: tuple[TipPose | None, ...], control: LimbControl) -> Targets:
    """Poses as the numerics take them, one per tip.

    Raises:
        ServiceError: the wrong number, nothing asked for, or numbers that are no pose.
    """
    tips = control.shape.tips
    if len(poses) != len(tips):
        raise RefusedError(f"{len(poses)} poses for {len(tips)} tips ({', '.join(tips)})")
    for pose in poses:
        if pose is not None and pose.position_m is not None and not is_place(pose.position_m):
            raise RefusedError(f"{pose.position_m} m is no place to go to")
    return pose_targets(PoseTarget(tips=poses), len(tips))


def checked_speeds(request: CartesianRequest, control: LimbControl) -> SpeedTarget:
    """Velocities as the numerics take them, one per tip.

    Raises:
        RefusedError: the wrong number, or numbers that are none.
    """
    tips = control.shape.tips
    if len(request.velocities) != len(tips):
        raise RefusedError(f"{len(request.velocities)} velocities for {len(tips)} tips")
    for tip in request.velocities:
        if not all(math.isfinite(x) for x in (*tip.linear_m_s, *tip.angular_rad_s)):
            raise RefusedError(f"{tip} is no velocity")
    return SpeedTarget(
        tips=tuple(
            TipSpeed(linear_m_s=tip.linear_m_s, angular_rad_s=tip.angular_rad_s)
            for tip in request.velocities
        )
    )
