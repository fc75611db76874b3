"""Cartesian controller: moves hands along straight minimum-jerk paths, by stream or by request.

Reads   field/virtual_point with ik/ik_solution, joint_state of the limbs' parts, dynamics/status
        and dynamics/contacts (what pushes the arm)
Writes  joint_command of the limb in use, cartesian/status, cartesian/events, cartesian/setup
Serves  cartesian/request     Calls  ik/request
One limb moves at a time, by one commander: a stream of virtual points, a pose, or a velocity. The
newest one wins; a request takes over from a stream, whose points are ignored until they pause. It
commands only while every free joint of the limb is valid and in position-direct mode. Without new
solutions the plan stops smoothly and holds. What is not finite or out of order is refused and
counted, and the last target holds.
"""

import math

import msgspec
import numpy as np

from dforc import rotation
from dforc.cartesian.params import CartesianParams
from dforc.cartesian.state import CartesianOutput
from dforc.errors import DforcError
from services.config import load_robot
from services.core.errors import ServiceError
from services.core.live import Context, run_process
from services.core.service import Inputs, Outputs, Period, Service
from services.messages import NAN3, CartesianStatus, DynamicsStatus
from services.reaching.cartesian_answers import MOVES, PERIOD_S, CartesianAnswers
from services.reaching.cartesian_messages import CartesianReply
from services.reaching.cartesian_orders import CartesianOrders
from services.reaching.held_references import HeldReferences
from services.reaching.limb import find_limb
from services.reaching.limb_control import LimbControl
from services.reaching.limb_driver import LimbDriver, Mode
from services.reaching.limb_names import LimbNames
from services.reaching.limb_reading import DIRECT
from services.reaching.limb_readings import LimbReadings
from services.reaching.limb_shape import limb_shape
from services.reaching.messages import SetupInUse
from services.reaching.tip_poses import vector3
from services.robotfile.robot_tables import RobotFile
from services.streams import (
    CARTESIAN_CALL,
    CARTESIAN_EVENTS,
    CARTESIAN_SETUP,
    CARTESIAN_STATUS,
    DYNAMICS_STATUS,
    EXTERNAL,
    IK_CALL,
    IK_SOLUTION,
    JOINT_COMMAND,
    JOINT_STATE,
    VIRTUAL_POINT,
)

FORCE_AGE_S = 0.05
SHORTEST_S, LONGEST_S = 0.1, 60.0  # trajectory times that a stream of points may ask for
STATUS_EVERY_STEPS = 2


