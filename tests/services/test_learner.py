"""The learner: what it learns, what it refuses to learn, and how it is saved and replaced."""

import math
from dataclasses import replace
from pathlib import Path

import msgspec
import numpy as np
import pytest

from services.config import load_robot
from services.core.clock import VirtualClock
from services.core.testing import Bench
from services.learner import Learner, state_path
from services.learning.learner_state import read
from services.learning.limb_learner import ENOUGH, EVERY
from services.messages import Floats
from services.robotfile.robot_tables import RobotFile
from services.streams import DYNAMICS_SAMPLES, LEARNED, LEARNER_CALL, LEARNER_STATUS
from services.wholebody.dynamics_messages import (
    DynamicsSamples,
    LearnerRequest,
    SensorLearning,
    SensorSample,
)

SENSOR = "r_arm_ft"
PERIOD_S = 0.01
NO_PUSH: Floats = (0.0,) * 6


class Arm:
    """A swinging arm whose sensor reads something that the model does not know of."""

    def __init__(self, robot: RobotFile, state_file: Path | None = None) -> None:
        self.learner = Learner(robot, state_file)
        self.bench = Bench(self.learner, VirtualClock())
        self.joints = self.learner.limbs[SENSOR].joints
        self.tick = 0
        self.bad = False
        self.touching = False
        self.valid = True

    def rest(self, q_rad: np.ndarray) -> np.ndarray:
        """A forearm lighter than drawn, and an offset."""
        return np.array(
            [0.8 * np.sin(q_rad[3]), 0.5 * np.cos(q_rad[4]), 0.4, 0.05 * np.sin(q_rad[3]), 0.0, 0.0]
        )

    def run(self, seconds: float, push: Floats = NO_PUSH) -> None:
        for _ in range(round(seconds / PERIOD_S)):
            self.tick += 1
            at_s = self.tick * PERIOD_S
            turn = 1.0 + 0.2 * np.arange(len(self.joints))
            q_rad = 0.5 * np.sin(turn * at_s)
            rest = self.rest(q_rad) + np.array(push)
            sample = SensorSample(
                name=SENSOR,
                measured=(math.nan,) * 6 if self.bad else tuple((5.0 + rest).tolist()),
                predicted=(5.0,) * 6,
                valid=self.valid,
                touching=self.touching,
            )
            message = DynamicsSamples(
                stamp_ns=self.bench.clock.now_ns(),
                joints=self.joints,
                q_rad=tuple(q_rad.tolist()),
                dq_rad_s=tuple((0.5 * turn * np.cos(turn * at_s)).tolist()),
                ddq_rad_s2=tuple((-0.5 * turn**2 * np.sin(turn * at_s)).tolist()),
                delay_s=0.1,
                sensors=(sample,),
            )
            self.truth = rest
            self.bench.put(DYNAMICS_SAMPLES, message)
            self.bench.advance(PERIOD_S)

    @property
    def correction(self) -> Floats:
        (said,) = self.bench.last(LEARNED).corrections
        assert said.name == SENSOR
        return said.wrench

    @property
    def learned(self) -> int:
        """Samples taken in."""
        return self.learner.limbs[SENSOR].learner.samples

    @property
    def status(self) -> SensorLearning:
        (limb,) = self.bench.last(LEARNER_STATUS).sensors
        return limb

    def ask(self, action: str, value: str = "", sensors: tuple[str, ...] = ()) -> str:
        """The reason why it was refused, empty where it was done."""
        token = self.bench.request(
            LEARNER_CALL, LearnerRequest(action=action, value=value, sensors=sensors)
        )
        replies = dict(self.bench.replies(LEARNER_CALL))
        assert replies[token].ok == (not replies[token].reason)
        return replies[token].reason


@pytest.fixture
def arm(robot: RobotFile) -> Arm:
    return Arm(robot)


