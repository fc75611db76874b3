"""What moves the limb in use: a stream of points, a pose, a velocity, or nothing; one at a time.

A motion that is lost (a joint leaves position-direct mode, or is heard no more) ends at once with
the reason: the boards hold, or are off. Everything else ends with a plan that stands.
"""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from enum import StrEnum

import numpy as np

from dforc.cartesian.state import CartesianOutput
from dforc.cartesian.targets import ReachTarget, SpeedTarget, Target
from dforc.errors import DforcError
from services.core.clock import NS_PER_S
from services.reaching.limb_control import LimbControl
from services.reaching.limb_reading import Reading
from services.reaching.motions import Motions
from services.reaching.point_following import PointFollowing

FORGET_AFTER_NS = 500_000_000  # without joint states: the plan no longer fits the arm
STANDING_RAD_S = 0.001
LATE_S = 3.0  # behind the end of the trajectory, or it is missed
LATE_SHARE = 1.0  # and so much of the trajectory's time


class Mode(StrEnum):
    """Who commands the limb."""

    IDLE = "idle"
    FIELD = "field"
    POSE = "pose"
    TRACKING = "tracking"
    VELOCITY = "velocity"
    STOPPING = "stopping"


@dataclass(frozen=True, slots=True)
class Ending:
    """What a motion will have ended with once the plan stands."""

    outcome: str = "stopped"
    reason: str = ""


