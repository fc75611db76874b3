"""Where the world may touch the robot, what is known to act on it, and how its base moves."""

import numpy as np
import pytest

from services.config import load_robot
from services.messages import Imu
from services.robotfile.robot_tables import RobotFile
from services.streams import (
    DYNAMICS_MODELS,
    DYNAMICS_SAMPLES,
    EXTERNAL,
    IMPEDANCE_OFFSET,
    IMU,
    TORQUE_ESTIMATE,
)
from services.wholebody.dynamics_messages import AssumedContact, DynamicsRequest, KnownLoad
from tests.services.whole_body import OFFSET, Stand, robot_model

LEFT = TORQUE_ESTIMATE["left_arm"]
LEVEL_N = 0.02  # what a calibration from noise of 0.02 N in 100 samples stays inside of


@pytest.fixture(scope="module")
def arms() -> RobotFile:
    return load_robot("icub:arms")


@pytest.fixture
def stand(arms: RobotFile) -> Stand:
    stand = Stand(arms)
    stand.calibrate()
    return stand


def head_imu(stand: Stand, times_gravity: float = 1.0) -> Imu:
    """What the IMU in the head shows of a robot that stands upright and still."""
    above = robot_model(str(stand.body.urdf), stand.body.joints, "imu_frame", ())
    turn, _ = above.tip_pose(stand.q_rad)
    x, y, z = (times_gravity * 9.81 * turn[2]).tolist()
    return Imu(
        stamp_ns=0,
        quaternion=(1.0, 0.0, 0.0, 0.0),
        gyro_rad_s=(0.0, 0.0, 0.0),
        acceleration_m_s2=(x, y, z),
        magnetic_t=(0.0, 0.0, 0.0),
        arrival_ns=0,
    )


def test_custom_contacts_take_the_place_of_the_default_ones(stand: Stand) -> None:
    elbow = AssumedContact(frame="l_forearm", point_m=(0.0, 0.02, 0.0), kind="force")
    request = DynamicsRequest(action="assume", value="custom", contacts=(elbow,))
    assert stand.request(request).ok
    stand.run(250)
    models = stand.bench.last(DYNAMICS_MODELS)
    assert models.assumption == "custom"
    assert [(sub.sensors[0], sub.unknowns) for sub in models.sub_models[1:]] == [
        ("l_arm_ft", 3),
        ("r_arm_ft", 0),
    ]
    assert stand.contact("l_arm_ft").link == "l_forearm"


@pytest.mark.parametrize("contacts", ["default", "standing"])
def test_a_known_load_is_no_contact_no_error_and_no_offset(arms: RobotFile, contacts: str) -> None:
    stand = Stand(arms, pushed="l_hand")
    stand.calibrate()
    turn, _ = stand.model.tip_pose(stand.q_rad)
    load = KnownLoad(frame="l_hand", wrench=(6.0, -8.0, 4.0, 0.0, 0.0, 0.0))
    request = DynamicsRequest(action="assume", value=contacts, known=(load,))
    assert stand.request(request).ok
    stand.push_n = turn @ np.array(load.wrench[:3])
    stand.run(300)
    first = len(stand.bench.sent(EXTERNAL))
    stand.run(400)
    looks = stand.bench.sent(EXTERNAL)[first:]
    assert not any(contact.touching for look in looks for contact in look.contacts)
    assert np.abs(stand.contact("l_arm_ft").force_n).max() < 0.1
    samples = stand.bench.last(DYNAMICS_SAMPLES).sensors[0]
    assert samples.measured == pytest.approx(samples.predicted, abs=0.05)
    part = next(part for part in stand.body.parts if part.name == "left_arm")
    tau_nm = stand.bench.last(LEFT).tau_nm
    assert tau_nm == pytest.approx(part.to_stream(stand.tau_nm().tolist()), abs=0.03)
    assert stand.bench.last(DYNAMICS_MODELS).known == (load,)
    assert stand.ask("calibrate").ok
    stand.run(120)
    assert stand.dynamics.bank.channels[0].offset == pytest.approx(OFFSET, abs=LEVEL_N)


def test_loads_are_forgotten_with_the_next_assumption(stand: Stand) -> None:
    load = KnownLoad(frame="l_hand", wrench=(0.0, 0.0, -10.0, 0.0, 0.0, 0.0))
    assert stand.request(DynamicsRequest(action="assume", value="default", known=(load,))).ok
    stand.run(200)
    assert stand.contact("l_arm_ft").touching  # of the load that is not there
    assert stand.ask("assume", value="default").ok
    stand.run(200)
    assert not stand.contact("l_arm_ft").touching
    assert stand.bench.last(DYNAMICS_MODELS).known == ()


