"""Learns, while the robot moves, what the rigid-body model does not know of it.

Reads   dynamics/samples (trigger): joints, FT readings and the model's prediction of one instant
Writes  learner/prediction: what to add to the model's prediction, per sensor; learner/status
Serves  learner/request: save, restore, reset, freeze, resume
Learns only what no contact explains: the contact detection of the samples and a gate of its own
keep pushes out. Each sensor learns at every fourth sample, in turns. Predictions never stop for a
save; where this process is not there, dynamics goes on with the model alone.
A live learner writes its state every half minute and at its end, and begins with it.
"""

import logging
from contextlib import suppress
from pathlib import Path

import numpy as np

from dforc.errors import DforcError
from services.config import load_robot
from services.core.live import Context, run_process
from services.core.rundir import run_directory
from services.core.service import Inputs, Outputs, Service
from services.learning.learner_state import (
    VERSION,
    SavedLearner,
    SavedLimb,
    StateFileError,
    learner_state,
    read,
    saved_ridges,
    write,
)
from services.learning.limb_learner import EVERY, FEATURES, LENGTHS, SEED, LimbLearner
from services.messages import Reply
from services.robotfile.robot_tables import RobotFile
from services.streams import DYNAMICS_SAMPLES, LEARNED, LEARNER_CALL, LEARNER_STATUS
from services.wholebody.body import Body
from services.wholebody.dynamics_messages import (
    DynamicsSamples,
    LearnedWrench,
    LearnedWrenches,
    LearnerRequest,
    LearnerStatus,
)

STATUS_PERIOD_NS = 100_000_000
SAVE_PERIOD_NS = 30_000_000_000

logger = logging.getLogger(__name__)