class LimbDriver:
    """The mode, and the limb that it is about."""

    def __init__(self, limbs: Mapping[str, LimbControl], limb: str) -> None:
        """`limb` is the one in use at first."""
        self.motions = Motions()
        self.points = PointFollowing()
        self.mode = Mode.IDLE
        self.limb = limb
        self.target: ReachTarget | None = None  # of the newest motion
        self.target_limb = ""
        self.refused = 0  # targets and readings that were none
        self.reason = ""  # why nothing is commanded that should be
        self.output: CartesianOutput | None = None  # of the newest period that commanded
        self._limbs = limbs
        self._speeds: SpeedTarget | None = None
        self._ending = Ending()
        self._begun_ns = 0
        self._until_ns = 0
        self._measured_ns = 0
        self._following_s = 0.0  # trajectory time that the stream asks for; 0 = the robot file's

    @property
    def control(self) -> LimbControl:
        """The limb in use."""
        return self._limbs[self.limb]

    @property
    def is_idle(self) -> bool:
        """Whether nothing is commanded."""
        return self.mode is Mode.IDLE

    def may_take(self, limb: str) -> bool:
        """Whether a limb can be moved now; another one that moves has to stop first."""
        return self.is_idle or limb == self.limb

    def go(
        self,
        now_ns: int,
        limb: str,
        target: ReachTarget,
        duration_s: float,
        out_of_reach: str = "",
    ) -> None:
        """A motion to a target, of a limb that may be taken; and what the target lacks."""
        self._take(now_ns, limb)
        self.control.pace(duration_s)
        self.control.begin()
        self.target, self.target_limb = target, limb
        self.motions.begin(now_ns, limb, out_of_reach)
        self.mode = Mode.POSE
        self._begun_ns = now_ns
        self._until_ns = now_ns + math.ceil(duration_s * NS_PER_S)

    def move(self, now_ns: int, limb: str, speeds: SpeedTarget, duration_s: float) -> None:
        """Velocities for a while, of a limb that may be taken."""
        if self.mode is not Mode.VELOCITY or limb != self.limb:
            self._take(now_ns, limb)
            self.motions.end(now_ns, "replaced", "the hand is moved by velocity")
            self.control.pace(self.control.settings.trajectory_time_s)
            self.mode = Mode.VELOCITY
        self._speeds = speeds
        self._until_ns = now_ns + round(duration_s * NS_PER_S)

    def follow(self, now_ns: int, limb: str, time_s: float = 0.0) -> None:
        """A stream of points commands from now on; another limb that moves stops first.

        `time_s` is the trajectory time of jumps of the stream; 0: the robot file's. It may change
        on the way, without a step in the speed.
        """
        if self.mode is Mode.FIELD and limb == self.limb:
            if time_s != self._following_s:
                self._pace(time_s)
            return
        if not self.may_take(limb):
            self._brake("taken over", f"a stream of points is to move {limb}")
            return
        self._end_stopping(now_ns)
        self.motions.end(now_ns, "taken over", "a stream of points commands")
        self._use(now_ns, limb)
        self._pace(time_s)
        self.mode = Mode.FIELD

    def stop(self, now_ns: int, outcome: str = "stopped", reason: str = "") -> None:
        """Come to rest; the motion ends when the plan stands."""
        self.points.bar(now_ns)
        if not self.is_idle:
            self._brake(outcome, reason)

    def retarget(self, target: ReachTarget) -> None:
        """Tracking: another posture for the same poses."""
        self.target = target

    def step(self, now_ns: int, reading: Reading, force_n: float) -> CartesianOutput | None:
        """One period of the limb in use."""
        self.output = None
        if self.is_idle or not self._is_movable(now_ns, reading):
            return None
        try:
            self.output = self.control.step(reading, force_n, self._target(now_ns))
        except DforcError:
            self.refused += 1
            return None
        self._look(now_ns, self.output)
        return self.output

    def close(self, now_ns: int) -> None:
        """The process ends."""
        self.mode = Mode.IDLE
        self.motions.close(now_ns)

    def _pace(self, time_s: float) -> None:
        self._following_s = time_s
        self.control.pace(time_s or self.control.shape.following_s, following=True)

    def _brake(self, outcome: str, reason: str) -> None:
        if self.mode is not Mode.STOPPING:
            self._ending = Ending(outcome, reason)
        self.mode = Mode.STOPPING

    def _take(self, now_ns: int, limb: str) -> None:
        self.points.bar(now_ns)
        self._end_stopping(now_ns)
        self._use(now_ns, limb)

    def _end_stopping(self, now_ns: int) -> None:
        """What was coming to rest goes on as something else."""
        if self.mode is Mode.STOPPING:
            self.motions.end(now_ns, self._ending.outcome, self._ending.reason)

    def _use(self, now_ns: int, limb: str) -> None:
        self.reason = ""
        self._measured_ns = now_ns
        if limb != self.limb:
            self.control.state = None
            self.limb = limb

    def _is_movable(self, now_ns: int, reading: Reading) -> bool:
        """Whether the joints take set-points; when not for long, the plan is dropped."""
        if reading.malformed:
            self.refused += 1
        if reading.missing:
            if now_ns - self._measured_ns > FORGET_AFTER_NS:
                self._lose(now_ns, reading.missing)
            return False
        self._measured_ns = now_ns
        control = self.control
        other = reading.not_direct(control.shape.joints, control.free)
        if other:
            self._lose(now_ns, other)
            return False
        if self.mode is Mode.FIELD:
            self.reason = ""
            return control.state is not None or self.points.target is not None
        return True

    def _lose(self, now_ns: int, reason: str) -> None:
        """A stream waits for the joints to come back; everything else is over."""
        self.control.state = None
        self.reason = reason
        self.motions.end(now_ns, "lost", reason)
        if self.mode is not Mode.FIELD:
            self.mode = Mode.IDLE

    def _target(self, now_ns: int) -> Target | None:
        if self.mode is Mode.FIELD:
            return None if self.points.is_silent(now_ns) else self.points.target
        if self.mode is Mode.VELOCITY and now_ns < self._until_ns:
            return self._speeds
        if self.mode in (Mode.POSE, Mode.TRACKING):
            return self.target
        return None

    def _look(self, now_ns: int, output: CartesianOutput) -> None:
        """What this period has brought."""
        errors = output.position_error_m, output.orientation_error_rad
        if self.mode is Mode.POSE:
            self.motions.advance(now_ns, output.progress, errors)
            self._look_for_the_end(now_ns, output)
        elif self.mode is Mode.VELOCITY and now_ns >= self._until_ns:
            self._ending = Ending()
            self.mode = Mode.STOPPING
        elif self.mode is Mode.STOPPING and output.held and stands(output):
            self.motions.end(now_ns, self._ending.outcome, self._ending.reason)
            self._rest()

    def _look_for_the_end(self, now_ns: int, output: CartesianOutput) -> None:
        end_ns = self._begun_ns + round(output.duration_s * NS_PER_S)
        if now_ns >= end_ns and output.at_rest and output.in_target:
            self.motions.end(now_ns, "reached")
            if self.control.settings.tracking:
                self.mode = Mode.TRACKING
            else:
                self._rest()
            return
        late_s = LATE_S + LATE_SHARE * output.duration_s
        if now_ns >= end_ns + round(late_s * NS_PER_S):
            away = f"{output.position_error_m * 1e3:.1f} mm"
            away += f" and {math.degrees(output.orientation_error_rad):.1f} deg"
            reason = f"the hand is still {away} from where the motion leads"
            if output.gated:
                reason += "; something pushes the arm"
            self.motions.end(now_ns, "missed", reason)
            self._rest()

    def _rest(self) -> None:
        self.mode = Mode.IDLE
        self.control.state = None


def stands(output: CartesianOutput) -> bool:
    """Whether the plan may be left as it is: nothing jumps to rest."""
    return float(np.abs(output.dq_rad_s).max()) < STANDING_RAD_S
