"""Sensors that fail: flagged at once, their limb silent, the others as if nothing had happened."""

import math

import msgspec
import numpy as np
import pytest

from services.config import load_robot
from services.robotfile.robot_tables import RobotFile
from services.streams import DYNAMICS_MODELS, DYNAMICS_SAMPLES, EXTERNAL, TORQUE_ESTIMATE
from tests.services.whole_body import Stand, torque_streams

LOST_MS = 3  # without readings a sensor is lost after two milliseconds
RECOVERED_MS = 2


@pytest.fixture(scope="module")
def arms() -> RobotFile:
    return load_robot("icub:arms")


@pytest.fixture
def stand(arms: RobotFile) -> Stand:
    stand = Stand(arms)
    stand.calibrate()
    return stand


FAULTS: dict[str, str | float | None] = {
    "nan": math.nan,
    "inf": math.inf,
    "saturated": "saturated",
    "frozen": "frozen",
    "missing": None,
}


@pytest.mark.parametrize("flag", FAULTS)
def test_is_flagged_and_its_limb_silent(stand: Stand, flag: str) -> None:
    stand.faults = {"r_arm_ft": FAULTS[flag]}
    stand.run(LOST_MS if flag == "missing" else 1)
    assert stand.flags("r_arm_ft") == (flag,)
    assert "r_arm_ft cannot be used" in stand.silent()["right_arm"]
    before = len(stand.bench.sent(TORQUE_ESTIMATE["right_arm"]))
    stand.run(50)
    assert len(stand.bench.sent(TORQUE_ESTIMATE["right_arm"])) == before


@pytest.mark.parametrize("flag", FAULTS)
def test_recovers_by_itself_with_the_second_good_reading(stand: Stand, flag: str) -> None:
    stand.faults = {"r_arm_ft": FAULTS[flag]}
    stand.run(50)
    stand.faults = {}
    before = len(stand.bench.sent(TORQUE_ESTIMATE["right_arm"]))
    stand.run(RECOVERED_MS)
    assert len(stand.bench.sent(TORQUE_ESTIMATE["right_arm"])) == before + 1
    assert stand.flags("r_arm_ft") == ()
    assert stand.silent() == {}


@pytest.mark.parametrize("flag", FAULTS)
def test_the_other_arm_gets_the_same_torques_bit_by_bit(arms: RobotFile, flag: str) -> None:
    sound, broken = Stand(arms), Stand(arms)
    for stand in (sound, broken):
        stand.calibrate()
    broken.faults = {"r_arm_ft": FAULTS[flag]}
    for stand in (sound, broken):
        stand.run(50)
    left = TORQUE_ESTIMATE["left_arm"]
    assert len(sound.bench.sent(left)) > 50
    assert sound.bench.sent(left) == broken.bench.sent(left)


def test_a_lost_sensor_makes_its_limb_one_with_the_trunk(stand: Stand) -> None:
    stand.faults = {"r_arm_ft": None}
    stand.run(200)
    models = stand.bench.last(DYNAMICS_MODELS)
    assert [sub.sensors for sub in models.sub_models] == [("l_arm_ft",), ("l_arm_ft",)]
    assert "r_hand" in models.sub_models[0].links
    assert "l_hand" in models.sub_models[1].links


def test_nothing_that_is_not_finite_ever_leaves(arms: RobotFile) -> None:
    stand = Stand(arms)
    stand.calibrate()
    random = np.random.default_rng(1)
    kinds = [*FAULTS.values(), 1e300, -1e200, 0.0]
    for _ in range(150):
        stand.faults = {
            name: kinds[int(random.integers(len(kinds)))]
            for name in stand.sensors
            if random.random() < 0.5
        }
        stand.unheard = {"left_arm"} if random.random() < 0.1 else set()
        stand.run(int(random.integers(1, 8)))
    sent = [m for stream in torque_streams(stand.dynamics) for m in stand.bench.sent(stream)]
    assert len(sent) > 500
    assert all(math.isfinite(sum(message.tau_nm)) for message in sent)
    stand.faults, stand.unheard = {}, set()
    stand.run(300)
    assert stand.silent() == {}
    assert stand.health("r_arm_ft").ok


def test_a_lost_foot_sensor_silences_its_leg_only() -> None:
    stand = Stand(load_robot("icub:lower_body"))
    stand.calibrate()
    assert stand.silent() == {"torso": "no sensor feels it"}
    stand.faults = {"l_foot_ft": None}
    stand.run(50)
    assert sorted(stand.silent()) == ["left_leg", "torso"]
    assert "l_foot_ft cannot be used" in stand.silent()["left_leg"]


def test_a_late_sensor_holds_up_no_other_limb(stand: Stand) -> None:
    stand.faults = {"r_arm_ft": None}
    before = [len(stand.bench.sent(TORQUE_ESTIMATE[arm])) for arm in ("left_arm", "right_arm")]
    stand.run(1)
    after = [len(stand.bench.sent(TORQUE_ESTIMATE[arm])) for arm in ("left_arm", "right_arm")]
    assert after == [before[0] + 1, before[1]]


def test_an_older_reading_that_overtook_a_newer_one_is_refused(stand: Stand) -> None:
    sensor = stand.body.sensors[1]
    old = stand.batch()[sensor.wrench]
    stand.run(3)
    before = len(stand.bench.sent(TORQUE_ESTIMATE["right_arm"]))
    stand.bench.put(sensor.wrench, msgspec.structs.replace(old, stamp_ns=stand.now_ns - 5_000_000))
    assert stand.flags("r_arm_ft") == ("reordered",)
    assert len(stand.bench.sent(TORQUE_ESTIMATE["right_arm"])) == before


@pytest.mark.parametrize(("turned_rad", "looks_lost"), [(0.45, 16), (0.0, 0)])
def test_a_part_that_comes_back_elsewhere_is_no_touch_of_the_limbs_on_it(
    turned_rad: float, looks_lost: int
) -> None:
    """No look until 160 ms of the filter are full again; then all is as before."""
    stand = Stand(load_robot("icub:reach"))
    stand.calibrate()
    stand.run(100)
    stand.unheard = {"torso"}
    stand.run(1000)
    torso = next(part for part in stand.body.parts if part.name == "torso")
    stand.q_rad = stand.q_rad.copy()
    stand.q_rad[torso.start : torso.stop] += turned_rad
    looks, samples = len(stand.bench.sent(EXTERNAL)), len(stand.bench.sent(DYNAMICS_SAMPLES))
    stand.unheard = set()
    stand.run(500)
    after = stand.bench.sent(EXTERNAL)[looks:]
    assert len(after) == 50 - looks_lost
    assert not any(contact.touching for message in after for contact in message.contacts)
    for message in stand.bench.sent(DYNAMICS_SAMPLES)[samples:]:
        for sensor in message.sensors:
            assert sensor.valid
            assert sensor.measured == pytest.approx(sensor.predicted, abs=0.1)
