"""Hands that go to poses through HAL, CAN frames, boards and physics, in virtual time."""

from collections.abc import Sequence

import numpy as np
import pytest

from dforc import rotation
from dforc.arrays import Vector
from services.config import load_robot
from services.core.service import CallFailed, Period
from services.emulated.messages import PlantTruth
from services.emulated.simulation import Simulation
from services.reaching.cartesian_messages import (
    CartesianEvent,
    CartesianReply,
    CartesianRequest,
    MotionState,
)
from services.reaching.limb import find_limb, limb_joints, limb_models
from services.reaching.messages import TipPose
from services.robotfile.robot_tables import RobotFile
from services.script import Script, ScriptedService
from services.streams import (
    CARTESIAN_CALL,
    CARTESIAN_EVENTS,
    PLANT_TRUTH,
    ROBOT_CALL,
    ROBOT_STATUS,
)

pytestmark = pytest.mark.slow


class Errand(ScriptedService):
    """Calibrates a limb, moves it home, and sends its hands on by so much, one after another."""

    trigger = Period(0.01)
    reads = (ROBOT_STATUS, CARTESIAN_EVENTS, PLANT_TRUTH)
    calls = (ROBOT_CALL, CARTESIAN_CALL)

    def __init__(self, robot: RobotFile, limb: str, ways_m: Sequence[Sequence[Vector]]) -> None:
        self.limb = limb
        self.ways_m = ways_m
        self.home = tuple(np.radians(find_limb(robot, limb).home_deg).tolist())
        self.models = limb_models(robot, limb)
        self.answers: dict[int, CartesianReply | CallFailed] = {}
        self.events: list[CartesianEvent] = []
        self.motions: list[MotionState] = []
        self.hands: list[list[Vector]] = []  # at the end of each motion
        self.started: list[Vector] = []
        self.limbs: list[str] = []  # that went
        self.truth: PlantTruth | None = None
        super().__init__(limb_joints(robot, limb))

    def observe(self) -> None:
        self.answers |= dict(self.inputs.replies(CARTESIAN_CALL))
        self.events += self.inputs.all_new(CARTESIAN_EVENTS)
        self.truth = self.inputs.latest(PLANT_TRUTH)

    def script(self) -> Script:
        yield from self.until(lambda: self.status().phase in ("idle", "ready"), 20.0, "boards")
        yield from self.ask("calibrating", "calibrate", 40.0)
        yield from self.ask("moving home", "move", q_rad=self.home, duration_s=2.0)
        yield from self.ask("position-direct mode", "mode", value="direct")
        places = self.places()
        self.started = places
        yield from self.run_errand(places)

    def run_errand(self, places: list[Vector]) -> Script:
        for way_m in self.ways_m:
            places = [place + step for place, step in zip(places, way_m, strict=True)]
            yield from self.go(places)
            self.hands.append(self.places())

    def go(self, places: list[Vector]) -> Script:
        turns = [model.tip_pose(np.array(self.home))[0] for model in self.models]
        poses = tuple(
            TipPose(
                position_m=tuple(place.tolist()),
                rotation_rad=tuple(rotation.rotation_vector(turned).tolist()),
            )
            for place, turned in zip(places, turns, strict=True)
        )
        yield from self.send(
            CartesianRequest(action="go", limb=self.limb, poses=poses, duration_s=1.5)
        )

    def send(self, request: CartesianRequest) -> Script:
        token = self.outputs.call(CARTESIAN_CALL, request)
        yield from self.until(lambda: token in self.answers, 5.0, "an answer")
        reply = self.answers[token]
        assert isinstance(reply, CartesianReply)
        assert reply.ok, reply.reason
        self.limbs.append(reply.limb)
        yield from self.until(
            lambda: bool(self.events) and self.events[-1].kind == "motion-done", 12.0, "the end"
        )
        self.motions.append(self.events[-1].motion)
        self.events.clear()

    def places(self) -> list[Vector]:
        """Where the hands really are."""
        assert self.truth is not None
        angles = dict(zip(self.truth.joints, self.truth.q_rad, strict=True))
        q = np.array([angles[joint] for joint in self._joints])
        return [model.tip_pose(q)[1] for model in self.models]


class NearerHand(Errand):
    """Sends whichever hand is nearer to places beside the left and the right one."""

    def run_errand(self, places: list[Vector]) -> Script:
        middle = 0.5 * (places[0] + places[1])
        for share in (1.0, -1.0, 0.05, -0.05):
            place = middle + share * 0.5 * (places[0] - places[1]) + np.array([-0.04, 0.0, 0.04])
            x, y, z = place.tolist()
            pose = TipPose(position_m=(x, y, z))
            request = CartesianRequest(action="go", limb="auto", poses=(pose,), nearest=True)
            yield from self.send(request)


def run(errand: Errand, robot: RobotFile) -> Errand:
    simulation = Simulation(robot, guests={"errand": errand})
    assert simulation.executor.run(60.0, lambda: errand.finished)
    simulation.close()
    assert errand.truth is not None
    assert errand.truth.limit_violations == 0
    return errand


def assert_on_line(errand: Errand, ways_m: Sequence[Sequence[Vector]]) -> None:
    places = errand.started
    for motion, hands, way_m in zip(errand.motions, errand.hands, ways_m, strict=True):
        assert motion.outcome == "reached"
        places = [place + step for place, step in zip(places, way_m, strict=True)]
        for hand, place in zip(hands, places, strict=True):
            assert np.linalg.norm(hand - place) < 0.004


def test_one_hand_goes_to_two_poses(robot: RobotFile) -> None:
    ways_m = ((np.array([-0.08, -0.03, 0.05]),), (np.array([0.03, 0.05, 0.02]),))
    assert_on_line(run(Errand(robot, "right_arm", ways_m), robot), ways_m)


def test_both_hands_go_to_two_poses_at_once() -> None:
    both = (np.array([-0.05, 0.02, 0.05]), np.array([-0.05, -0.02, 0.03]))
    ways_m = (both, (-both[0], -both[1]))
    robot = load_robot("icub:arms")
    assert_on_line(run(Errand(robot, "both_arms", ways_m), robot), ways_m)


def test_the_nearer_hand_goes_and_the_middle_does_not_make_them_take_turns() -> None:
    robot = load_robot("icub:arms")
    errand = run(NearerHand(robot, "both_arms", ()), robot)
    assert errand.limbs == ["left_arm", "right_arm", "right_arm", "right_arm"]
    assert {motion.outcome for motion in errand.motions} == {"reached"}
