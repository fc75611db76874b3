"""A robot in some posture as its sensors show it, made without the estimator."""

from collections.abc import Callable
from functools import cache

import numpy as np
from numpy.typing import NDArray

from dforc.robot_model import RobotModel
from services.core.clock import NS_PER_MS
from services.core.stream import AnyStream, Stream
from services.core.testing import Bench
from services.dynamics import Dynamics
from services.messages import JointState, Message, Reply, TorqueEstimate, Wrench
from services.robotfile.robot_tables import RobotFile
from services.streams import DYNAMICS_CALL, DYNAMICS_HEALTH, EXTERNAL
from services.wholebody.dynamics_messages import ContactEstimate, DynamicsRequest, SensorHealth

Vector = NDArray[np.float64]

POSITION_DIRECT = 0x08
NOISE = np.array([0.02, 0.02, 0.02, 0.001, 0.001, 0.001])  # N, Nm; below what any test looks at
OFFSET = np.array([1.5, -1.0, 0.7, 0.05, -0.08, 0.02])
STATE_EVERY_MS = 4
LATE_NS = 50_000
BENT_RAD = 0.3  # every joint: no posture that the model knows by heart
NOT_FELT = "root_link"


@cache
def robot_model(
    urdf: str, joints: tuple[str, ...], tip: str, sensor_frames: tuple[tuple[str, str], ...]
) -> RobotModel:
    """The model that makes the readings, loaded once."""
    return RobotModel(urdf, joints, tip, dict(sensor_frames))


