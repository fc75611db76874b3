"""What the dynamics service says of itself to slower readers."""

from typing import TYPE_CHECKING

import msgspec
import numpy as np

from dforc.estimation.estimate import BodyEstimate
from services.messages import DynamicsStatus, Floats, Vector3
from services.robotfile.robot_tables import RobotFile
from services.wholebody.assumed_contacts import source_name
from services.wholebody.dynamics_messages import (
    DynamicsHealth,
    DynamicsModels,
    KnownLoad,
    SubModelStatus,
)

if TYPE_CHECKING:
    from services.dynamics import Dynamics


class Reports:
    """Status, health and models; the status is about the limb that reaches, if it is in use."""

    def __init__(self, robot: RobotFile, dynamics: "Dynamics") -> None:
        self._dynamics = dynamics
        body = dynamics.body
        names = [sensor.name for sensor in body.sensors]
        self._sensor = names.index(robot.reach.sensor) if robot.reach.sensor in names else 0
        self._chain = [body.joints.index(j) for j in robot.chain] if robot.can_reach else []
        self._tip = robot.reach.tip_frame if robot.can_reach else ""

    def status(self, now_ns: int) -> DynamicsStatus:
        """Offset and external wrench of the reaching limb."""
        dynamics = self._dynamics
        task, samples, _ = dynamics.tasks.progress(self._sensor)
        calibrated = dynamics.bank.calibrated[self._sensor]
        if dynamics.tasks.is_calibrating:
            state = "calibrating"
        else:
            state = "running" if calibrated else "waiting"
        status = DynamicsStatus(
            stamp_ns=now_ns,
            state=state,
            samples=samples if task == "calibrating" else 0,
            offset=_floats(dynamics.bank.channels[self._sensor].offset) if calibrated else (),
            refused=dynamics.bank.refused + dynamics.joints.refused + dynamics.refused,
            reason=self._reason(),
        )
        estimate = dynamics.newest
        if estimate is None or not dynamics.bank.valid[self._sensor]:
            return status
        force, moment = self._external(estimate)
        tau_nm = estimate.tau_nm[self._chain]
        return msgspec.structs.replace(
            status, external_force_n=force, external_moment_nm=moment, tau_nm=_floats(tau_nm)
        )

    def health(self, now_ns: int) -> DynamicsHealth:
        """Every sensor, and the parts that get no torques."""
        dynamics = self._dynamics
        return DynamicsHealth(
            stamp_ns=now_ns,
            sensors=dynamics.filtered.health.messages(dynamics.bank, dynamics.tasks),
            silent=dynamics.gate.silent,
            imu=dynamics.source.trouble,
        )

    def models(self, now_ns: int, estimate: BodyEstimate) -> DynamicsModels:
        """Sub-models of a filtered estimate, and the whole."""
        dynamics = self._dynamics
        estimator = dynamics.filtered.estimator
        return DynamicsModels(
            stamp_ns=now_ns,
            assumption=dynamics.assumption_name,
            source=source_name(dynamics.body, dynamics.source.frame),
            mainstay=dynamics.assumption.mainstay,
            sub_models=tuple(
                SubModelStatus(
                    sensors=sub.sensors,
                    links=sub.links,
                    unknowns=sub.unknowns,
                    rank=sub.rank,
                    residual_n=sub.residual_n,
                    residual=_floats(sub.residual),
                )
                for sub in estimate.sub_models
            ),
            base_wrench=_floats(estimate.base_wrench),
            centre_of_mass_m=_vector3(estimator.centre_of_mass(dynamics.joints.q_rad)),
            mass_kg=float(estimator.model.mass.sum()),
            known=tuple(
                KnownLoad(frame=load.frame, wrench=load.wrench, point_m=load.point_m)
                for load in dynamics.assumption.known
            ),
        )

    def _external(self, estimate: BodyEstimate) -> tuple[Vector3, Vector3]:
        """The wrench beyond the limb's sensor, its moment about the tip."""
        dynamics = self._dynamics
        contacts = dynamics.filtered.contacts.of_sensor(self._sensor)
        if not contacts:
            return (0.0, 0.0, 0.0), (0.0, 0.0, 0.0)
        wrenches, points = estimate.contact_wrenches, estimate.contact_points_m
        tip_m = points[contacts[0]]
        if self._tip:
            _, tip_m = dynamics.estimator.frame_pose(self._tip)
        force, moment = np.zeros(3), np.zeros(3)
        for i in contacts:
            force += wrenches[i, :3]
            moment += wrenches[i, 3:] + np.cross(points[i] - tip_m, wrenches[i, :3])
        return _vector3(force), _vector3(moment)

    def _reason(self) -> str:
        """The first thing that is wrong."""
        dynamics = self._dynamics
        outcomes = [text for text in dynamics.tasks.outcome.values() if "given up" in text]
        if outcomes:
            return outcomes[0]
        for i, sensor in enumerate(dynamics.body.sensors):
            flags = [flag for flag in dynamics.bank.flags(i) if flag != "uncalibrated"]
            if flags:
                return f"{sensor.name} is {', '.join(flags)}"
        if dynamics.gate.silent:
            part, why = dynamics.gate.silent[0]
            return f"no torques for {part}: {why}"
        return dynamics.reason


def _floats(values: "np.ndarray[tuple[int], np.dtype[np.float64]]") -> Floats:
    return tuple(values.tolist())


def _vector3(values: "np.ndarray[tuple[int], np.dtype[np.float64]]") -> Vector3:
    x, y, z = values.tolist()
    return (x, y, z)
