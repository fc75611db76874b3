"""Run what is compiled once, so that nobody waits for it in the middle of a motion."""

import numpy as np

from dforc.arrays import Vector
from dforc.collision.obstacles import World
from dforc.virtual_arm.planner import PlanState, PosturePlanner
from services.core.clock import NS_PER_MS
from services.core.errors import ServiceError
from services.fields.around import BodyReading, around_limb
from services.fields.driver import PointDriver, start_at
from services.fields.limbs import FieldLimb
from services.fields.messages import MODES
from services.fields.mode import HandGoal
from services.fields.sources import Sources
from services.messages import Objects, Vector3, WorldObject
from services.reaching.tip_poses import vector3

AWAY_M = np.array([-0.15, 0.0, 0.0])
STEPS = 60  # until an arm that stands before the wall looks for a way
PLANNED = 100
NEAR_M = np.array([-0.02, 0.0, 0.02])
BENT_RAD = 0.3
WALL_M = (0.02, 0.3, 0.3)


def warm_modes(driver: PointDriver, limb: FieldLimb, body: BodyReading) -> None:
    """Have every mode move a limb towards a goal behind a wall."""
    start = start_at(limb, limb.problem.limits.project(limb.problem.rest_rad))
    goals = [HandGoal(position_m=hand.position_m + AWAY_M) for hand in start.hands]
    near = [
        HandGoal(position_m=hand.position_m + NEAR_M, rotation=hand.rotation)
        for hand in start.hands
    ]
    free = around_limb((), None, (body.q_rad, body.dq_rad_s))
    middle = vector3(start.hands[0].position_m + 0.6 * AWAY_M)
    seen = noisy_wall(middle).seen(0)
    around = around_limb(seen, None, (body.q_rad, body.dq_rad_s))
    for mode in MODES:
        try:
            law = driver.law_of(mode, limb)
        except ServiceError:
            continue  # a mode that does not move such a limb
        law.begin(start)
        for asked, where in ((goals, around), (near, free)):
            for _ in range(STEPS):
                law.step(asked, where, 0.0)
    _warm_planner(limb, body, start.q_rad, around.world)


def _warm_planner(limb: FieldLimb, body: BodyReading, q_rad: Vector, world: World) -> None:
    """It is seldom needed, and would be compiled when it is."""
    limits = limb.problem.limits
    planner = PosturePlanner(body.body, body.body.columns(limb.shape.joints), limits)
    goal = limits.project(q_rad + BENT_RAD)
    planner.begin(q_rad, goal[None], world, body.q_rad, 0.0, 0.0)
    while planner.advance(PLANNED) is PlanState.SEARCHING:
        pass


def noisy_wall(place_m: Vector3) -> Sources:
    """A wall that was seen twice, with noise: it is filtered."""
    sources = Sources()
    for i in (1, 2):
        now_ns = i * 33 * NS_PER_MS
        wall = WorldObject(
            name="wall",
            shape="box",
            size_m=WALL_M,
            position_m=place_m,
            covariance_m2=(1e-6, 0.0, 0.0, 1e-6, 0.0, 1e-6),
            seen_ns=now_ns,
        )
        sources.take(now_ns, Objects(stamp_ns=now_ns, objects=(wall,), source="warm"))
    return sources
