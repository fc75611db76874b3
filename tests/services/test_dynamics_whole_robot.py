"""The emulated robot with all its limbs in virtual time: sensors, pushes, a sensor that dies."""

import msgspec
import numpy as np
import pytest

from services.config import load_robot
from services.core.service import Period
from services.emulated.messages import FaultRequest, PushRequest
from services.emulated.simulation import Simulation
from services.robotfile.robot_selection import select
from services.robotfile.robot_tables import RobotFile
from services.script import Script, ScriptedService
from services.streams import (
    DYNAMICS_CALL,
    DYNAMICS_HEALTH,
    DYNAMICS_MODELS,
    EXTERNAL,
    FAULT_CALL,
    JOINT_STATE,
    PUSH_CALL,
    ROBOT_CALL,
    ROBOT_STATUS,
)
from services.wholebody.dynamics_messages import (
    ContactEstimate,
    DynamicsHealth,
    DynamicsModels,
    DynamicsRequest,
)

pytestmark = pytest.mark.slow

OPEN_TIMEOUT_S = 20.0
CALIBRATION_TIMEOUT_S = 60.0
PUSH_N = (0.0, 15.0, 0.0)
FELT_BY = {"r_hand": "r_arm_ft", "l_forearm": "l_arm_ft", "l_lower_leg": "l_leg_ft"}
LIMBS = ("head", "torso", "left_arm", "right_arm", "left_leg", "right_leg")
ARMS = ("left_arm", "right_arm")
SPRINGS = ("shoulder_pitch", "shoulder_roll", "shoulder_yaw", "elbow")
LONGEST_TICKS = 60_000


class Trial(ScriptedService):
    """Calibrates axes and sensors, pushes links, makes both arms compliant, mutes an FT board."""

    trigger = Period(0.01)
    reads = (
        *(ROBOT_STATUS, DYNAMICS_HEALTH, EXTERNAL, DYNAMICS_MODELS),
        *(JOINT_STATE[arm] for arm in ARMS),
    )
    calls = (ROBOT_CALL, DYNAMICS_CALL, PUSH_CALL, FAULT_CALL)

    def __init__(self, robot: RobotFile) -> None:
        self.free: dict[str, ContactEstimate] = {}
        self.pushed: dict[str, dict[str, ContactEstimate]] = {}
        self.after: dict[str, ContactEstimate] = {}
        self.models: DynamicsModels | None = None
        self.health: list[DynamicsHealth | None] = []  # calibrated, without a sensor, with it again
        self.compliant: list[list[tuple[bool, ...]]] = []  # of both arms, before and without it
        self.faults_said = ""
        super().__init__(tuple(joint for names in robot.parts.values() for joint in names))

    def script(self) -> Script:
        yield from self.until(self._is_open, OPEN_TIMEOUT_S, "boards answer")
        yield from self.ask("axes", "calibrate", CALIBRATION_TIMEOUT_S)
        yield from self._wait(1.0)
        calibrate = DynamicsRequest(action="calibrate")
        yield from self.answered(self.outputs.call(DYNAMICS_CALL, calibrate), "calibrate")
        yield from self._wait(1.0)
        self.models = self.inputs.latest(DYNAMICS_MODELS)
        self._note_health()
        yield from self._push()
        yield from self._lose_a_sensor()

    def _push(self) -> Script:
        self.free = self._contacts()
        for link in FELT_BY:
            push = PushRequest(force_n=PUSH_N, duration_s=0.6, frame=link)
            yield from self.answered(self.outputs.call(PUSH_CALL, push), "push")
            yield from self._wait(0.5)
            self.pushed[link] = self._contacts()
            yield from self._wait(0.7)
        self.after = self._contacts()

    def _lose_a_sensor(self) -> Script:
        springs = tuple(f"{side}_{joint}" for side in "lr" for joint in SPRINGS)
        yield from self.ask("springs", "interaction", joints=springs, value="compliant")
        yield from self._wait(0.5)
        self._note_compliance()
        mute = FaultRequest(kind="mute", bus=2, address=13)
        yield from self.answered(self.outputs.call(FAULT_CALL, mute), "fault")
        yield from self._wait(0.3)
        self._note_health()
        self._note_compliance()
        self.faults_said = self.faults()
        heal = msgspec.structs.replace(mute, on=False)
        yield from self.answered(self.outputs.call(FAULT_CALL, heal), "fault")
        yield from self._wait(0.5)
        self._note_health()

    def _wait(self, seconds: float) -> Script:
        end_ns = self.now_ns + round(seconds * 1e9)
        while self.now_ns < end_ns:
            yield

    def _contacts(self) -> dict[str, ContactEstimate]:
        message = self.inputs.latest(EXTERNAL)
        return {} if message is None else {c.sensor: c for c in message.contacts}

    def _note_health(self) -> None:
        self.health.append(self.inputs.latest(DYNAMICS_HEALTH))

    def _note_compliance(self) -> None:
        states = [self.inputs.latest(JOINT_STATE[arm]) for arm in ARMS]
        self.compliant.append([state.compliant for state in states if state is not None])

    def _is_open(self) -> bool:
        return self.status().phase in ("idle", "ready")


@pytest.fixture(scope="module")
def trial() -> Trial:
    """The trial, run to its end."""
    named = msgspec.structs.replace(load_robot("icub"), selections={"limbs": LIMBS})
    robot = select(named, "limbs")  # hands and skin cost time and have no FT sensor
    trial = Trial(robot)
    simulation = Simulation(robot, guests={"trial": trial}, learner=True)
    while not trial.finished and simulation.executor.ticks < LONGEST_TICKS:
        simulation.executor.tick()
    simulation.close()
    assert trial.finished
    return trial


def test_six_sensors_agree_with_the_model(trial: Trial) -> None:
    assert trial.models is not None
    assert len(trial.models.sub_models) == 7
    calibrated = trial.health[0]
    assert calibrated is not None
    assert [sensor.ok for sensor in calibrated.sensors] == [True] * 6
    assert calibrated.silent == ()
    sizes_n = [float(np.linalg.norm(contact.force_n)) for contact in trial.free.values()]
    assert len(sizes_n) == 6
    assert max(sizes_n) < 0.3


@pytest.mark.parametrize("link", FELT_BY)
def test_a_push_is_felt_by_its_limb_alone(trial: Trial, link: str) -> None:
    touching = [name for name, contact in trial.pushed[link].items() if contact.touching]
    assert touching == [FELT_BY[link]]
    assert trial.pushed[link][FELT_BY[link]].force_n == pytest.approx(PUSH_N, abs=0.5)
    assert not any(contact.touching for contact in trial.after.values())


def test_an_arm_whose_sensor_dies_is_made_stiff_and_the_other_stays_compliant(
    trial: Trial,
) -> None:
    springs = (True,) * len(SPRINGS) + (False,) * 3
    assert trial.compliant == [[springs, springs], [springs, (False,) * 7]]
    assert "r_shoulder_pitch" in trial.faults_said
    assert "made stiff" in trial.faults_said
    assert "l_" not in trial.faults_said
    _, without, again = trial.health
    assert without is not None
    flags = {sensor.name: sensor.flags for sensor in without.sensors if sensor.flags}
    assert flags == {"r_arm_ft": ("missing",)}
    assert [part for part, _ in without.silent] == ["torso", "right_arm"]
    assert again is not None
    assert again.silent == ()
