"""Joint torques from the arm's force/torque sensor, and gravity, for the boards' 1 ms loops.

Reads   wrench of the limb's FT sensor (trigger), joint_state of the limb's parts
Writes  torque_estimate and impedance_offset of the limb's parts, dynamics/status
Serves  dynamics/zero_ft: remove the sensor's offset (no contact, arm at rest)
Nothing is published before the offset is known. When the sensor or a joint goes silent, so does the
estimate: the HAL then makes the limb stiff. A saturated sensor counts as silent. The stream does
not stop for a later calibration: the old offset holds until the new one is complete.
"""

import msgspec
import numpy as np

from dforc.dynamics import Estimate, NotAtRestError, OffsetSamples, TorqueEstimator, offset_of
from dforc.errors import DforcError
from services.config import load_robot
from services.core.live import Context, run_process
from services.core.service import Inputs, Outputs, Service
from services.limb import joined, limb_model, split
from services.messages import (
    DynamicsStatus,
    Floats,
    FtRequest,
    ImpedanceOffset,
    Reply,
    TorqueEstimate,
    Vector3,
    Wrench,
)
from services.robot_tables import RobotFile
from services.streams import (
    DYNAMICS_STATUS,
    FT_CALL,
    IMPEDANCE_OFFSET,
    JOINT_STATE,
    TORQUE_ESTIMATE,
    WRENCH,
)

STATE_AGE_S = 0.03  # a few joint states
OFFSET_PERIOD_NS = 10_000_000  # gravity offsets, as the boards are sent them
STATUS_PERIOD_NS = 20_000_000
REST_PATIENCE = 2000  # readings in motion before a calibration gives up


class Dynamics(Service):
    """Newton-Euler estimate of one limb."""

    def __init__(self, robot: RobotFile) -> None:
        self._robot = robot
        self._sensor = robot.reach.sensor
        self._estimator = TorqueEstimator(limb_model(robot), self._sensor)
        self._offset: Floats | None = None
        self._samples: OffsetSamples | None = None
        self._newest: Estimate | None = None
        self._refused = 0
        self._restless = 0
        self._reason = ""
        self._next_offset_ns = 0
        self._next_status_ns = 0
        parts = robot.reach.parts
        self._states = tuple(JOINT_STATE[part] for part in parts)
        self._wrench = WRENCH[self._sensor]
        self.trigger = self._wrench
        self.reads = (self._wrench, *self._states)
        self.writes = (
            *(TORQUE_ESTIMATE[part] for part in parts),
            *(IMPEDANCE_OFFSET[part] for part in parts),
            DYNAMICS_STATUS,
        )
        self.serves = (FT_CALL,)

    def step(self, now_ns: int, inputs: Inputs, outputs: Outputs) -> None:
        """One estimate per wrench."""
        for token, request in inputs.requests(FT_CALL):
            outputs.reply(FT_CALL, token, self._start_calibration(request))
        wrench = inputs.new(self._wrench)
        joints = joined(tuple([inputs.fresh(state, STATE_AGE_S) for state in self._states]))
        if wrench is not None and joints is not None:
            self._estimate(now_ns, wrench, joints, outputs)
        if now_ns >= self._next_status_ns:
            self._next_status_ns = now_ns + STATUS_PERIOD_NS
            outputs.put(DYNAMICS_STATUS, self._status(now_ns))

    def _estimate(
        self, now_ns: int, wrench: Wrench, joints: tuple[Floats, Floats], outputs: Outputs
    ) -> None:
        q_rad, dq_rad_s = joints
        reading = wrench.force_n + wrench.torque_nm
        if wrench.saturated or wrench.frozen:  # the sensor repeats a sample: that is no reading
            self._refused += 1
            state = "saturated" if wrench.saturated else "frozen"
            self._reason = f"the force/torque sensor is {state}"
            return
        if self._samples is not None:
            self._calibrate(q_rad, dq_rad_s, reading)
        if self._offset is None:
            return
        try:
            estimate = self._estimator.estimate(q_rad, dq_rad_s, reading, self._offset)
        except DforcError as error:  # not finite, or not the limb's number of joints
            self._refused += 1
            self._reason = str(error)
            return
        self._publish(now_ns, wrench, estimate, outputs)
        if now_ns >= self._next_offset_ns:
            self._next_offset_ns = now_ns + OFFSET_PERIOD_NS
            gravity = self._gravity(q_rad)
            for part, tau_nm in split(self._robot, gravity).items():
                outputs.put(IMPEDANCE_OFFSET[part], ImpedanceOffset(stamp_ns=now_ns, tau_nm=tau_nm))

    def _gravity(self, q_rad: Floats) -> Floats:
        return tuple(self._estimator.gravity(q_rad).tolist())

    def _publish(self, now_ns: int, wrench: Wrench, estimate: Estimate, outputs: Outputs) -> None:
        self._newest = estimate
        for part, tau_nm in split(self._robot, tuple(estimate.tau_nm.tolist())).items():
            outputs.put(
                TORQUE_ESTIMATE[part],
                TorqueEstimate(
                    stamp_ns=now_ns,
                    tau_nm=tau_nm,
                    arrival_ns=wrench.arrival_ns,
                ),
            )

    def _start_calibration(self, request: FtRequest) -> Reply:
        unknown = [name for name in request.sensors if name != self._sensor]
        if unknown:
            return Reply(ok=False, reason=f"no sensor {unknown[0]!r} here; there is {self._sensor}")
        if not 1 <= request.samples <= 100_000:
            return Reply(ok=False, reason=f"samples must be 1..100000, not {request.samples}")
        self._samples = OffsetSamples(wanted=request.samples)
        self._restless = 0
        self._reason = ""
        return Reply(ok=True)

    def _calibrate(self, q_rad: Floats, dq_rad_s: Floats, reading: Floats) -> None:
        assert self._samples is not None
        try:
            self._samples = self._estimator.add_sample(self._samples, q_rad, dq_rad_s, reading)
        except NotAtRestError as error:
            self._restless += 1
            if self._restless >= REST_PATIENCE:
                self._samples = None
                self._reason = f"calibration given up: {error}"
            return
        except DforcError as error:
            self._refused += 1
            self._reason = str(error)
            return
        if self._samples.complete:
            self._offset = tuple(offset_of(self._samples).tolist())
            self._samples = None

    def _status(self, now_ns: int) -> DynamicsStatus:
        if self._samples is not None:
            state = "calibrating"
        else:
            state = "waiting" if self._offset is None else "running"
        status = DynamicsStatus(
            stamp_ns=now_ns,
            state=state,
            samples=self._samples.count if self._samples else 0,
            offset=self._offset or (),
            refused=self._refused,
            reason=self._reason,
        )
        newest, self._newest = self._newest, None
        if newest is None:
            return status
        return msgspec.structs.replace(
            status,
            external_force_n=_vector3(newest.force_n),
            external_moment_nm=_vector3(newest.moment_nm),
            tau_nm=tuple(newest.tau_nm.tolist()),
        )


def _vector3(values: "np.ndarray[tuple[int], np.dtype[np.float64]]") -> Vector3:
    x, y, z = values.tolist()
    return (x, y, z)


def build(context: Context) -> Dynamics:
    """Load the robot's model."""
    return Dynamics(load_robot(context.robot))


if __name__ == "__main__":
    raise SystemExit(run_process("dynamics", build))
