"""The emulated robot with all its limbs in virtual time: six sensors, pushes on three links."""

import msgspec
import numpy as np
import pytest

from services.config import load_robot
from services.core.service import Period
from services.dynamics_messages import ContactEstimate, DynamicsRequest
from services.messages import PushRequest
from services.robot_selection import select
from services.robot_tables import RobotFile
from services.script import Script, ScriptedService
from services.simulation import Simulation
from services.streams import (
    DYNAMICS_CALL,
    DYNAMICS_HEALTH,
    DYNAMICS_MODELS,
    EXTERNAL,
    PUSH_CALL,
    ROBOT_CALL,
    ROBOT_STATUS,
)

pytestmark = pytest.mark.slow

OPEN_TIMEOUT_S = 20.0
CALIBRATION_TIMEOUT_S = 60.0
PUSH_N = np.array([0.0, 15.0, 0.0])
LIMBS = ("head", "torso", "left_arm", "right_arm", "left_leg", "right_leg")
LONGEST_TICKS = 60_000


class Trial(ScriptedService):
    """Calibrates axes and sensors, then pushes links one after another."""

    trigger = Period(0.01)
    reads = (ROBOT_STATUS, DYNAMICS_HEALTH, EXTERNAL, DYNAMICS_MODELS)
    calls = (ROBOT_CALL, DYNAMICS_CALL, PUSH_CALL)

    def __init__(self, robot: RobotFile, links: tuple[str, ...]) -> None:
        self._links = links
        self.free: dict[str, ContactEstimate] = {}
        self.pushed: dict[str, dict[str, ContactEstimate]] = {}
        self.after: dict[str, ContactEstimate] = {}
        super().__init__(tuple(joint for names in robot.parts.values() for joint in names))

    def script(self) -> Script:
        yield from self.until(self._is_open, OPEN_TIMEOUT_S, "boards answer")
        yield from self.ask("axes", "calibrate", CALIBRATION_TIMEOUT_S)
        yield from self._wait(1.0)
        calibrate = DynamicsRequest(action="calibrate")
        yield from self.answered(self.outputs.call(DYNAMICS_CALL, calibrate), "calibrate")
        yield from self._wait(1.0)
        self.free = self._contacts()
        for link in self._links:
            force_n = (float(PUSH_N[0]), float(PUSH_N[1]), float(PUSH_N[2]))
            push = PushRequest(force_n=force_n, duration_s=0.6, frame=link)
            yield from self.answered(self.outputs.call(PUSH_CALL, push), "push")
            yield from self._wait(0.5)
            self.pushed[link] = self._contacts()
            yield from self._wait(0.7)
        self.after = self._contacts()

    def _is_open(self) -> bool:
        return self.status().phase in ("idle", "ready")

    def _wait(self, seconds: float) -> Script:
        end_ns = self.now_ns + round(seconds * 1e9)
        while self.now_ns < end_ns:
            yield

    def _contacts(self) -> dict[str, ContactEstimate]:
        message = self.inputs.latest(EXTERNAL)
        return {} if message is None else {c.sensor: c for c in message.contacts}


def test_six_sensors_agree_with_the_model_and_every_push_is_felt_by_its_limb() -> None:
    whole = load_robot("icub")
    named = msgspec.structs.replace(whole, selections={"limbs": LIMBS})
    robot = select(named, "limbs")  # hands and skin cost time and have no FT sensor
    felt_by = {"r_hand": "r_arm_ft", "l_forearm": "l_arm_ft", "l_lower_leg": "l_leg_ft"}
    trial = Trial(robot, tuple(felt_by))
    simulation = Simulation(robot, guests={"trial": trial}, learner=True)
    while not trial.finished and simulation.executor.ticks < LONGEST_TICKS:
        simulation.executor.tick()
    health = trial.inputs.latest(DYNAMICS_HEALTH)
    models = trial.inputs.latest(DYNAMICS_MODELS)
    simulation.close()
    assert trial.finished
    assert health is not None
    assert models is not None
    assert [sensor.ok for sensor in health.sensors] == [True] * 6
    assert health.silent == ()
    assert len(models.sub_models) == 7
    sizes_n = [float(np.linalg.norm(c.force_n)) for c in trial.free.values()]
    assert len(sizes_n) == 6
    assert max(sizes_n) < 0.3
    for link, sensor in felt_by.items():
        touching = [name for name, c in trial.pushed[link].items() if c.touching]
        assert touching == [sensor]
        assert trial.pushed[link][sensor].force_n == pytest.approx(PUSH_N, abs=0.5)
    assert not any(contact.touching for contact in trial.after.values())