class Cartesian(Service):
    """One controller for all limbs."""

    trigger = Period(PERIOD_S)
    serves = (CARTESIAN_CALL,)
    calls = (IK_CALL,)

    def __init__(self, robot: RobotFile, params: CartesianParams | None = None) -> None:
        """`params` is the tuning that no setting touches."""
        self._main = find_limb(robot).name
        shapes = {name: limb_shape(robot, name) for name in robot.limbs}
        self._references = HeldReferences()
        self._limbs = {
            name: LimbControl(shape, self._references, params) for name, shape in shapes.items()
        }
        self._limbs[self._main].warm()
        arms = [name for name, shape in shapes.items() if len(shape.tips) == 1]
        names = LimbNames(tuple(shapes), arms, self._main)
        self._driver = LimbDriver(self._limbs, self._main)
        self._readings = LimbReadings(shapes)
        self._answers = CartesianAnswers(self._limbs, names, self._driver, self._readings)
        self._orders = CartesianOrders(self._limbs, names, self._driver, self._readings)
        self._steps = 0
        self._parts = {
            part: joints for shape in shapes.values() for part, joints in shape.parts.items()
        }
        states = (JOINT_STATE[part] for part in self._parts)
        self.reads = (IK_SOLUTION, VIRTUAL_POINT, *states, DYNAMICS_STATUS, EXTERNAL)
        commands = (JOINT_COMMAND[part] for part in self._parts)
        self.writes = (*commands, CARTESIAN_STATUS, CARTESIAN_EVENTS, CARTESIAN_SETUP)

    def step(self, now_ns: int, inputs: Inputs, outputs: Outputs) -> None:
        """One control period."""
        self._readings.begin(inputs)
        self._forget_references(inputs)
        self._take_requests(now_ns, inputs, outputs)
        self._orders.advance(now_ns, inputs, outputs)
        self._take_points(now_ns, inputs)
        driver = self._driver
        reading = self._readings.of(driver.limb)
        force_n = self._force(inputs)
        output = driver.step(now_ns, reading, force_n)
        if output is not None:
            for part, command in driver.control.commands(now_ns, output).items():
                outputs.put(JOINT_COMMAND[part], command)
        for event in driver.motions.take_events():
            outputs.put(CARTESIAN_EVENTS, event)
        self._steps += 1
        if self._steps % STATUS_EVERY_STEPS == 0:
            status = self._status(now_ns)
            if output is not None:
                status = self._commanding(status, output, force_n)
            outputs.put(CARTESIAN_STATUS, status)

    def close(self, now_ns: int, outputs: Outputs) -> None:
        """Boards hold their last set-points; whoever waits is told."""
        self._driver.close(now_ns)
        for event in self._driver.motions.take_events():
            outputs.put(CARTESIAN_EVENTS, event)

    def _forget_references(self, inputs: Inputs) -> None:
        for part, joints in self._parts.items():
            state = inputs.new(JOINT_STATE[part])
            if state is not None and any(mode != DIRECT for mode in state.control_mode):
                pairs = zip(joints, state.control_mode, strict=False)
                self._references.forget([joint for joint, mode in pairs if mode != DIRECT])

    def _take_requests(self, now_ns: int, inputs: Inputs, outputs: Outputs) -> None:
        for token, request in inputs.requests(CARTESIAN_CALL):
            try:
                if request.action in MOVES:
                    self._orders.take(now_ns, token, request, outputs)
                else:
                    reply = self._answers.answer(now_ns, request)
                    outputs.reply(CARTESIAN_CALL, token, reply)
            except (ServiceError, DforcError) as error:
                outputs.reply(CARTESIAN_CALL, token, CartesianReply(ok=False, reason=str(error)))
        for settings in self._answers.take_changed():
            outputs.put(CARTESIAN_SETUP, SetupInUse(stamp_ns=now_ns, setup=settings.setup))

    def _take_points(self, now_ns: int, inputs: Inputs) -> None:
        points = self._driver.points
        point = points.new_points(now_ns, inputs)
        if point is not None:
            limb = point.limb or self._main
            time_s = point.trajectory_time_s
            if limb in self._limbs and (time_s == 0.0 or SHORTEST_S <= time_s <= LONGEST_S):
                self._driver.follow(now_ns, limb, time_s)
            else:
                points.refused += 1
        points.take_solution(now_ns, inputs, self._driver.control.problem.tips, self._driver.limb)

    def _force(self, inputs: Inputs) -> float:
        """Largest force on a hand of the limb in use [N]; 0 when unknown."""
        shape = self._driver.control.shape
        if shape.name == self._main:
            return external_force(inputs.fresh(DYNAMICS_STATUS, FORCE_AGE_S))
        contacts = inputs.fresh(EXTERNAL, FORCE_AGE_S)
        if contacts is None:
            return 0.0
        felt = [c.force_n for c in contacts.contacts if c.sensor in shape.sensors]
        return max((math.hypot(*force_n) for force_n in felt), default=0.0)

    def _status(self, now_ns: int) -> CartesianStatus:
        """What is measured; for a controller that commands nothing that is all."""
        position, turned = NAN3, NAN3
        reading, driver = self._readings.of(self._main), self._driver
        if not reading.missing:
            tip = self._limbs[self._main].problem.tips[0]
            hand_rotation, hand_m = tip.pose(np.array(reading.q_rad))
            position, turned = vector3(hand_m), vector3(rotation.rotation_vector(hand_rotation))
        motion = driver.motions.current
        return CartesianStatus(
            stamp_ns=now_ns,
            state="waiting",
            q_rad=reading.q_rad,
            hand_position_m=position,
            hand_rotation_rad=turned,
            refused=driver.refused + driver.points.refused,
            mode=str(driver.mode),
            limb=driver.limb,
            motion=motion.motion,
            progress=motion.progress if motion.motion else math.nan,
            ignored=driver.points.ignored,
            reason=driver.reason,
        )

    def _commanding(
        self, status: CartesianStatus, output: CartesianOutput, force_n: float
    ) -> CartesianStatus:
        driver, points = self._driver, self._driver.points
        status = msgspec.structs.replace(
            status,
            state="in_target" if output.in_target else "moving",
            position_error_m=output.position_error_m,
            orientation_error_rad=output.orientation_error_rad,
            external_force_n=force_n,
            gated=output.gated,
            plan_position_m=vector3(output.tips[0].plan_position_m),
        )
        if driver.mode is not Mode.FIELD or points.followed is None or points.solution is None:
            return status
        return msgspec.structs.replace(
            status,
            state="in_target" if output.in_target and points.is_at_rest else "moving",
            point_position_m=points.followed.position_m,
            ik_status=points.solution.status,
            ik_position_error_m=points.solution.position_error_m,
        )


def external_force(status: DynamicsStatus | None) -> float:
    """Size of the force on the hand [N]; 0 when unknown."""
    return 0.0 if status is None else float(np.linalg.norm(status.external_force_n))


def build(context: Context) -> Cartesian:
    """Load the models of the robot's limbs."""
    return Cartesian(load_robot(context.robot))


if __name__ == "__main__":
    raise SystemExit(run_process("cartesian", build))