class Learner(Service):
    """One learner per FT sensor."""

    trigger = DYNAMICS_SAMPLES
    reads = (DYNAMICS_SAMPLES,)
    writes = (LEARNED, LEARNER_STATUS)
    serves = (LEARNER_CALL,)

    def __init__(self, robot: RobotFile, state_file: Path | None = None) -> None:
        """`state_file` is read now, and written from time to time; None = on request only."""
        body = Body(robot)
        self._robot = robot.robot.name
        self.limbs = {sensor.name: LimbLearner(body, sensor) for sensor in body.sensors}
        self._state_file = state_file
        self._columns: dict[str, np.ndarray[tuple[int], np.dtype[np.intp]]] = {}
        self._joints: tuple[str, ...] = ()
        self._frozen = False
        # Of files: sensors that are not in use, or learned over other joints. They are kept.
        self._others: dict[tuple[str, tuple[str, ...]], SavedLimb] = {}
        self._snapshot = ""
        self._reason = ""
        self._count = 0
        self._next_status_ns = 0
        self._next_save_ns: int | None = None
        if state_file is not None and state_file.exists():
            self._begin_with(state_file)

    def step(self, now_ns: int, inputs: Inputs, outputs: Outputs) -> None:
        """Answer the newest samples, then learn from them."""
        for token, request in inputs.requests(LEARNER_CALL):
            reason = self._do(request)
            outputs.reply(LEARNER_CALL, token, Reply(ok=not reason, reason=reason))
        samples = inputs.new(DYNAMICS_SAMPLES)
        if samples is not None:
            corrections = self._corrections(samples)
            outputs.put(
                LEARNED,
                LearnedWrenches(
                    stamp_ns=now_ns,
                    samples_stamp_ns=samples.stamp_ns,
                    corrections=corrections,
                ),
            )
            self._save_now_and_then(now_ns)
        if now_ns >= self._next_status_ns:
            self._next_status_ns = now_ns + STATUS_PERIOD_NS
            outputs.put(LEARNER_STATUS, self._status(now_ns))

    def close(self, now_ns: int, outputs: Outputs) -> None:  # noqa: ARG002
        """Keep what was learned for the next one."""
        if self._state_file is not None:
            self._save(self._state_file)

    def _corrections(self, samples: DynamicsSamples) -> tuple[LearnedWrench, ...]:
        if samples.joints != self._joints:
            self._find_joints(samples.joints)
        self._count += 1
        state = np.array((samples.q_rad, samples.dq_rad_s, samples.ddq_rad_s2))
        said = []
        for place, sample in enumerate(samples.sensors):
            limb = self.limbs.get(sample.name)
            if limb is None or limb.name not in self._columns:
                continue
            learns = not self._frozen and (self._count + place) % EVERY == 0
            x = state[:, self._columns[limb.name]].ravel()
            correction = limb.take(x, sample, learns=learns)
            if correction is not None:
                said.append(correction)
        return tuple(said)

    def _find_joints(self, joints: tuple[str, ...]) -> None:
        """Where each limb's joints stand in the samples; a limb that lacks one stays silent."""
        self._joints = joints
        self._columns = {
            limb.name: np.array([joints.index(joint) for joint in limb.joints], dtype=np.intp)
            for limb in self.limbs.values()
            if set(limb.joints) <= set(joints)
        }

    def _do(self, request: LearnerRequest) -> str:
        """Carry a request out; the reason where it cannot be done."""
        unknown = [name for name in request.sensors if name not in self.limbs]
        if unknown:
            return f"no sensor {unknown[0]!r} here; there are {', '.join(self.limbs)}"
        named = [self.limbs[name] for name in request.sensors or self.limbs]
        if request.action in ("save", "restore"):
            path = Path(request.value) if request.value else self._state_file
            if path is None:
                return "no file was named"
            return self._save(path) if request.action == "save" else self._restore(path)
        if request.action == "reset":
            for limb in named:
                limb.reset()
        elif request.action == "freeze":
            self._frozen = True
        elif request.action == "resume":
            self._frozen = False
            for limb in named:
                limb.release()
        else:
            return f"no action {request.action!r}; save, restore, reset, freeze or resume"
        return ""

    def _save(self, path: Path) -> str:
        limbs = []
        for limb in self.limbs.values():
            state = limb.state()
            limbs.append(
                SavedLimb(
                    name=limb.name,
                    joints=limb.joints,
                    lengths=LENGTHS,
                    seed=SEED,
                    mean=tuple(state.mean.tolist()),
                    ridges=saved_ridges(state),
                )
            )
        ours = {(limb.name, limb.joints) for limb in limbs}
        limbs += [limb for key, limb in self._others.items() if key not in ours]
        try:
            write(path, SavedLearner(version=VERSION, robot=self._robot, limbs=tuple(limbs)))
        except StateFileError as error:
            self._reason = str(error)
            return self._reason
        self._snapshot, self._reason = str(path), ""
        return ""

    def _begin_with(self, path: Path) -> None:
        """Go on from the file that this learner will write; what it cannot use stays in there."""
        self._restore(path)
        with suppress(StateFileError):  # told already
            self._keep_others(read(path))

    def _restore(self, path: Path) -> str:
        """Every sensor that the file and this robot share; the reason where nothing was taken."""
        try:
            saved = read(path)
            if saved.robot != self._robot:
                raise StateFileError(f"{path} is of the robot {saved.robot}, not {self._robot}")
            known = self._shared(path, saved)
            states = [(limb.name, learner_state(limb)) for limb in known]
            before = [(name, self.limbs[name].state()) for name, _ in states]
            try:
                for name, state in states:
                    self.limbs[name].restore(state)
            except DforcError:
                for name, state in before:
                    self.limbs[name].restore(state)
                raise
        except (StateFileError, DforcError) as error:
            logger.warning("nothing restored: %s", error)
            self._reason = str(error)
            return self._reason
        self._keep_others(saved)
        self._snapshot, self._reason = str(path), ""
        return ""

    def _shared(self, path: Path, saved: SavedLearner) -> list[SavedLimb]:
        """Limbs of the file that are this robot's: the same sensor over the same joints.

        Raises:
            StateFileError: there is none, or one was learned with other features.
        """
        shared = [limb for limb in saved.limbs if self._is_ours(limb)]
        if not shared:
            for limb in saved.limbs:
                if limb.name in self.limbs:
                    joints = ", ".join(limb.joints)
                    raise StateFileError(f"{limb.name} was learned over other joints: {joints}")
            held = ", ".join(limb.name for limb in saved.limbs)
            raise StateFileError(f"{path} has none of {', '.join(self.limbs)}; it has {held}")
        for limb in shared:
            if limb.lengths != LENGTHS or limb.seed != SEED:
                raise StateFileError(f"{limb.name} was learned with other features")
        return shared

    def _is_ours(self, limb: SavedLimb) -> bool:
        ours = self.limbs.get(limb.name)
        return ours is not None and limb.joints == ours.joints

    def _keep_others(self, saved: SavedLearner) -> None:
        if saved.robot == self._robot:
            others = [limb for limb in saved.limbs if not self._is_ours(limb)]
            self._others |= {(limb.name, limb.joints): limb for limb in others}

    def _save_now_and_then(self, now_ns: int) -> None:
        if self._state_file is None:
            return
        if self._next_save_ns is None or now_ns >= self._next_save_ns:
            if self._next_save_ns is not None:
                self._save(self._state_file)
            self._next_save_ns = now_ns + SAVE_PERIOD_NS

    def _status(self, now_ns: int) -> LearnerStatus:
        if not any(name in self._columns for name in self.limbs):
            state = "waiting"
        else:
            state = "frozen" if self._frozen else "learning"
        return LearnerStatus(
            stamp_ns=now_ns,
            state=state,
            features=FEATURES,
            sensors=tuple(limb.message() for limb in self.limbs.values()),
            snapshot=self._snapshot,
            reason=self._reason,
        )


def state_path(robot: RobotFile, seed: int) -> Path:
    """Where a live learner keeps its state; every seed is an emulated robot of its own.

    What an emulated robot has taught must not correct a real one's sensors.
    """
    emulated = all(robot.is_simulated(sensor.board) for sensor in robot.sensors.values())
    which = str(seed) if emulated else "real"
    return run_directory() / f"learner-{robot.robot.name}-{which}.state"


def build(context: Context) -> Learner:
    """Continue from what an earlier one has learned."""
    robot = load_robot(context.robot)
    return Learner(robot, state_path(robot, context.seed))


if __name__ == "__main__":
    raise SystemExit(run_process("learner", build))
