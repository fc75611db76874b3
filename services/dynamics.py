"""Whole-body dynamics: joint torques from the FT sensors in the limbs, contacts, and gravity.

Reads   wrench of every FT sensor and joint_state of every part (triggers), IMUs, skin, and the
        learner's predictions
Writes  torque_estimate and impedance_offset of every part whose boards take torques; dynamics/
        status, contacts, samples, health, models
Serves  dynamics/request, and dynamics/zero_ft: find the offset of FT sensors
Torques come from unfiltered readings, with the measured velocities and without accelerations: what
these add beyond a sensor, it measures. Only how an IMU turns faster, and the joints between it and
the base with it, is estimated. A part's torques are silent while a sensor that they need is
lost or not calibrated, or joints that they need are not heard; the HAL then makes it stiff. Which
parts are silent, and why, is told in dynamics/health. Nothing stops for a calibration.
"""

from dataclasses import replace

import numpy as np

from dforc.errors import DforcError
from dforc.estimation.assumption import Assumption
from dforc.estimation.estimate import BodyEstimate
from dforc.estimation.estimator import WholeBodyEstimator
from dforc.estimation.tree_model import TreeModel
from services.config import load_robot
from services.core.live import Context, run_process
from services.core.service import Inputs, Outputs, Service
from services.messages import ImpedanceOffset, TorqueEstimate
from services.robotfile.rates import Rates
from services.robotfile.robot_tables import RobotFile
from services.robotfile.shape_tables import link_shapes
from services.streams import (
    DYNAMICS_CALL,
    DYNAMICS_HEALTH,
    DYNAMICS_MODELS,
    DYNAMICS_SAMPLES,
    DYNAMICS_STATUS,
    EXTERNAL,
    FT_CALL,
    LEARNED,
)
from services.wholebody.assumed_contacts import default_assumption
from services.wholebody.body import Body
from services.wholebody.dynamics_reports import Reports
from services.wholebody.dynamics_requests import answer
from services.wholebody.filtered_body import FilteredBody
from services.wholebody.gravity_torques import GravityTorques
from services.wholebody.joint_bank import JointBank
from services.wholebody.kinematic_source import KinematicSource
from services.wholebody.known_loads import KnownLoads
from services.wholebody.learned_correction import Correction
from services.wholebody.sensor_bank import SensorBank
from services.wholebody.sensor_tasks import SensorTasks
from services.wholebody.skin_watch import SkinWatch
from services.wholebody.torque_gate import TorqueGate

LOOK_PERIOD_NS = 10_000_000
STATUS_EVERY_LOOKS = 2
HEALTH_EVERY_LOOKS = 10


