"""Learns what the rigid-body model leaves over of one FT sensor's reading.

The kernel is that of the recorded arm of figure 7, rounded: its length scales are lengths of motion
over which a limb's weight and inertia, wrongly known, change by their own size.
"""

import numpy as np

from dforc.arrays import Vector
from dforc.errors import DforcError
from dforc.learning.feature_ridge import FeatureRidge, Kernel, LearnerState
from dforc.learning.gate import ContactSafe, GateLimits, UpdateGate
from dforc.learning.recursive_ridge import NotDefiniteError
from services.wholebody.body import Body, BodySensor
from services.wholebody.dynamics_messages import LearnedWrench, SensorLearning, SensorSample

FEATURES = 200
LENGTHS = (1.5, 40.0, 100.0)  # rad, rad/s, rad/s2
REGULARISATION = 0.01  # of the rest: its noise variance over its own
EVERY = 4  # samples of 100 Hz: more of the same teaches nothing, and takes time
MEMORY = 75  # learned samples, 3 s: a push that has grown for as long is taken back whole
QUIET = 10  # learned samples
CLOSE_N, OPEN_N = 2.0, 1.5
ENOUGH = 50  # learned samples before the first word
SHARE = 0.02  # of the newest sample in the running errors: two seconds
SEED = 1


class LimbLearner:
    """One sensor's learner, with its gate and the errors with and without it."""

    def __init__(self, body: Body, sensor: BodySensor) -> None:
        """Inputs are the joints between base and sensor, and those beyond it."""
        tree = body.tree
        above = set(tree.joints_above(sensor.frame))
        self.name = sensor.name
        self.joints = tuple(
            joint
            for joint in body.joints
            if joint in above or sensor.frame in tree.joints_above(joint)
        )
        lengths = np.repeat(LENGTHS, len(self.joints))
        kernel = Kernel(tuple(range(6)), lengths, REGULARISATION)
        self.learner = FeatureRidge((kernel,), FEATURES, SEED)
        limits = GateLimits(
            close_n=CLOSE_N, open_n=OPEN_N, quiet=QUIET, model_n=2.0 * sensor.contact_on_n
        )
        # Where nothing is known yet, the contact detection alone says what touches.
        unknown_n = max(sensor.contact_on_n - CLOSE_N, 0.0)
        self._safe = ContactSafe(self.learner, UpdateGate(limits), MEMORY, unknown_n)
        self._square: Vector = np.zeros(6)  # running mean of what is left, squared
        self._model_square = 0.0
        self._counted = 0
        self._reason = "no sample yet"

    def take(self, x: Vector, sample: SensorSample, *, learns: bool) -> LearnedWrench | None:
        """The correction for one sample, which is learned afterwards where `learns` and it may be.

        None while there is nothing to say; a sample that is not finite changes nothing.
        """
        if not sample.valid:
            self._reason = "the sensor cannot be used"
            return None
        rest = np.array(sample.measured) - np.array(sample.predicted)
        try:
            correction = self.learner.predict(x)
            if learns:
                self._learn(x, rest, rest - correction, touching=sample.touching)
        except NotDefiniteError as error:  # after years of samples, or of a spoilt memory
            self.reset()
            self._reason = f"begun anew: {error}"
            return None
        except DforcError as error:
            self._reason = str(error)
            return None
        if self.learner.samples < ENOUGH:
            return None
        return LearnedWrench(
            name=self.name,
            wrench=tuple(correction.tolist()),
            std=tuple(np.sqrt(self._square).tolist()),
        )

    def release(self) -> None:
        """Somebody knows that nothing touches the limb."""
        self._safe.gate.release()

    def reset(self) -> None:
        """Forget everything."""
        self.learner.reset()
        self._begin("forgotten")

    def state(self) -> LearnerState:
        """A copy of what was learned."""
        return self.learner.state()

    def restore(self, state: LearnerState) -> None:
        """Continue from it.

        Raises:
            DforcError: it is of another learner, or not finite; nothing was changed.
        """
        before = self.learner.state()
        self.learner.restore(state)
        if not self.learner.definite():
            self.learner.restore(before)
            raise NotDefiniteError(f"the state of {self.name} is not positive definite")
        self._begin("restored")

    def message(self) -> SensorLearning:
        """How it goes."""
        return SensorLearning(
            name=self.name,
            updates=self.learner.samples,
            gated=not self._safe.gate.open,
            error_n=float(np.sqrt(self._square[:3].sum())),
            model_error_n=float(np.sqrt(self._model_square)),
            reason=self._reason,
        )

    def _learn(self, x: Vector, rest: Vector, left: Vector, *, touching: bool) -> None:
        learned = self._safe.update(x, rest, touched=touching)
        if learned:
            self._reason = ""
            self._count(rest, left)
        else:
            self._reason = "something touches it" if touching else "unexplained force"

    def _count(self, rest: Vector, left: Vector) -> None:
        """Running errors, of free motion only."""
        self._counted += 1
        share = max(SHARE, 1.0 / self._counted)
        self._square += share * (left * left - self._square)
        self._model_square += share * (float(rest[:3] @ rest[:3]) - self._model_square)

    def _begin(self, reason: str) -> None:
        self._safe.forget()
        self._counted = 0
        self._square = np.zeros(6)
        self._model_square = 0.0
        self._reason = reason
