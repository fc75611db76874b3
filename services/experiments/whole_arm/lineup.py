"""The laws by name, made for a limb: the papers' two, and the project's."""

from collections.abc import Callable, Sequence

import numpy as np

from dforc.collision.obstacles import Obstacle, world_of
from dforc.field.force import FieldParams, scene_of
from dforc.field.rollout import PERIOD_S
from dforc.pmp.motion import Pmp, PmpTarget
from dforc.pmp.params import PmpParams
from dforc.virtual_arm.arm import VirtualArm
from dforc.virtual_arm.goals import ArmOutput, TipGoal
from dforc.virtual_arm.params import ArmParams
from services.experiments.whole_arm.laws import (
    ENDED,
    HAND_M,
    INFLATION_M,
    Answer,
    ArmLaw,
    Nothing,
    PaperLaw,
    PointLaw,
    Seen,
    ellipsoids,
)
from services.experiments.whole_arm.referee import Array
from services.experiments.whole_arm.setting import ArmSetting
from services.reaching.limb_shape import limb_shape

PMP_GAIN_N = 8.0  # G of the PMP paper's obstacle


class PmpLaw:
    """PMP, variant B: a virtual arm that gives way to the forces on its hand. One hand only."""

    name = "pmp B"

    def __init__(self, setting: ArmSetting, params: PmpParams) -> None:
        limits = setting.limits
        model = setting.problem.tips[0].model
        self._pmp = Pmp(model, limits.lower_rad, limits.upper_rad, params)
        self._made: tuple[Obstacle, ...] | None = None

    def begin(self, q_rad: Array) -> None:
        """The virtual arm at rest, its time at zero."""
        self._state = self._pmp.begin(q_rad)

    def step(self, seen: Seen) -> Answer:
        """One step of Table I."""
        if self._made != seen.obstacles:
            self._made = seen.obstacles
            self._scene = scene_of((), ellipsoids(seen.obstacles), FieldParams(gain_n=PMP_GAIN_N))
        goal = seen.goals[0]
        target = PmpTarget(position_m=goal.position_m, rotation=goal.rotation)
        self._state = self._pmp.step(self._state, target, self._scene, PERIOD_S)
        over = self._pmp.params.has_time_base and self._state.time_s > self._pmp.params.duration_s
        return Answer(self._state.q_rad, ENDED if over else "")


class UlnaLaw:
    """The virtual arm: whole arm, no contact."""

    def __init__(self, setting: ArmSetting, params: ArmParams | None = None) -> None:
        body = setting.body
        self.name = "ulna"
        self.arm = VirtualArm(
            body,
            setting.joints,
            setting.limits,
            limb_shape(setting.robot, setting.limb).speed_limits_rad_s,
            tuple(body.tips.index(frame) for frame in setting.tips),
            setting.problem.rest_rad,
            params,
        )
        self._home = setting.body_home_rad
        self._still = np.zeros(len(body.joints))
        self._seen: Seen | None = None
        self.last: ArmOutput | None = None  # for whoever replays a scene

    def begin(self, q_rad: Array) -> None:
        """Stand."""
        self.arm.begin(q_rad)
        self._seen = None

    def step(self, seen: Seen) -> Answer:
        """One period."""
        if self._seen is None or self._seen is not seen:
            self._seen = seen
            self._world = world_of(seen.obstacles)
            self._goals = [TipGoal(goal.position_m, goal.rotation) for goal in seen.goals]
        others = self._home if seen.others_rad is None else seen.others_rad
        speeds = self._still if seen.others_rad_s is None else seen.others_rad_s
        self.last = self.arm.step(self._goals, self._world, others, speeds, PERIOD_S)
        return Answer(self.last.q_rad, str(self.last.state), self.last.reason)


LAWS: dict[str, Callable[[ArmSetting], ArmLaw]] = {
    "empty": lambda _: Nothing(),
    "dforc": lambda setting: PaperLaw("dforc", setting.problem, FieldParams()),
    "dforc-inflated": lambda setting: PaperLaw(
        "dforc, hand + 1 cm", setting.problem, FieldParams(margin_m=HAND_M + INFLATION_M)
    ),
    "pmp": lambda setting: PmpLaw(setting, PmpParams()),
    "point": lambda setting: PointLaw("point", setting.problem),
    "ulna": UlnaLaw,
}


def make_law(name: str, setting: ArmSetting) -> ArmLaw:
    """A law for a limb, by its name in LAWS."""
    return LAWS[name](setting)


def make_laws(names: Sequence[str], setting: ArmSetting) -> list[ArmLaw]:
    """Several."""
    return [make_law(name, setting) for name in names]
