"""Figure 6 on the emulated robot, through its boards and CAN frames, in virtual time.

Both balls are sent to the field service as a vision process would send them, every 10 ms; it
follows the green one by name. Their places are exact to the paper's field, which takes them as
they are; the better one is told how uncertain they are. What the hand did is the plant's own word.
"""

from contextlib import closing

import numpy as np
from numpy.typing import NDArray

from services.core.errors import ServiceError
from services.emulated.simulation import Progress, Simulation
from services.experiments.field_figures.fig5_stack import StackTrial
from services.experiments.field_scenes.moving_draw import NOISE_M, OBSTACLE_M, MovingScene
from services.fields.messages import FieldRequest, NamedFloats
from services.messages import Goal, Objects, Vector3, WorldObject
from services.robotfile.robot_tables import RobotFile
from services.script import AbandonedError, Script
from services.streams import FIELD_CALL, GOAL, OBJECTS, VIRTUAL_POINT

Array = NDArray[np.float64]
Paths = tuple[Array, Array]  # virtual point and hand (k, 3)

START_S = 4.0  # to where the green ball starts, before anything moves
TRAJECTORY_S = 0.6  # T
GAINS: dict[str, NamedFloats] = {
    "dforc": (("K", 4.0), ("D", 8.0), ("G", 10.0), ("margin", 0.0), ("T", TRAJECTORY_S)),
    "ulna": (("T", TRAJECTORY_S),),
}
TARGET_M = 0.02  # radius of the green ball
GREEN, RED, SOURCE = "green ball", "red ball", "figure 6"
REST = Goal(stamp_ns=0, position_m=(0.0,) * 3, rotation_rad=(0.0,) * 3, active=False)


def run_stack(
    robot: RobotFile, scene: MovingScene, seed: int, progress: Progress
) -> dict[str, Paths]:
    """Both fields on one emulated robot, one after the other.

    Raises:
        ServiceError: the robot did not carry it through.
    """
    trial = BallTrial(robot, scene, seed)
    with closing(Simulation(robot, seed, guests={"figure 6": trial})) as simulation:
        simulation.run(trial, progress)
    if trial.failure:
        raise ServiceError(f"the emulated robot (plant {seed}) stopped: {trial.failure}")
    return trial.paths


class BallTrial(StackTrial):
    """Takes the robot through the scene in one mode after the other; `paths` holds what came."""

    def __init__(self, robot: RobotFile, scene: MovingScene, seed: int) -> None:
        self.paths: dict[str, Paths] = {}
        self._scene = scene
        self._turn: Vector3 = (0.0, 0.0, 0.0)
        super().__init__(robot, (), seed)

    def script(self) -> Script:
        """Calibrate, then for each mode: to the start, and along with the ball."""
        try:
            yield from self.calibrate()
            for mode, gains in GAINS.items():
                yield from self._go_home()
                yield from self._use("ulna", ())
                yield from self._go_to_start()
                yield from self._use(mode, gains)
                yield from self._follow(mode)
        except AbandonedError as error:
            self.failure = str(error)

    def _use(self, mode: str, gains: NamedFloats) -> Script:
        preset = "paper" if mode == "dforc" else "default"
        request = FieldRequest(action="set", mode=mode, preset=preset, gains=gains)
        yield from self.answered(self.outputs.call(FIELD_CALL, request), "choosing the field")

    def _go_to_start(self) -> Script:
        self.say("going to the green ball")
        self._turn = self._truth().tip_rotation_rad
        start = _triple(self._scene.target_m[0])
        self.outputs.put(
            GOAL, Goal(stamp_ns=self.now_ns, position_m=start, rotation_rad=self._turn)
        )
        yield from self._wait(START_S)

    def _follow(self, mode: str) -> Script:
        self.say(f"following, {mode}")
        points: list[Vector3] = []
        hands: list[Vector3] = []
        for period in range(len(self._scene.target_m)):
            self._send(period, is_exact=mode == "dforc")
            yield
            self._check()
            point = self.inputs.latest(VIRTUAL_POINT)
            if point is None:
                raise AbandonedError("the field is silent")
            points.append(point.position_m)
            hands.append(self._truth().tip_position_m)
        self.paths[mode] = np.array(points), np.array(hands)
        self.outputs.put(GOAL, REST)
        self.outputs.put(OBJECTS, Objects(stamp_ns=self.now_ns, source=SOURCE))
        yield from self._wait(1.0)

    def _send(self, period: int, *, is_exact: bool) -> None:
        scene, variance = self._scene, NOISE_M**2
        covariance = None if is_exact else (variance, 0.0, 0.0, variance, 0.0, variance)
        target = _triple(scene.seen_target_m[period])
        balls = (
            WorldObject(
                name=GREEN,
                shape="sphere",
                size_m=(TARGET_M,),
                position_m=target,
                covariance_m2=covariance,
                role="target",
            ),
            WorldObject(
                name=RED,
                shape="sphere",
                size_m=(OBSTACLE_M,),
                position_m=_triple(scene.seen_obstacle_m[period]),
                covariance_m2=covariance,
            ),
        )
        self.outputs.put(OBJECTS, Objects(stamp_ns=self.now_ns, objects=balls, source=SOURCE))
        self.outputs.put(
            GOAL,
            Goal(stamp_ns=self.now_ns, position_m=target, rotation_rad=self._turn, follow=GREEN),
        )


def _triple(place: Array) -> Vector3:
    x, y, z = place.tolist()
    return x, y, z
