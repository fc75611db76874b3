"""The slower look at the whole robot: contacts, health, centre of mass, what a learner learns from.

All signals pass one filter and so bear one delay; accelerations are known here. The learner's
correction is taken off the readings: a contact is what neither model nor learner explains.
"""

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from dforc.arrays import Matrix, Vector
from dforc.contacts.detection import ContactDetector
from dforc.contacts.shapes import LinkShapes
from dforc.estimation.assumption import Assumption
from dforc.estimation.estimate import BodyEstimate
from dforc.estimation.estimator import WholeBodyEstimator
from dforc.estimation.tree_model import TreeModel
from dforc.signals.delay_match import DELAY_S, MatchedMotion
from services.messages import Floats
from services.wholebody.body import Body
from services.wholebody.contact_watch import ContactWatch, Evidence
from services.wholebody.dynamics_messages import Contacts, DynamicsSamples, SensorSample
from services.wholebody.kinematic_source import KinematicSource
from services.wholebody.known_loads import KnownLoads
from services.wholebody.learned_correction import Correction
from services.wholebody.sensor_bank import SensorBank
from services.wholebody.sensor_health import HealthFigures
from services.wholebody.sensor_tasks import SensorTasks
from services.wholebody.skin_watch import SkinWatch

NS_TO_S = 1e-9


class Look(NamedTuple):
    """What one look found."""

    contacts: Contacts
    samples: DynamicsSamples
    estimate: BodyEstimate


class FilteredBody:
    """Filters, estimator, contacts and health figures of one robot."""

    def __init__(
        self,
        body: Body,
        model: TreeModel,
        assumption: Assumption,
        bank: SensorBank,
        shapes: LinkShapes,
        skin: SkinWatch,
        loads: KnownLoads,
    ) -> None:
        self.contacts = ContactWatch(body, shapes, skin)
        self.health = HealthFigures(body.sensors)
        self.estimator = WholeBodyEstimator(model, assumption)
        self._body = body
        self._bank = bank
        self._loads = loads
        self._motion = MatchedMotion(model.n)
        self._pressed = tuple(
            ContactDetector(sensor.contact_on_n, sensor.contact_off_n) for sensor in body.sensors
        )
        self._joints = model.joints
        self.contacts.assume(assumption)

    def forget_motion(self) -> None:
        """Joints are not where the filter has them; no look until it is full again."""
        self._motion.reset()

    def add_joints(self, q_rad: Vector, now_ns: int) -> None:
        """A step's new joint states."""
        self._motion.push(q_rad, now_ns * NS_TO_S)

    def is_pressed(self, sensor: int) -> bool:
        """Whether a sensor shows more than weight, motion and known loads, or skin or contact do.

        Whatever the assumption says of where the robot can be touched.
        """
        return self._pressed[sensor].touching or self.contacts.is_touched(sensor)

    def look(
        self,
        now_ns: int,
        heard: tuple[bool, ...],
        source: KinematicSource,
        correction: Correction,
        tasks: SensorTasks,
    ) -> Look | None:
        """One look, or None while the filters fill.

        `heard` says of which sensors the joints around them are known.
        """
        self._bank.filter_readings()
        base = source.filtered(now_ns)
        if not self._motion.settled or (source.frame and base is None):
            return None
        q, dq, ddq = self._motion.motion(now_ns * NS_TO_S)
        measured, ready = self._bank.filtered(now_ns)
        usable = tuple([r and h for r, h in zip(ready, heard, strict=True)])
        corrected = measured - correction.wrenches
        mask = np.array(usable)
        uncorrected = None
        if correction.wrenches.any():
            uncorrected = self.estimator.estimate(q, dq, ddq, measured, mask, base)
        estimate = self.estimator.estimate(q, dq, ddq, corrected, mask, base)
        predicted = self._loads.added_to(estimate.internal, self.estimator)
        excess = measured - predicted
        for i, detector in enumerate(self._pressed):
            if usable[i]:
                detector.update(math.hypot(*excess[i, :3].tolist()))
            else:
                detector.reset()
        if tasks.is_sweeping:
            fastest = float(np.abs(dq).max())
            tasks.add_pose(predicted, now_ns * NS_TO_S, heard, fastest, self.is_pressed)
        evidence = Evidence(
            estimate,
            uncorrected or estimate,
            usable,
            correction.spread_n,
            self.health.noise,
            self.health.model_noise,
        )
        contacts = self.contacts.look(now_ns, evidence, self.estimator)
        touched = [self.contacts.is_touched_beyond(i) for i in range(len(usable))]
        self.health.add(excess, corrected - predicted, usable, touched)
        return Look(
            Contacts(stamp_ns=now_ns, contacts=contacts),
            DynamicsSamples(
                stamp_ns=now_ns,
                joints=self._joints,
                q_rad=_floats(q),
                dq_rad_s=_floats(dq),
                ddq_rad_s2=_floats(ddq),
                delay_s=DELAY_S,
                sensors=self._samples(measured, predicted, usable, touched),
            ),
            estimate,
        )

    def _samples(
        self,
        measured: Matrix,
        predicted: Matrix,
        usable: Sequence[bool],
        touched: Sequence[bool],
    ) -> tuple[SensorSample, ...]:
        return tuple(
            SensorSample(
                name=sensor.name,
                measured=_floats(measured[i]),
                predicted=_floats(predicted[i]),
                valid=usable[i],
                touching=touched[i],
            )
            for i, sensor in enumerate(self._body.sensors)
        )


def _floats(values: "np.ndarray[tuple[int], np.dtype[np.float64]]") -> Floats:
    return tuple(values.tolist())
