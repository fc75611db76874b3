"""What touches the robot, as the dynamics service tells it: when, where, and with the learner."""

import math

import numpy as np
import pytest

from services.config import load_robot
from services.messages import Skin
from services.robotfile.robot_tables import RobotFile
from services.streams import DYNAMICS_SAMPLES, EXTERNAL, LEARNED, SKIN, TORQUE_ESTIMATE
from services.wholebody.dynamics_messages import LearnedWrench, LearnedWrenches
from tests.services.whole_body import Stand, swing

NO_LOAD = 240
TAXELS = 192
WRONG = np.array([1.0, 0.0, 0.0, 0.0, 0.2, 0.0])  # what a wrong mass adds at one place


@pytest.fixture(scope="module")
def arms() -> RobotFile:
    return load_robot("icub:arms")


def pushed(robot: RobotFile, link: str, force_n: tuple[float, float, float]) -> Stand:
    """A calibrated robot that is being pushed, filters settled."""
    stand = Stand(robot, pushed=link)
    stand.calibrate()
    stand.push_n = np.array(force_n)
    stand.run(250)
    return stand


def learned(stand: Stand, force_x_n: float, std_n: float | None = None) -> LearnedWrenches:
    wrench = (force_x_n, 0.0, 0.0, 0.0, 0.0, 0.0)
    std = () if std_n is None else (std_n, 0.0, 0.0, 0.0, 0.0, 0.0)
    correction = LearnedWrench(name="l_arm_ft", wrench=wrench, std=std)
    return LearnedWrenches(
        stamp_ns=stand.now_ns, samples_stamp_ns=stand.now_ns, corrections=(correction,)
    )


def test_a_push_is_felt_by_its_limb_alone_with_its_force(arms: RobotFile) -> None:
    stand = pushed(arms, "l_hand_dh_frame", (0.0, 6.0, 0.0))
    contact = stand.contact("l_arm_ft")
    assert (contact.touching, contact.limb) == (True, "left_arm")
    assert contact.force_n == pytest.approx((0.0, 6.0, 0.0), abs=0.1)
    assert not stand.contact("r_arm_ft").touching


def test_a_touch_ends_with_hysteresis(arms: RobotFile) -> None:
    stand = pushed(arms, "l_hand_dh_frame", (0.0, 6.0, 0.0))
    begin_ns = stand.contact("l_arm_ft").since_ns
    stand.push_n = np.array([0.0, 3.2, 0.0])  # below what begins one, above what ends one
    stand.run(250)
    assert stand.contact("l_arm_ft").touching
    assert stand.contact("l_arm_ft").since_ns == begin_ns
    stand.push_n = np.array([0.0, 2.0, 0.0])
    stand.run(250)
    assert not stand.contact("l_arm_ft").touching
    assert stand.contact("l_arm_ft").since_ns > begin_ns


def test_a_push_too_weak_to_be_told_from_the_model_s_error_is_no_touch(arms: RobotFile) -> None:
    stand = pushed(arms, "l_hand_dh_frame", (0.0, 3.2, 0.0))
    assert not stand.contact("l_arm_ft").touching


def test_a_free_swing_is_no_touch(arms: RobotFile) -> None:
    stand = Stand(arms)
    stand.path = swing(stand.q_rad, 0.3, 0.8)
    stand.calibrate()
    stand.run(400)
    first = len(stand.bench.sent(EXTERNAL))
    stand.run(1000)
    contacts = [c for m in stand.bench.sent(EXTERNAL)[first:] for c in m.contacts]
    assert len(contacts) == 200
    assert not any(contact.touching for contact in contacts)
    assert max(np.linalg.norm(contact.force_n) for contact in contacts) < 0.6


def test_an_arm_whose_state_comes_a_little_late_is_not_touched(arms: RobotFile) -> None:
    """As on a busy machine: the other parts' states make a step of their own, just before."""
    stand = Stand(arms)
    stand.calibrate()
    stand.dq_rad_s = np.full(len(stand.q_rad), 0.3)
    stand.run(300)
    stand.late = {"left_arm"}
    stand.run(4)
    stand.late = set()
    strongest_n = 0.0
    for _ in range(20):
        stand.run(10)
        assert not stand.contact("l_arm_ft").touching
        strongest_n = max(strongest_n, math.hypot(*stand.contact("l_arm_ft").force_n))
    assert strongest_n < 0.3