@pytest.mark.parametrize("contacts", ["default", "standing", "crawling"])
def test_a_set_that_takes_no_frames_refuses_them(stand: Stand, contacts: str) -> None:
    hand = (AssumedContact(frame="r_hand"),)
    reply = stand.request(DynamicsRequest(action="assume", value=contacts, contacts=hand))
    assert (reply.ok, reply.reason) == (False, f"{contacts} does not take r_hand; `custom` does")
    assert stand.dynamics.assumption_name == "default"


def test_a_set_that_is_held_refuses_to_hang(stand: Stand) -> None:
    reply = stand.request(DynamicsRequest(action="assume", value="default", mainstay=False))
    assert reply.reason == "default does not take a base that hangs; `custom` does"


def test_an_unknown_kind_of_contact_is_told_with_those_that_there_are(stand: Stand) -> None:
    odd = (AssumedContact(frame="r_hand", kind="twist"),)
    reply = stand.request(DynamicsRequest(action="assume", value="custom", contacts=odd))
    assert reply.reason == "no kind of contact 'twist'; there are: wrench, force, direction"


def test_two_wrenches_on_one_arm_cannot_be_told_apart_and_silence_it(stand: Stand) -> None:
    both = tuple(AssumedContact(frame=frame) for frame in ("l_hand", "l_forearm"))
    assert stand.request(DynamicsRequest(action="assume", value="custom", contacts=both)).ok
    stand.run(50)
    assert list(stand.silent()) == ["left_arm"]
    assert stand.ask("assume", value="default").ok
    stand.run(5)
    assert stand.silent() == {}


def test_an_assumption_that_silences_everybody_does_not_meet_the_estimate_before_it() -> None:
    """The status that is due next must not look for two contacts in an estimate of one."""
    stand = Stand(load_robot("icub:right_arm"))
    stand.calibrate()
    stand.run(4)
    assert stand.dynamics.newest is not None
    both = tuple(AssumedContact(frame=frame) for frame in ("r_hand", "r_forearm"))
    assert stand.request(DynamicsRequest(action="assume", value="custom", contacts=both)).ok
    stand.run(30)
    assert list(stand.silent()) == ["right_arm"]


def test_a_lost_arm_is_estimated_where_the_assumption_leaves_one_place_for_a_touch(
    stand: Stand,
) -> None:
    """Nothing holds the base and only the hands are touched: six unknowns in what is merged."""
    hands = tuple(AssumedContact(frame=frame) for frame in ("l_hand", "r_hand"))
    request = DynamicsRequest(action="assume", value="custom", contacts=hands, mainstay=False)
    assert stand.request(request).ok
    stand.faults = {"r_arm_ft": None}
    stand.run(10)
    assert stand.silent() == {}


def test_standing_is_hands_and_feet_of_the_limbs_in_use(stand: Stand) -> None:
    assert stand.ask("assume", value="standing").ok
    contacts = [contact.frame for contact in stand.dynamics.assumption.contacts]
    assert contacts == ["l_hand", "r_hand"]
    assert stand.silent() == {}


def test_crawling_takes_its_motion_from_the_imu() -> None:
    stand = Stand(load_robot("icub"))
    stand.calibrate()
    assert stand.ask("assume", value="crawling").ok
    stand.run(200)
    assert stand.silent()["left_arm"] == "no readings of head_imu"
    for _ in range(40):
        stand.others = {IMU["head_imu"]: head_imu(stand)}
        stand.run(10)
    assert stand.silent() == {}
    models = stand.bench.last(DYNAMICS_MODELS)
    assert (models.assumption, models.source, models.mainstay) == ("crawling", "head_imu", False)


def test_imu_says_where_down_is_and_its_loss_silences_everything() -> None:
    stand = Stand(load_robot("icub"))
    stand.calibrate()
    held = stand.bench.last(IMPEDANCE_OFFSET["left_arm"]).tau_nm
    assert stand.ask("source", value="head_imu").ok
    for _ in range(20):
        stand.others = {IMU["head_imu"]: head_imu(stand, 2.0)}
        stand.run(10)
    heavy = stand.bench.last(IMPEDANCE_OFFSET["left_arm"]).tau_nm
    assert heavy == pytest.approx(2.0 * np.array(held), abs=1e-3)
    before = len(stand.bench.sent(LEFT))
    stand.run(200)
    assert len(stand.bench.sent(LEFT)) <= before + 60  # as old as a motion may be
    assert stand.silent()["left_arm"] == "no readings of head_imu"
    assert stand.ask("source", value="base").ok
    stand.run(5)
    assert stand.silent() == {}
