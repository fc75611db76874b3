"""idyntree's estimator of torques and wrenches, behind arrays like ours."""

from collections.abc import Callable, Sequence

import idyntree.swig as idyn
import numpy as np

from benchmarks.newton_euler import Array
from dforc.estimation.assumption import BaseMotion, Contact, KnownWrench

KINDS = {
    "wrench": idyn.FULL_WRENCH,
    "force": idyn.PURE_FORCE,
    "direction": idyn.PURE_FORCE_WITH_KNOWN_DIRECTION,
}
FORCE_TORQUE = idyn.SIX_AXIS_FORCE_TORQUE


class Peer:
    """One model with all its sensors."""

    def __init__(self, urdf: str, joints: Sequence[str], sensors: Sequence[str]) -> None:
        self._estimator = idyn.ExtWrenchesAndJointTorquesEstimator()
        if not self._estimator.loadModelAndSensorsFromFile(urdf):
            raise ValueError(f"idyntree cannot load {urdf}")
        self.model = self._estimator.model()
        own = [self.model.getJointName(i) for i in range(self.model.getNrOfDOFs())]
        self._ours = np.array([joints.index(name) for name in own])
        self._theirs = np.argsort(self._ours)
        known = self._estimator.sensors()
        count = known.getNrOfSensors(FORCE_TORQUE)
        names = [known.getSensor(FORCE_TORQUE, i).getName() for i in range(count)]
        self.places = [_place_of(names, sensor) for sensor in sensors]
        self._readings = idyn.SensorsMeasurements(known)
        self._wrenches = [idyn.Wrench() for _ in sensors]
        self._unknown = idyn.LinkUnknownWrenchContacts(self.model)
        self._found = idyn.LinkContactWrenches(self.model)
        self._torques = idyn.JointDOFsDoubleArray(self.model)
        self._q = idyn.JointPosDoubleArray(self.model)
        self._dq = idyn.JointDOFsDoubleArray(self.model)
        self._ddq = idyn.JointDOFsDoubleArray(self.model)
        self._root = self.model.getFrameIndex("root_link")
        self._gravity = idyn.Vector3.FromPython([0.0, 0.0, -9.81])
        self._slots: list[tuple[int, int]] = []  # link and place in its list, of every wrench
        self._contacts = 0

    def assume(
        self,
        contacts: Sequence[Contact],
        known: Sequence[KnownWrench] = (),
        *,
        mainstay: bool = True,
    ) -> None:
        """State the contacts, and the wrench at the base where there is one."""
        self._unknown.clear()
        self._slots, self._contacts = [], len(contacts)
        count: dict[int, int] = {}
        for contact in contacts:
            unknown = idyn.UnknownWrenchContact()
            unknown.unknownType = KINDS[contact.kind]
            unknown.contactPoint = idyn.Position(*contact.point_m)
            if contact.direction is not None:
                unknown.forceDirection = idyn.Direction(*contact.direction)
            self._add(contact.frame, unknown, count)
        for given in known:
            unknown = idyn.UnknownWrenchContact()
            unknown.unknownType = idyn.NO_UNKNOWNS
            unknown.contactPoint = idyn.Position(*given.point_m)
            unknown.knownWrench = idyn.Wrench.FromPython(list(given.wrench))
            self._add(given.frame, unknown, count)
        if mainstay:
            unknown = idyn.UnknownWrenchContact()
            unknown.unknownType = idyn.FULL_WRENCH
            unknown.contactPoint = idyn.Position(0.0, 0.0, 0.0)
            self._add("root_link", unknown, count)

    def _add(self, frame: str, unknown: "idyn.UnknownWrenchContact", count: dict[int, int]) -> None:
        index = self.model.getFrameIndex(frame)
        link = self.model.getFrameLink(index)
        self._unknown.addNewContactInFrame(self.model, index, unknown)
        self._slots.append((link, count.get(link, 0)))
        count[link] = count.get(link, 0) + 1

    def load(self, q: Array, dq: Array, ddq: Array, wrenches: Array) -> None:
        """Hand over one tick, as whole vectors."""
        self._q = idyn.JointPosDoubleArray.FromPython(q[self._ours])
        self._dq = idyn.JointDOFsDoubleArray.FromPython(dq[self._ours])
        self._ddq = idyn.JointDOFsDoubleArray.FromPython(ddq[self._ours])
        for place, wrench in zip(self.places, wrenches, strict=True):
            self._readings.setMeasurement(FORCE_TORQUE, place, idyn.Wrench.FromPython(wrench))

    def load_one_by_one(self, q: Array, dq: Array, ddq: Array, wrenches: Array) -> None:
        """Hand over one tick, number by number."""
        for i, ours in enumerate(self._ours.tolist()):
            self._q.setVal(i, q[ours])
            self._dq.setVal(i, dq[ours])
            self._ddq.setVal(i, ddq[ours])
        for place, given, wrench in zip(self.places, self._wrenches, wrenches, strict=True):
            for k in range(6):
                given.setVal(k, wrench[k])
            self._readings.setMeasurement(FORCE_TORQUE, place, given)

    def estimate(self, imu: BaseMotion | None = None, frame: str = "") -> bool:
        """Both calls."""
        if imu is None:
            ok = self._estimator.updateKinematicsFromFixedBase(
                self._q, self._dq, self._ddq, self._root, self._gravity
            )
        else:
            ok = self._estimator.updateKinematicsFromFloatingBase(
                self._q,
                self._dq,
                self._ddq,
                self.model.getFrameIndex(frame),
                idyn.Vector3.FromPython(list(imu.acceleration_m_s2)),
                idyn.Vector3.FromPython(list(imu.omega_rad_s)),
                idyn.Vector3.FromPython(list(imu.domega_rad_s2)),
            )
        return bool(ok) and bool(
            self._estimator.estimateExtWrenchesAndJointTorques(
                self._unknown, self._readings, self._found, self._torques
            )
        )

    def torques(self) -> Array:
        """Of the last estimate, in our order."""
        found: Array = self._torques.toNumPy()[self._theirs]
        return found

    def wrenches(self) -> list[Array]:
        """Of the contacts in the order of `assume`: link axes, about the points."""
        return [
            self._found.contactWrench(link, slot).contactWrench.asVector().toNumPy()
            for link, slot in self._slots[: self._contacts]
        ]

    def wrenches_in_base(self, pose: Callable[[str], tuple[Array, Array]]) -> Array:
        """The same in base axes; `pose` gives a link's in the base."""
        found = []
        for wrench, (link, _) in zip(self.wrenches(), self._slots, strict=False):
            R, _ = pose(self.model.getLinkName(link))
            found.append(np.concatenate([R @ wrench[:3], R @ wrench[3:]]))
        return np.array(found)


def _place_of(names: Sequence[str], sensor: str) -> int:
    for name in (sensor, f"{sensor}_sensor"):
        if name in names:
            return list(names).index(name)
    raise ValueError(f"idyntree's model has no sensor {sensor}; it has {', '.join(names)}")