def test_a_push_on_the_forearm_is_found_there_and_leaves_the_wrist_free(arms: RobotFile) -> None:
    stand = pushed(arms, "l_forearm_dh_frame", (0.0, 0.0, 0.0))
    turn, _ = stand.model.tip_pose(stand.q_rad)
    stand.push_n = turn @ np.array([0.0, 0.0, 15.0])
    stand.run(300)
    contact = stand.contact("l_arm_ft")
    stand.run(20)
    assert contact.touching
    if contact.location == "shape":
        assert contact.link == "l_forearm"
    expected = stand.tau_nm()[stand.body.joints.index("l_elbow")]
    estimate = stand.bench.last(TORQUE_ESTIMATE["left_arm"])
    assert estimate.tau_nm[3] == pytest.approx(expected, abs=0.03)


def test_skin_says_where_the_touch_is() -> None:
    stand = Stand(load_robot("icub"), pushed="r_forearm")
    stand.calibrate()
    stand.push_n = np.array([0.0, 0.0, 8.0])
    taxels = bytearray([NO_LOAD] * TAXELS)
    taxels[:24] = bytes([NO_LOAD - 60] * 24)
    for _ in range(8):
        skin = Skin(
            stamp_ns=stand.now_ns,
            taxels=bytes(taxels),
            errors=bytes(16),
            heard=0xFFFF,
            no_load=NO_LOAD,
            arrival_ns=stand.now_ns,
        )
        stand.others = {SKIN["r_forearm_skin_1"]: skin}
        stand.run(40)
    contact = stand.contact("r_arm_ft")
    assert (contact.location, contact.link, contact.touching) == ("skin", "r_forearm", True)
    expected = stand.tau_nm()
    part = next(part for part in stand.body.parts if part.name == "right_arm")
    estimate = stand.bench.last(part.torque)
    assert estimate.tau_nm == pytest.approx(expected[part.start : part.stop], abs=0.03)
    stand.run(300)
    assert stand.contact("r_arm_ft").location != "skin"


def test_a_touch_is_no_part_of_what_the_model_leaves_unexplained(arms: RobotFile) -> None:
    stand = Stand(arms, pushed="l_hand_dh_frame")
    stand.calibrate()
    stand.run(400)
    for force_n in (0.0, 12.0, 0.0, 5.0, 0.0):
        stand.push_n = np.array([0.0, force_n, 0.0])
        stand.run(500)
    health = stand.health("l_arm_ft")
    assert np.abs(health.mean).max() < 0.03  # N, Nm; the push was 12 N
    assert np.array(health.std).max() < 0.02


def test_a_place_is_as_uncertain_as_the_model_is_wrong(arms: RobotFile) -> None:
    stand = Stand(arms, pushed="l_hand")
    stand.calibrate()
    turn, _ = stand.model.tip_pose(stand.q_rad)
    places = []
    for wrong_n in (0.0, 1.5):
        stand.push_n = np.zeros(3)
        stand.offsets["l_arm_ft"] = stand.offsets["l_arm_ft"] + wrong_n * WRONG
        stand.run(1000)
        noise = stand.dynamics.filtered.health.noise(0)
        stand.push_n = turn @ np.array([7.0, 0.0, 0.0])
        stand.run(300)
        places.append((noise.force_n, stand.contact("l_arm_ft").location))
    (sensor_n, sensor_place), (wrong_n, wrong_place) = places
    assert (sensor_n, sensor_place) == (0.05, "shape")
    # The mean of 1.5 N in one of three channels, and what two seconds' memory has of it.
    assert 0.5 < wrong_n < 1.5 / 3.0**0.5
    assert wrong_place == "unsure"


def test_samples_are_what_a_learner_needs(arms: RobotFile) -> None:
    stand = pushed(arms, "l_hand_dh_frame", (0.0, 8.0, 0.0))
    samples = stand.bench.last(DYNAMICS_SAMPLES)
    assert samples.joints == stand.body.joints
    assert samples.q_rad == pytest.approx(stand.q_rad, abs=1e-9)
    assert samples.dq_rad_s == pytest.approx(np.zeros(len(stand.q_rad)), abs=1e-9)
    left, right = samples.sensors
    assert (left.name, left.valid, left.touching) == ("l_arm_ft", True, True)
    assert (right.name, right.valid, right.touching) == ("r_arm_ft", True, False)
    excess_n = np.subtract(left.measured, left.predicted)[:3]
    assert np.linalg.norm(excess_n) == pytest.approx(8.0, abs=0.1)
    assert right.measured == pytest.approx(right.predicted, abs=0.05)


def test_samples_come_a_hundred_times_a_second(arms: RobotFile) -> None:
    stand = Stand(arms)
    stand.calibrate()
    before = len(stand.bench.sent(DYNAMICS_SAMPLES))
    stand.run(200)
    assert len(stand.bench.sent(DYNAMICS_SAMPLES)) == before + 20


