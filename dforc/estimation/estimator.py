"""Torques of all joints and every external wrench, from force-torque sensors inside the limbs.

The force control paper's enhanced oriented graph: the sensors cut the robot into sub-models; in
each of them Newton and Euler leave six equations for the wrenches of the world on it. Kinematics
start at the base, or at an inertial sensor. In a sub-model

  - with as many independent equations as unknowns the contacts come out exactly;
  - with more equations they come out by least squares, moments about the middle of the contacts
    and 0.1 Nm weighing as much as 1 N; the residual says what is left over;
  - with more unknowns the answer is the one of least norm, in the same weights, singular values
    below 1e-4 of the largest dropped. The mainstay's wrench is not counted in that norm: it takes
    everything, and the other contacts of its sub-model are zero.

Torques between a valid sensor and the base are those of what the sensor measured, whatever was
found beyond it; beyond the sensor they are those of the contacts found. tau = RNEA - J' w.
Wrenches are (6,): force [N], moment [Nm].
"""

import numpy as np
from numpy.typing import NDArray

from dforc.arrays import ArrayLike, Matrix, Vector, finite_vector
from dforc.compiled import HAS_COMPILER
from dforc.errors import DforcError, NotFiniteError, ShapeError
from dforc.estimation import geometry
from dforc.estimation.assumption import Assumption, AssumptionError, BaseMotion, Point
from dforc.estimation.estimate import BodyEstimate
from dforc.estimation.path import DONE, WRONG_SHAPE, Path, Prepared
from dforc.estimation.plan import make_plan
from dforc.estimation.tree_model import TreeModel

MOST_PLANS = 64

Mask = NDArray[np.bool_]
Given = tuple[Vector, Vector, Vector, Matrix]


class WholeBodyEstimator:
    """The estimate of one robot. A tick is a pure function of its arguments and the assumption."""

    def __init__(
        self, model: TreeModel, assumption: Assumption, *, compiled: bool | None = None
    ) -> None:
        """Make ready; with a compiler this takes seconds the first time on a machine.

        Args:
            model: the robot.
            assumption: where the world may touch it.
            compiled: through numba, or by pinocchio and numpy; None takes numba where it is.

        Raises:
            AssumptionError: an unknown frame.
            DforcError: numba was asked for and is absent.
        """
        self.model = model
        self._path = _path(model, HAS_COMPILER if compiled is None else compiled)
        self._all = np.ones(model.m, dtype=np.bool_).tobytes()
        self._none = np.zeros(model.m, dtype=np.bool_).tobytes()
        self._still: Vector = np.zeros(model.n)
        self._unread: Matrix = np.zeros((model.m, 6))
        self._poses: Vector = np.zeros(12 * model.bodies)
        self._plans: dict[tuple[Assumption, bytes], Prepared] = {}
        self._upright = self._ready_for(Assumption(), self._none)
        self._mask = self._all
        self.assume(assumption)
        self._path.place(self._still, self._poses)

    def assume(self, assumption: Assumption) -> None:
        """Change the assumption between two ticks.

        Raises:
            AssumptionError: an unknown frame; the old assumption stays.
        """
        ready = self._ready_for(assumption, self._mask)
        free = Assumption(source=assumption.source, mainstay=False)
        self._free = self._ready_for(free, self._none)
        self._ready, self.assumption = ready, assumption

    def estimate(
        self,
        q_rad: Vector,
        dq_rad_s: Vector,
        ddq_rad_s2: Vector,
        wrenches: Matrix,
        valid: Mask | None = None,
        imu: BaseMotion | None = None,
    ) -> BodyEstimate:
        """One tick.

        Args:
            q_rad: joint angles (n,), in the order of the model.
            dq_rad_s: velocities (n,).
            ddq_rad_s2: accelerations (n,).
            wrenches: readings (m, 6): limb beyond the sensor on the near side, sensor frames.
            valid: (m,), which readings count; None: all. The others may hold anything.
            imu: motion of the kinematic source, needed where the assumption names one.

        Raises:
            NotFiniteError: NaN, infinity or an absurd number in what counts; nothing was changed.
            ShapeError: an array does not belong to the model.
        """
        mask = self._all if valid is None else self._mask_of(valid)
        if mask != self._mask:
            self._ready = self._ready_for(self.assumption, mask)
            self._mask = mask
        ready = self._ready
        if imu is not None or ready.moving:
            _set_motion(ready, imu)
        numbers: Vector = np.empty(ready.size)
        try:
            status = ready.run(q_rad, dq_rad_s, ddq_rad_s2, wrenches, numbers)
        except (TypeError, AttributeError):  # lists, other numbers, read-only or strided arrays
            status = _run_copies(ready, (q_rad, dq_rad_s, ddq_rad_s2, wrenches), numbers)
        if status != DONE:
            _refuse(self.model, status, (q_rad, dq_rad_s, ddq_rad_s2, wrenches))
        self._poses = numbers
        return BodyEstimate(ready.plan, numbers)

    def predict(
        self,
        q_rad: Vector,
        dq_rad_s: Vector,
        ddq_rad_s2: Vector,
        imu: BaseMotion | None = None,
    ) -> Matrix:
        """Every sensor's reading (m, 6) if nothing touched the robot, in the sensor frames."""
        if imu is not None or self._free.moving:
            _set_motion(self._free, imu)
        return self._run(self._free, (q_rad, dq_rad_s, ddq_rad_s2)).internal

    def gravity(self, q_rad: Vector) -> Vector:
        """Torques (n,) that hold the robot still, its base upright and nothing touching it."""
        return self._run(self._upright, (q_rad, self._still, self._still)).tau_nm

    def centre_of_mass(self, q_rad: Vector) -> Vector:
        """Centre of mass of the whole robot (3,), base frame, m."""
        return geometry.centre_of_mass(self.model, self._placed(q_rad))

    def centre_of_mass_jacobian(self, q_rad: Vector) -> Matrix:
        """Jacobian (3, n) of the centre of mass."""
        return geometry.centre_of_mass_jacobian(self.model, self._placed(q_rad))

    def frame_pose(self, name: str) -> tuple[Matrix, Vector]:
        """Rotation (3x3) and position (3, m) of a link or frame in the last estimate."""
        return geometry.frame_pose(self.model, self._last_poses(), name)

    def jacobian(self, name: str, point_m: Point = (0.0, 0.0, 0.0)) -> Matrix:
        """Jacobian (6, n) of a point of a frame in the last estimate: linear rows, then angular."""
        return geometry.jacobian(self.model, self._last_poses(), name, point_m)

    def _run(self, ready: Prepared, motion: tuple[Vector, Vector, Vector]) -> BodyEstimate:
        """Without sensors; nothing is remembered."""
        given = (*motion, self._unread)
        numbers: Vector = np.empty(ready.size)
        status = _run_copies(ready, given, numbers)
        if status != DONE:
            _refuse(self.model, status, given)
        return BodyEstimate(ready.plan, numbers)

    def _ready_for(self, assumption: Assumption, mask: bytes) -> Prepared:
        key = assumption, mask
        if key not in self._plans:
            valid = np.frombuffer(mask, dtype=np.bool_).tolist()
            plan = make_plan(self.model, assumption, valid)
            if len(self._plans) >= MOST_PLANS:
                self._plans.clear()
            self._plans[key] = self._path.prepare(plan)
        return self._plans[key]

    def _mask_of(self, valid: Mask) -> bytes:
        flags = np.asarray(valid, dtype=np.bool_)
        if flags.shape != (self.model.m,):
            raise ShapeError(f"valid has shape {flags.shape}, expected ({self.model.m},)")
        return flags.tobytes()

    def _last_poses(self) -> Matrix:
        return self._poses[: 12 * self.model.bodies].reshape(-1, 12)

    def _placed(self, q_rad: ArrayLike) -> Matrix:
        poses: Vector = np.empty(12 * self.model.bodies)
        self._path.place(finite_vector("joint angles", q_rad, self.model.n), poses)
        return poses.reshape(-1, 12)