class Dynamics(Service):
    """Newton-Euler estimate of all limbs in use."""

    def __init__(self, robot: RobotFile, rates: Rates | None = None) -> None:
        """`rates` are those of the robot process; by default the virtual ones."""
        body = Body(robot)
        model = TreeModel.from_urdf(str(body.urdf), body.joints, body.sensor_frames)
        self.body = body
        self.assumption = default_assumption(body)
        self.assumption_name = "default"
        self.bank = SensorBank(body.sensors, 1.0 / (rates or Rates.virtual(robot)).wrench_hz)
        self.joints = JointBank(body.parts, model.n)
        self.tasks = SensorTasks(body.sensors, self.bank)
        self.source = KinematicSource(body)
        self.correction = Correction(body.sensors)
        self.skin = SkinWatch(robot, body)
        self.loads = KnownLoads(body)
        shapes = link_shapes(robot)
        self.filtered = FilteredBody(
            body, model, self.assumption, self.bank, shapes, self.skin, self.loads
        )
        self.gate = TorqueGate(body, self.assumption, self.bank, self.joints, self.source)
        self.estimator = WholeBodyEstimator(model, self.assumption)
        self.refused = 0  # estimates that could not be made
        self.reason = ""
        self.newest: BodyEstimate | None = None  # since the last status
        self._contacts = self.assumption.contacts  # those that are located, where they are
        self._reports = Reports(robot, self)
        self._gravity = GravityTorques(model)
        self._next_look_ns = 0
        self._looks = 0
        self._gravity.torques(
            self.joints.q_rad, None
        )  # compiled now, if not yet, and not in a step
        felt = tuple(part for part in body.parts if part.felt)
        wrenches = tuple(sensor.wrench for sensor in body.sensors)
        states = tuple(part.state for part in body.parts)
        self.trigger = (*wrenches, *states)
        self.reads = (*wrenches, *states, *self.source.streams, *self.skin.streams, LEARNED)
        self.writes = (
            *(part.torque for part in felt),
            *(part.offset for part in felt),
            *(DYNAMICS_STATUS, EXTERNAL, DYNAMICS_SAMPLES, DYNAMICS_HEALTH, DYNAMICS_MODELS),
        )
        self.serves = (FT_CALL, DYNAMICS_CALL)

    def step(self, now_ns: int, inputs: Inputs, outputs: Outputs) -> None:
        """One estimate per batch of readings."""
        answer(self, now_ns, inputs, outputs)
        new_joints = self.joints.take(now_ns, inputs)
        if new_joints:
            self.source.add_joints(self.joints.q_rad, now_ns)
        new_readings = self.bank.take(now_ns, inputs)
        self.source.take(now_ns, inputs)
        self.correction.take(inputs)
        self.gate.update()
        wanted = self.gate.speaking or self.tasks.is_calibrating
        if new_readings and wanted and self.source.is_ready:
            self._estimate(now_ns, outputs)
        self.tasks.look(now_ns, self.gate.trouble_around)
        if self.joints.elsewhere:
            self.filtered.forget_motion()
        if new_joints:
            self.filtered.add_joints(self.joints.q_rad, now_ns)
        if now_ns >= self._next_look_ns:
            self._next_look_ns = now_ns + LOOK_PERIOD_NS
            self.skin.look(now_ns, inputs)
            self._look(now_ns, outputs)

    def assume(self, name: str, assumption: Assumption) -> None:
        """Other contacts or another kinematic source from now on.

        Raises:
            AssumptionError: a frame is unknown; nothing has changed.
        """
        self.estimator.assume(assumption)
        self.filtered.estimator.assume(assumption)
        self.filtered.contacts.assume(assumption)
        self.gate.assume(assumption)
        self.loads.use(assumption.known)
        if assumption.source != self.source.frame:
            self.source.use(assumption.source)
            self._gravity.use(assumption.source)
        self.assumption, self.assumption_name = assumption, name
        self.newest = None  # of other contacts
        self._contacts = assumption.contacts

    def _estimate(self, now_ns: int, outputs: Outputs) -> None:
        """Torques of every part that may have them, where its own sensors have new readings."""
        bank, joints = self.bank, self.joints
        readings = bank.compensated()
        try:
            estimate = self.estimator.estimate(
                joints.q_rad,
                joints.dq_rad_s,
                self.source.ddq_rad_s2,
                readings,
                bank.mask,
                self.source.motion,
            )
        except DforcError as error:  # numbers beyond what can be multiplied
            self.refused += 1
            self.reason = str(error)
            return
        self.newest = estimate
        tau_nm = estimate.tau_nm.tolist()
        arrivals_ns = bank.arrival_ns
        for part, sensors in self.gate.speaking:
            if any(bank.new[i] for i in sensors):
                outputs.put(
                    part.torque,
                    TorqueEstimate(
                        stamp_ns=now_ns,
                        tau_nm=part.to_stream(tau_nm),
                        arrival_ns=min([arrivals_ns[i] for i in sensors]),
                    ),
                )
        if self.tasks.is_calibrating:
            fastest = float(np.abs(joints.dq_rad_s).max())
            touched = self.filtered.is_pressed
            internal = self.loads.added_to(estimate.internal, self.estimator)
            self.tasks.add_readings(now_ns, internal, fastest, self.gate.heard, touched)

    def _look(self, now_ns: int, outputs: Outputs) -> None:
        self._looks += 1
        try:
            look = self.filtered.look(
                now_ns, self.gate.heard, self.source, self.correction, self.tasks
            )
        except DforcError as error:
            self.refused += 1
            self.reason = str(error)
            look = None
        if look is not None:
            outputs.put(EXTERNAL, look.contacts)
            outputs.put(DYNAMICS_SAMPLES, look.samples)
            self._follow_contacts()
        self._put_gravity(now_ns, outputs)
        if self._looks % STATUS_EVERY_LOOKS == 0:
            outputs.put(DYNAMICS_STATUS, self._reports.status(now_ns))
            self.newest = None
        if self._looks % HEALTH_EVERY_LOOKS == 0:
            outputs.put(DYNAMICS_HEALTH, self._reports.health(now_ns))
            if look is not None:
                outputs.put(DYNAMICS_MODELS, self._reports.models(now_ns, look.estimate))

    def _follow_contacts(self) -> None:
        """A touch whose link is sure acts there in the torques too."""
        contacts = self.filtered.contacts.assumed(self.assumption)
        if contacts != self._contacts:
            self._contacts = contacts
            self.estimator.assume(replace(self.assumption, contacts=contacts))

    def _put_gravity(self, now_ns: int, outputs: Outputs) -> None:
        if not self.gate.postured:
            return
        gravity = self._gravity.torques(self.joints.q_rad, self.source.motion).tolist()
        for part in self.gate.postured:
            offset = ImpedanceOffset(stamp_ns=now_ns, tau_nm=part.to_stream(gravity))
            outputs.put(part.offset, offset)


def build(context: Context) -> Dynamics:
    """Load the robot's model."""
    robot = load_robot(context.robot)
    return Dynamics(robot, Rates.live(robot))


if __name__ == "__main__":
    raise SystemExit(run_process("dynamics", build))