def test_the_learner_s_correction_is_taken_off_contacts_and_never_off_torques(
    arms: RobotFile,
) -> None:
    plain, helped = Stand(arms), Stand(arms)
    for stand in (plain, helped):
        stand.calibrate()
        for _ in range(20):
            if stand is helped:
                stand.others = {LEARNED: learned(stand, 5.0)}
            stand.run(10)
    assert np.linalg.norm(plain.contact("l_arm_ft").force_n) < 0.1
    assert np.linalg.norm(helped.contact("l_arm_ft").force_n) == pytest.approx(5.0, abs=0.1)
    for arm in ("left_arm", "right_arm"):
        stream = TORQUE_ESTIMATE[arm]
        assert plain.bench.sent(stream) == helped.bench.sent(stream)


@pytest.mark.parametrize(
    ("link", "push_n", "wrench"),
    [
        ("l_hand_dh_frame", (0.0, 8.0, 0.0), (0.0, 0.0, 0.0, -1.2, 0.9, 0.06)),  # another place
        ("l_upper_arm", (0.0, 0.0, 8.0), None),  # hides the touch
    ],
)
def test_a_wrong_learner_that_moves_or_hides_a_touch_changes_no_torque(
    arms: RobotFile, link: str, push_n: tuple[float, float, float], wrench: tuple[float, ...] | None
) -> None:
    streams = []
    for wrong in (False, True):
        stand = Stand(arms, pushed=link)
        stand.calibrate()
        free = stand.true_wrenches()["l_arm_ft"].copy()
        stand.push_n = np.array(push_n)
        hiding = tuple((stand.true_wrenches()["l_arm_ft"] - free).tolist())
        for _ in range(40):
            if wrong:
                lie = LearnedWrench(name="l_arm_ft", wrench=wrench or hiding, std=())
                stand.others = {
                    LEARNED: LearnedWrenches(
                        stamp_ns=stand.now_ns, samples_stamp_ns=stand.now_ns, corrections=(lie,)
                    )
                }
            stand.run(10)
        assert stand.contact("l_arm_ft").touching is (wrench is not None or not wrong)
        streams.append(stand.bench.sent(TORQUE_ESTIMATE["left_arm"]))
    assert streams[0] == streams[1]


def test_a_learner_that_falls_silent_leaves_the_model_alone_and_no_tick_is_lost(
    arms: RobotFile,
) -> None:
    stand = Stand(arms)
    stand.calibrate()
    stand.others = {LEARNED: learned(stand, 5.0)}
    stand.run(50)
    assert np.linalg.norm(stand.contact("l_arm_ft").force_n) > 4.9
    before = len(stand.bench.sent(TORQUE_ESTIMATE["left_arm"]))
    contacts = len(stand.bench.sent(EXTERNAL))
    stand.run(100)  # the old learner goes
    assert np.linalg.norm(stand.contact("l_arm_ft").force_n) < 0.1
    stand.others = {LEARNED: learned(stand, -3.0)}  # and another one comes
    stand.run(50)
    assert np.linalg.norm(stand.contact("l_arm_ft").force_n) == pytest.approx(3.0, abs=0.1)
    assert len(stand.bench.sent(TORQUE_ESTIMATE["left_arm"])) == before + 150
    assert len(stand.bench.sent(EXTERNAL)) == contacts + 15


def test_a_correction_that_is_not_finite_is_refused(arms: RobotFile) -> None:
    stand = Stand(arms)
    stand.calibrate()
    stand.others = {LEARNED: learned(stand, math.nan)}
    stand.run(30)
    assert stand.dynamics.correction.refused == 1
    assert np.linalg.norm(stand.contact("l_arm_ft").force_n) < 0.1


@pytest.mark.parametrize(
    ("std_n", "touching"), [(None, False), (0.0, False), (0.5, True), (0.7, True), (0.9, False)]
)
def test_a_learner_that_leaves_little_lets_weaker_touches_be_felt(
    arms: RobotFile, std_n: float | None, touching: bool
) -> None:
    """3 N: above 2.5 and four times 0.7, below four times 0.9 and the 4 N of the model alone."""
    stand = Stand(arms, pushed="l_hand_dh_frame")
    stand.calibrate()
    stand.push_n = np.array([0.0, 3.0, 0.0])
    for _ in range(25):
        stand.others = {LEARNED: learned(stand, 0.0, std_n)}
        stand.run(10)
    assert stand.contact("l_arm_ft").touching is touching