def _path(model: TreeModel, compiled: bool) -> Path:
    """Numba is loaded by who uses it only."""
    if not compiled:
        from dforc.estimation.plain_path import PlainPath

        return PlainPath(model)
    if not HAS_COMPILER:
        raise DforcError("the compiled estimate needs numba, which is not installed")
    from dforc.estimation.compiled_path import CompiledPath

    return CompiledPath(model)


def _set_motion(ready: Prepared, imu: BaseMotion | None) -> None:
    if ready.plan.source_body < 0:
        raise AssumptionError("a motion was given, but the assumption names no kinematic source")
    if imu is None:
        raise AssumptionError(f"the motion of {ready.plan.assumption.source!r} is missing")
    ready.motion[:3] = imu.omega_rad_s
    ready.motion[3:6] = imu.domega_rad_s2
    ready.motion[6:] = imu.acceleration_m_s2


def _run_copies(ready: Prepared, given: Given, numbers: Vector) -> int:
    q, dq, ddq, wrenches = (np.array(part, dtype=np.float64, order="C") for part in given)
    if wrenches.ndim != 2 or not q.ndim == dq.ndim == ddq.ndim == 1:
        return WRONG_SHAPE
    return ready.run(q, dq, ddq, wrenches, numbers)


def _refuse(model: TreeModel, status: int, given: tuple[Vector, Vector, Vector, Matrix]) -> None:
    names = "angles", "velocities", "accelerations", "wrenches"
    if status == WRONG_SHAPE:
        shapes = [np.shape(part) for part in given]
        raise ShapeError(f"{names} are {shapes}, expected ({model.n},) each and ({model.m}, 6)")
    parts = zip(names, given, strict=True)
    bad = [name for name, part in parts if not np.isfinite(part).all()]
    raise NotFiniteError(f"not finite, or absurdly large: {bad or 'some input'}")
