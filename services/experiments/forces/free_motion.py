"""Every limb of the emulated robot swings without touching anything, and is recorded.

A guest of services.emulated.simulation: it asks the HAL to calibrate, moves to the middle of the
swings, has the dynamics service find the offsets of the force/torque sensors there, and then
commands every joint of the body along a sine of its own, in position-direct mode. All of it goes
over the boards' CAN frames. What is kept is what the dynamics service publishes: readings and
predictions of one instant, both through one filter.
"""

import math
from dataclasses import dataclass

from dforc.signals.delay_match import DELAY_S
from services.core.errors import ServiceError
from services.core.service import Period
from services.messages import FtRequest, JointCommand
from services.robotfile.robot_tables import RobotFile
from services.robotfile.wiring import joint_limits_deg
from services.script import TASK_TIMEOUT_S, AbandonedError, Script, ScriptedService
from services.streams import (
    DYNAMICS_SAMPLES,
    DYNAMICS_STATUS,
    FT_CALL,
    JOINT_COMMAND,
    ROBOT_CALL,
    ROBOT_STATUS,
)
from services.wholebody.dynamics_messages import DynamicsSamples

PERIOD_S = 0.01
S_PER_NS = 1e-9
SETTLE_S = 1.5
MOVE_S = 4.0
EASE_S = 2.0  # in which the swing grows to its full amplitude
SPEED_SHARE = 0.75  # of the joint's maximal speed
LIMIT_ROOM_DEG = 2.0
GOLDEN_ANGLE_RAD = 2.4  # between the phases of one joint and the next: none in step

# Middle and amplitude in degrees, and period in seconds, of each joint. Periods of the joints of a
# limb are not multiples of each other, so that the limb goes through ever new postures.
ARM = {
    "shoulder_pitch": (-45.0, 28.0, 3.7),
    "shoulder_roll": (50.0, 20.0, 2.9),
    "shoulder_yaw": (20.0, 28.0, 4.3),
    "elbow": (60.0, 30.0, 3.1),
    "wrist_prosup": (5.0, 35.0, 2.3),
    "wrist_pitch": (-20.0, 20.0, 2.7),
    "wrist_yaw": (0.0, 12.0, 1.9),
}
LEG = {
    "hip_pitch": (25.0, 20.0, 3.9),
    "hip_roll": (-20.0, 10.0, 3.3),
    "hip_yaw": (5.0, 18.0, 2.7),
    "knee": (-45.0, 25.0, 3.1),
    "ankle_pitch": (3.0, 14.0, 2.3),
    "ankle_roll": (1.0, 6.0, 1.9),
}
TORSO = {
    "torso_yaw": (0.0, 12.0, 7.3),
    "torso_roll": (0.0, 7.0, 8.9),
    "torso_pitch": (8.0, 8.0, 6.1),
}
HEAD = {
    "neck_pitch": (-5.0, 12.0, 3.3),
    "neck_roll": (0.0, 10.0, 4.1),
    "neck_yaw": (0.0, 20.0, 5.3),
}
SWINGS = {
    **TORSO,
    **HEAD,
    **{f"{side}_{name}": swing for side in "lr" for name, swing in (ARM | LEG).items()},
}


@dataclass(frozen=True, slots=True, kw_only=True)
class Swing:
    """One joint's sine."""

    middle_rad: float
    amplitude_rad: float
    turn_rad_s: float
    phase_rad: float

    def at(self, at_s: float) -> float:
        """Angle, `at_s` after the swing began."""
        wave = math.sin(self.turn_rad_s * at_s + self.phase_rad)
        return self.middle_rad + self.amplitude_rad * eased(at_s) * wave


class FreeMotion(ScriptedService):
    """Runs the motion once; `samples` is what was heard in full swing, 100 a second."""

    trigger = Period(PERIOD_S)
    reads = (ROBOT_STATUS, DYNAMICS_STATUS, DYNAMICS_SAMPLES)
    calls = (ROBOT_CALL, FT_CALL)

    def __init__(self, robot: RobotFile, seconds: float) -> None:
        """`seconds` of full swing, after the easing in."""
        self._robot = robot
        self._seconds = seconds
        self._parts = {
            part: joints
            for part, joints in robot.parts.items()
            if all(joint in SWINGS for joint in joints)
        }
        self._swings = {
            part: [swing_of(robot, joint) for joint in joints]
            for part, joints in self._parts.items()
        }
        self.writes = tuple(JOINT_COMMAND[part] for part in self._parts)
        self.samples: list[DynamicsSamples] = []
        self.failure = ""
        self._in_full_swing = False
        super().__init__(tuple(joint for joints in self._parts.values() for joint in joints))

    def observe(self) -> None:
        """Keep what has arrived."""
        if self._in_full_swing:
            self.samples += self.inputs.all_new(DYNAMICS_SAMPLES)

    def script(self) -> Script:
        """The whole experiment."""
        try:
            yield from self._run()
        except AbandonedError as error:
            self.failure = str(error)

    def _run(self) -> Script:
        yield from self.calibrate()
        middle = tuple(one.middle_rad for swings in self._swings.values() for one in swings)
        yield from self.ask("moving to the middle", "move", q_rad=middle, duration_s=MOVE_S)
        yield from self._wait("settling", SETTLE_S)
        self.say("removing the offsets of the force/torque sensors")
        yield from self.answered(self.outputs.call(FT_CALL, FtRequest()), "zero_ft")
        yield from self.until(self._knows_offsets, TASK_TIMEOUT_S, "FT offsets known")
        yield from self.ask("position-direct mode", "mode", value="direct")
        yield from self._swing()

    def _knows_offsets(self) -> bool:
        status = self.inputs.latest(DYNAMICS_STATUS)
        return status is not None and status.state == "running"

    def _swing(self) -> Script:
        self.say("swinging")
        start_ns = self.now_ns
        while (at_s := (self.now_ns - start_ns) * S_PER_NS) < EASE_S + self._seconds:
            self._in_full_swing = at_s >= EASE_S + DELAY_S
            for part, swings in self._swings.items():
                q_rad = tuple(swing.at(at_s) for swing in swings)
                command = JointCommand(stamp_ns=self.now_ns, mode="direct", q_rad=q_rad)
                self.outputs.put(JOINT_COMMAND[part], command)
            yield

    def _wait(self, what: str, seconds: float) -> Script:
        self.say(what)
        end_ns = self.now_ns + round(seconds * 1e9)
        while self.now_ns < end_ns:
            yield


def swing_of(robot: RobotFile, joint: str) -> Swing:
    """How a joint moves: at most as far and as fast as the robot file lets it, with room."""
    middle, amplitude, period_s = SWINGS[joint]
    low, high = joint_limits_deg(robot, joint)
    room = robot.joints[joint].limit_margin_deg + LIMIT_ROOM_DEG
    fastest = SPEED_SHARE * robot.joints[joint].max_velocity_deg_s * period_s / math.tau
    inside = min(middle - low, high - middle) - room
    if inside <= 0.0:
        raise ServiceError(f"{joint} cannot swing about {middle} degrees within its limits")
    return Swing(
        middle_rad=math.radians(middle),
        amplitude_rad=math.radians(min(amplitude, inside, fastest)),
        turn_rad_s=math.tau / period_s,
        phase_rad=GOLDEN_ANGLE_RAD * list(SWINGS).index(joint),
    )


def eased(at_s: float) -> float:
    """Share of the amplitude: from 0 to 1 in EASE_S, with minimum jerk."""
    s = min(at_s / EASE_S, 1.0)
    return s * s * s * (10.0 + s * (-15.0 + 6.0 * s))