class Stand:
    """Feeds one dynamics service, millisecond by millisecond; joints stand, glide or follow `path`.

    A sensor's reading is true + offset, changed by what `faults` says: a number to add, a flag of
    the message, or None where it does not come. `push_n` acts on the origin of link `pushed`.
    """

    def __init__(self, robot: RobotFile, pushed: str = NOT_FELT, seed: int = 0) -> None:
        self.dynamics = Dynamics(robot)
        self.bench = Bench(self.dynamics)
        self.body = self.dynamics.body
        self.sensors = tuple(sensor.name for sensor in self.body.sensors)
        count = len(self.body.joints)
        frames = tuple(self.body.sensor_frames.items())
        self.model = robot_model(str(self.body.urdf), self.body.joints, pushed, frames)
        self.q_rad: Vector = np.full(count, BENT_RAD)
        self.dq_rad_s: Vector = np.zeros(count)
        self.ddq_rad_s2: Vector = np.zeros(count)
        self.path: Callable[[float], tuple[Vector, Vector, Vector]] | None = None
        self.push_n: Vector = np.zeros(3)
        self.offsets = {name: (i + 1.0) * OFFSET for i, name in enumerate(self.sensors)}
        self.gains: dict[str, Vector] = {}  # what a reading has to be multiplied with
        self.faults: dict[str, str | float | None] = {}
        self.unheard: set[str] = set()  # parts
        self.late: set[str] = set()  # parts whose states come in a step of their own
        self.others: dict[AnyStream, Message] = {}  # for the coming step
        self._random = np.random.default_rng(seed)
        self._pushed = pushed
        self._ticks = 0
        self._motion = b""
        self._true: dict[str, Vector] = {}

    @property
    def now_ns(self) -> int:
        """Virtual time."""
        return self.bench.clock.now_ns()

    def run(self, milliseconds: int) -> None:
        """Let time pass; joints go on at their speeds."""
        for _ in range(milliseconds):
            batch = self.batch()
            states: list[AnyStream] = [
                part.state for part in self.body.parts if part.name in self.late
            ]
            late: dict[AnyStream, Message] = {
                state: batch.pop(state) for state in states if state in batch
            }
            self.bench.put_together(batch)
            if late:
                self.bench.clock.advance_ns(LATE_NS)
                self.bench.put_together(late)
            self.bench.clock.advance_ns(NS_PER_MS - (LATE_NS if late else 0))
            self._ticks += 1
            self._move()

    def _move(self) -> None:
        if self.path is None:
            self.q_rad = self.q_rad + 0.001 * self.dq_rad_s
        else:
            self.q_rad, self.dq_rad_s, self.ddq_rad_s2 = self.path(0.001 * self._ticks)

    def batch(self) -> dict[AnyStream, Message]:
        """What is sent in this millisecond."""
        messages: dict[AnyStream, Message] = dict(self.others)
        self.others = {}
        if self._ticks % STATE_EVERY_MS == 0:
            for part in self.body.parts:
                if part.name not in self.unheard:
                    messages[part.state] = self.state(part.name)
        true = self.true_wrenches()
        for sensor in self.body.sensors:
            reading = self._reading(sensor.name, true[sensor.name])
            if reading is not None:
                messages[sensor.wrench] = reading
        return messages

    def state(self, name: str) -> JointState:
        """A part's joint state; joints that the model has not got stand at zero."""
        part = next(part for part in self.body.parts if part.name == name)
        return JointState(
            stamp_ns=self.now_ns,
            q_rad=part.to_stream(self.q_rad.tolist()),
            dq_rad_s=part.to_stream(self.dq_rad_s.tolist()),
            tau_nm=(0.0,) * part.size,
            control_mode=(POSITION_DIRECT,) * part.size,
            compliant=(False,) * part.size,
            valid=True,
        )

    def true_wrenches(self) -> dict[str, Vector]:
        """What each sensor measures: the limb's weight and motion, and the push it feels."""
        motion = np.concatenate([self.q_rad, self.dq_rad_s, self.ddq_rad_s2, self.push_n]).tobytes()
        if motion != self._motion:
            self._motion, self._true = motion, self._measured()
        return self._true

    def _measured(self) -> dict[str, Vector]:
        _, wrenches = self.model.inverse_dynamics(self.q_rad, self.dq_rad_s, self.ddq_rad_s2)
        _, point = self.model.tip_pose(self.q_rad)
        above = self.body.tree.joints_above(self._pushed)
        for sensor in self.body.sensors:
            if sensor.frame in above:
                turn, origin = self.model.sensor_pose(self.q_rad, sensor.name)
                moment = np.cross(point - origin, self.push_n)
                wrenches[sensor.name] += np.concatenate([turn.T @ self.push_n, turn.T @ moment])
        return wrenches

    def tau_nm(self) -> Vector:
        """What the drives exert."""
        tau_nm = self.model.rnea(self.q_rad, self.dq_rad_s, self.ddq_rad_s2)
        return tau_nm - self.model.tip_jacobian(self.q_rad)[:3].T @ self.push_n

    def ask(self, action: str, *sensors: str, value: str = "", samples: int = 100) -> Reply:
        """One request and its answer."""
        return self.request(
            DynamicsRequest(action=action, sensors=sensors, value=value, samples=samples)
        )

    def request(self, request: DynamicsRequest) -> Reply:
        """One request and its answer."""
        self.bench.request(DYNAMICS_CALL, request)
        return self.bench.replies(DYNAMICS_CALL)[-1][1]

    def calibrate(self) -> None:
        """All sensors, and until the filters have filled."""
        self.run(20)
        assert self.ask("calibrate").ok
        self.run(220)

    def health(self, name: str) -> SensorHealth:
        """The newest word on a sensor."""
        message = self.bench.last(DYNAMICS_HEALTH)
        return next(sensor for sensor in message.sensors if sensor.name == name)

    def flags(self, name: str) -> tuple[str, ...]:
        """What is wrong with a sensor in this very step."""
        return self.dynamics.bank.flags(self.sensors.index(name))

    def silent(self) -> dict[str, str]:
        """Parts without torques, and why."""
        return dict(self.dynamics.gate.silent)

    def contact(self, sensor: str) -> ContactEstimate:
        """The newest word on what a sensor feels first."""
        contacts = self.bench.last(EXTERNAL).contacts
        return next(contact for contact in contacts if contact.sensor == sensor)

    def _reading(self, name: str, true: Vector) -> Wrench | None:
        noise = NOISE * self._random.standard_normal(6)  # drawn in any case: others stay the same
        fault = self.faults.get(name, 0.0)
        if fault is None:
            return None
        raw = true + self.offsets[name]
        if name in self.gains:
            raw = np.asarray(np.linalg.solve(self.gains[name], raw), dtype=np.float64)
        raw = raw + noise
        fx, fy, fz, mx, my, mz = (raw + (fault if isinstance(fault, float) else 0.0)).tolist()
        return Wrench(
            stamp_ns=self.now_ns,
            force_n=(fx, fy, fz),
            torque_nm=(mx, my, mz),
            arrival_ns=self.now_ns,
            saturated=fault == "saturated",
            frozen=fault == "frozen",
        )


def swing(
    middle_rad: Vector, amplitude_rad: float, hz: float
) -> Callable[[float], tuple[Vector, Vector, Vector]]:
    """All joints on sines of unequal frequencies, up to `hz`: angles, speeds, accelerations."""
    w = 2.0 * np.pi * hz * np.linspace(0.5, 1.0, len(middle_rad))

    def path(t_s: float) -> tuple[Vector, Vector, Vector]:
        sine, cosine = amplitude_rad * np.sin(w * t_s), amplitude_rad * np.cos(w * t_s)
        return middle_rad + sine, w * cosine, -w * w * sine

    return path


def torque_streams(dynamics: Dynamics) -> list[Stream[TorqueEstimate]]:
    """The torque streams that a service writes."""
    return [part.torque for part in dynamics.body.parts if part.torque in dynamics.writes]