@pytest.fixture(scope="module")
def seasoned_state(robot: RobotFile, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The state after a minute of swinging."""
    arm = Arm(robot)
    arm.run(60.0)
    path = tmp_path_factory.mktemp("learner") / "arm.state"
    assert arm.ask("save", str(path)) == ""
    return path


@pytest.fixture
def seasoned(robot: RobotFile, seasoned_state: Path) -> Arm:
    arm = Arm(robot)
    assert arm.ask("restore", str(seasoned_state)) == ""
    arm.run(0.1)
    return arm


def test_a_sensor_s_inputs_are_the_joints_that_move_it_or_beyond_it(arm: Arm) -> None:
    torso = {"torso_pitch", "torso_roll", "torso_yaw"}
    shoulder = {"r_shoulder_pitch", "r_shoulder_roll", "r_shoulder_yaw"}
    beyond = {"r_elbow", "r_wrist_prosup", "r_wrist_pitch", "r_wrist_yaw"}
    assert set(arm.joints) == torso | shoulder | beyond


def test_a_leg_s_inputs_are_its_own_joints() -> None:
    limbs = Learner(load_robot("icub")).limbs
    assert len(limbs["l_leg_ft"].joints) == 6
    assert all(joint.startswith("l_") for joint in limbs["l_leg_ft"].joints)


def test_learns_what_the_model_leaves_over(arm: Arm) -> None:
    arm.run(60.0)
    # the rest is 0.4 to 1.1 N; a minute of swinging leaves a few hundredths of it
    assert arm.correction == pytest.approx(arm.truth, abs=0.1)
    assert arm.status.error_n < 0.2 * arm.status.model_error_n
    assert arm.bench.last(LEARNER_STATUS).state == "learning"


def test_learns_at_every_fourth_sample_and_answers_every_one(arm: Arm) -> None:
    arm.run(4.0)
    assert arm.learned == 400 // EVERY
    assert len(arm.bench.sent(LEARNED)) == 400


def test_says_nothing_before_it_has_seen_enough(arm: Arm) -> None:
    arm.run((ENOUGH - 2) * EVERY * PERIOD_S)
    assert arm.bench.last(LEARNED).corrections == ()
    arm.run(4 * EVERY * PERIOD_S)
    assert len(arm.correction) == 6


def test_the_answer_names_the_samples_it_belongs_to(arm: Arm) -> None:
    arm.run(0.05)
    newest = arm.bench.sent(LEARNED)[-1]
    assert newest.samples_stamp_ns == newest.stamp_ns == 40_000_000


def test_never_eats_a_push_of_five_newtons(seasoned: Arm) -> None:
    push = (3.0, -4.0, 0.0, 0.0, 0.1, 0.0)
    seasoned.run(10.0, push)
    force = np.array(seasoned.truth[:3]) - np.array(seasoned.correction[:3])
    assert force @ [0.6, -0.8, 0.0] == pytest.approx(5.0, abs=0.1)
    assert seasoned.status.gated
    assert seasoned.status.reason == "unexplained force"
    seasoned.run(1.0)
    assert seasoned.correction[:3] == pytest.approx(seasoned.truth[:3], abs=0.1)
    assert not seasoned.status.gated


def test_a_push_that_grows_slowly_is_taken_back(seasoned: Arm) -> None:
    for force_n in np.linspace(0.0, 4.0, 40):
        seasoned.run(0.1, (float(force_n), 0.0, 0.0, 0.0, 0.0, 0.0))
    seasoned.run(5.0, (4.0, 0.0, 0.0, 0.0, 0.0, 0.0))
    assert seasoned.truth[0] - seasoned.correction[0] == pytest.approx(4.0, abs=0.15)


def test_does_not_learn_while_the_detection_says_that_something_touches(seasoned: Arm) -> None:
    before = seasoned.status.updates
    seasoned.touching = True
    seasoned.run(2.0, (1.0, 0.0, 0.0, 0.0, 0.0, 0.0))
    # what was learned in the last seconds may be taken back; nothing is added
    assert seasoned.status.updates <= before
    assert seasoned.status.reason == "something touches it"


def test_learns_nothing_from_a_sensor_that_cannot_be_used(arm: Arm) -> None:
    arm.valid = False
    arm.run(4.0)
    assert arm.status.updates == 0
    assert arm.bench.last(LEARNED).corrections == ()
    assert arm.status.reason == "the sensor cannot be used"


def test_a_sample_that_is_not_finite_changes_nothing(seasoned: Arm) -> None:
    before = seasoned.learner.limbs[SENSOR].state()
    seasoned.bad = True
    seasoned.run(0.5)
    after = seasoned.learner.limbs[SENSOR].state()
    assert np.array_equal(before.ridges[0].W, after.ridges[0].W)
    assert "not finite" in seasoned.status.reason
    for message in seasoned.bench.sent(LEARNED):
        assert all(math.isfinite(v) for said in message.corrections for v in said.wrench)
    seasoned.bad = False
    seasoned.run(0.5)
    assert seasoned.correction == pytest.approx(seasoned.truth, abs=0.1)


def test_begins_anew_when_rounding_has_spoilt_what_it_knows(seasoned: Arm) -> None:
    limb = seasoned.learner.limbs[SENSOR]
    state = limb.state()
    (ridge,) = state.ridges
    spoilt = replace(ridge, P=np.asfortranarray(-np.eye(len(ridge.P))))
    limb.learner.restore(replace(state, ridges=(spoilt,)))
    seasoned.run(0.1)
    assert seasoned.learned < 10
    assert seasoned.bench.last(LEARNED).corrections == ()
    seasoned.run(60.0)
    assert seasoned.correction == pytest.approx(seasoned.truth, abs=0.1)


def test_frozen_it_predicts_without_learning(seasoned: Arm) -> None:
    assert seasoned.ask("freeze") == ""
    before = seasoned.status.updates
    seasoned.run(2.0)
    assert seasoned.bench.last(LEARNER_STATUS).state == "frozen"
    assert seasoned.status.updates == before
    assert seasoned.correction == pytest.approx(seasoned.truth, abs=0.1)
    assert seasoned.ask("resume") == ""
    seasoned.run(2.0)
    assert seasoned.status.updates > before


def test_a_restored_learner_says_the_same_to_the_bit(robot: RobotFile, tmp_path: Path) -> None:
    first = Arm(robot)
    first.run(5.0)
    file = str(tmp_path / "arm.state")
    assert first.ask("save", file) == ""
    second = Arm(robot)
    second.tick = first.tick
    # the two learn at the same samples from here on
    second.learner._count = first.learner._count
    assert second.ask("restore", file) == ""
    first.run(3.0)
    second.run(3.0)
    assert second.correction == first.correction


def test_begins_with_the_state_that_an_earlier_one_left(robot: RobotFile, tmp_path: Path) -> None:
    file = tmp_path / "arm.state"
    first = Arm(robot, file)
    first.run(5.0)
    first.bench.close()
    second = Arm(robot, file)
    second.run(0.01)
    assert second.learned == first.learned > 0
    assert second.bench.last(LEARNER_STATUS).snapshot == str(file)


def test_keeps_what_was_learned_of_sensors_that_are_not_in_use(
    robot: RobotFile, tmp_path: Path
) -> None:
    file = tmp_path / "robot.state"
    whole = Bench(Learner(load_robot("icub"), file), VirtualClock())
    whole.close()
    Arm(robot, file).bench.close()
    names = [limb.name for limb in read(file).limbs]
    assert sorted(names) == sorted(load_robot("icub").sensors)


def test_keeps_what_was_learned_of_a_sensor_over_other_joints(tmp_path: Path) -> None:
    file = tmp_path / "robot.state"
    with_torso = Arm(load_robot("icub:reach"), file)
    with_torso.run(5.0)
    with_torso.bench.close()
    alone = Arm(load_robot("icub:right_arm"), file)
    alone.run(0.01)
    assert "over other joints" in alone.bench.last(LEARNER_STATUS).reason
    alone.bench.close()
    again = Arm(load_robot("icub:reach"), file)
    again.run(0.01)
    assert again.learned == with_torso.learned > 0


def test_restoring_a_file_without_any_of_the_sensors_is_refused(arm: Arm, tmp_path: Path) -> None:
    file = tmp_path / "legs.state"
    Bench(Learner(load_robot("icub:left_leg"), file), VirtualClock()).close()
    assert (
        arm.ask("restore", str(file)) == f"{file} has none of r_arm_ft; it has l_leg_ft, l_foot_ft"
    )


def test_a_refusal_is_no_longer_told_once_a_file_was_written(arm: Arm, tmp_path: Path) -> None:
    arm.run(0.2)
    assert "cannot write" in arm.ask("save", str(tmp_path / "no" / "folder"))
    assert arm.ask("save", str(tmp_path / "arm.state")) == ""
    arm.run(0.2)
    assert arm.bench.last(LEARNER_STATUS).reason == ""


def test_a_real_robot_does_not_begin_with_what_an_emulated_one_has_taught() -> None:
    emulated = state_path(load_robot("icub:right_arm"), 0)
    assert state_path(load_robot("icub:right_arm@real"), 0) != emulated
    assert state_path(load_robot("icub:right_arm"), 1) != emulated


def test_saves_every_half_minute_by_itself(robot: RobotFile, tmp_path: Path) -> None:
    file = tmp_path / "arm.state"
    arm = Arm(robot, file)
    arm.run(29.0)
    assert not file.exists()
    arm.run(2.0)
    assert file.exists()
    assert list(tmp_path.iterdir()) == [file]


def test_a_spoilt_state_is_refused_and_learning_begins_anew(
    robot: RobotFile, tmp_path: Path
) -> None:
    file = tmp_path / "arm.state"
    file.write_bytes(b"not a state")
    arm = Arm(robot, file)
    arm.run(4.0)
    assert "is no state of a learner" in arm.bench.last(LEARNER_STATUS).reason
    assert arm.status.updates > 0


def test_a_state_cut_short_changes_nothing(
    seasoned: Arm, seasoned_state: Path, tmp_path: Path
) -> None:
    cut = tmp_path / "cut.state"
    cut.write_bytes(seasoned_state.read_bytes()[:-1000])
    before = seasoned.status.updates
    assert "is no state of a learner" in seasoned.ask("restore", str(cut))
    seasoned.run(0.01)
    assert seasoned.status.updates >= before


@pytest.mark.parametrize(
    ("field", "value", "reason"),
    [
        ("robot", "nao", "of the robot nao"),
        ("version", 99, "version 99"),
    ],
)
def test_the_state_of_another_robot_or_version_is_refused(
    seasoned: Arm, seasoned_state: Path, tmp_path: Path, field: str, value: object, reason: str
) -> None:
    content = msgspec.msgpack.decode(seasoned_state.read_bytes())
    content[field] = value
    other = tmp_path / "other.state"
    other.write_bytes(msgspec.msgpack.encode(content))
    assert reason in seasoned.ask("restore", str(other))


def test_the_state_over_other_joints_is_refused(
    seasoned: Arm, seasoned_state: Path, tmp_path: Path
) -> None:
    content = msgspec.msgpack.decode(seasoned_state.read_bytes())
    content["limbs"][0]["joints"][0] = "tail"
    other = tmp_path / "other.state"
    other.write_bytes(msgspec.msgpack.encode(content))
    assert "over other joints" in seasoned.ask("restore", str(other))


def test_a_save_where_nothing_can_be_written_is_told(arm: Arm, tmp_path: Path) -> None:
    assert "cannot write" in arm.ask("save", str(tmp_path / "no" / "such" / "folder"))
    assert arm.ask("save") == "no file was named"


def test_reset_forgets_one_sensor(seasoned: Arm) -> None:
    assert seasoned.ask("reset", sensors=(SENSOR,)) == ""
    seasoned.run(0.01)
    assert seasoned.bench.last(LEARNED).corrections == ()
    assert seasoned.status.updates <= 1


def test_a_sensor_or_action_that_there_is_not_is_named(arm: Arm) -> None:
    assert arm.ask("reset", sensors=("l_leg_ft",)).startswith("no sensor 'l_leg_ft' here")
    assert arm.ask("dance").startswith("no action 'dance'")
