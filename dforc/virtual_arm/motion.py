"""The virtual arm as a moving posture: what is near it, and one step at speeds that avoid it."""

import math

import numpy as np
from numpy.typing import NDArray

from dforc.arrays import ArrayLike, Matrix, Vector, finite_vector
from dforc.collision.body import Body
from dforc.collision.kernel_body import (
    clearance,
    place_body,
    proximities,
    tip_jacobian,
    tip_pose,
)
from dforc.collision.obstacles import World
from dforc.limits import JointLimits
from dforc.virtual_arm.goals import TipMotion
from dforc.virtual_arm.kernel_arm import surfaces
from dforc.virtual_arm.kernel_velocity import (
    MISSED,
    STOPPED,
    Keeping,
    Wishes,
    choose_velocity,
    room_of,
)
from dforc.virtual_arm.params import ArmParams

MOST_SURFACES = 48
HALVINGS = 5  # of a speed that would touch something
SELF_REACH_M = 0.12
TOUCH_M = 0.001  # a step that would leave less of a distance than this is shortened

Indices = NDArray[np.int64]


class ArmMotion:
    """Posture and speed of a limb, and all of the body around it."""

    def __init__(
        self,
        body: Body,
        joints: tuple[str, ...],
        limits: JointLimits,
        speed_limits_rad_s: ArrayLike,
        tips: tuple[int, ...],
        params: ArmParams,
    ) -> None:
        """Of the limb whose joints are named, in the order of its vectors."""
        self.body = body
        self.params = params
        self.limits = limits
        self.columns = body.columns(joints)
        self.tips = tips
        self.n = n = len(joints)
        N, c = len(body.joints), len(body.capsules)
        self._speed_limits = finite_vector("speed limits", speed_limits_rad_s, n)
        self.speeds: Vector = params.speed_share * self._speed_limits
        self.q: Vector = np.zeros(n)
        self.dq: Vector = np.zeros(n)
        self.jacobian: Matrix = np.zeros((6 * len(tips), n))
        # Of the hands in the period before (6 for each). With today's Jacobian the speeds of then
        # would be another motion: the hand would be carried aside as by a centrifugal force.
        self.velocity: Vector = np.zeros(6 * len(tips))
        self.mask = body.moved_by(joints)
        self.count = 0
        self.nearest = -1
        self.left_m = math.inf  # of the distances beyond their margins, at least
        self.distances: Vector = np.zeros(MOST_SURFACES)
        self.which: Indices = np.zeros((MOST_SURFACES, 2), dtype=np.int64)
        self._gradients: Matrix = np.zeros((MOST_SURFACES, N))
        self._drifts: Vector = np.zeros(MOST_SURFACES)
        self._limb_gradients: Matrix = np.zeros((MOST_SURFACES, n))
        self._floors: Vector = np.zeros(MOST_SURFACES)
        self._pushes: Vector = np.zeros(MOST_SURFACES)
        self._keeping = Keeping(
            limits.C,
            limits.lower,
            limits.upper,
            self.speeds,
            self._limb_gradients,
            self._floors,
            self._pushes,
        )
        self._frames: Matrix = np.zeros((N, 12))
        self._segments: Matrix = np.zeros((c, 6))
        self._room = room_of(n, len(limits.C) - n, MOST_SURFACES)
        self._turn, self._place = np.zeros((len(tips), 9)), np.zeros((len(tips), 3))
        self._tip_columns: Matrix = np.zeros((6, N))
        self._body_q: Vector = np.zeros(N)
        self._ahead: Vector = np.zeros(N)  # the body's other joints after this step

    def begin(self, q: Vector, dq: Vector) -> None:
        """Be there, at these speeds."""
        self.q, self.dq = q, dq
        self._stand(np.zeros(len(self.body.joints)))  # joints that are not the limb's carry no hand
        self.velocity = self.jacobian @ dq

    def change(self, params: ArmParams) -> None:
        """Other constants."""
        self.params = params
        self.speeds[:] = params.speed_share * self._speed_limits

    def look(
        self,
        world: World,
        others_q: Vector,
        others_dq: Vector,
        margin_m: float,
        period_s: float,
    ) -> None:
        """Take in what is where, for this step."""
        arrays, params = self.body.arrays, self.params
        self._stand(others_q)
        self._ahead = others_q + period_s * others_dq
        self.count = proximities(
            self._body_q,
            arrays,
            world,
            self.mask,
            params.reach_m,
            SELF_REACH_M,
            self._frames,
            self._segments,
            self.distances,
            self._gradients,
            self._drifts,
            self.which,
        )
        self.nearest, self.left_m = surfaces(
            self.distances,
            self._drifts,
            self._gradients,
            self.which,
            self.count,
            self.columns,
            others_dq,
            margin_m,
            params.self_margin_m,
            params.approach_1_s,
            params.withdraw_1_s,
            period_s,
            self._limb_gradients,
            self._floors,
            self._pushes,
        )

    def _stand(self, others_q: Vector) -> None:
        """Frames, hands and their Jacobian at the posture."""
        arrays = self.body.arrays
        self._body_q[:] = others_q
        self._body_q[self.columns] = self.q
        place_body(self._body_q, arrays, self._frames, self._segments)
        for at, tip in enumerate(self.tips):
            tip_pose(arrays, tip, self._frames, self._turn[at], self._place[at])
            tip_jacobian(arrays, tip, self._frames, self._tip_columns)
            self.jacobian[6 * at : 6 * at + 6] = self._tip_columns[:, self.columns]

    def pose(self, at: int) -> tuple[Matrix, Vector]:
        """Rotation (3, 3) and position (3,) of a hand, as `look` found them."""
        return self._turn[at].reshape(3, 3), self._place[at]

    def tip_motions(self) -> tuple[TipMotion, ...]:
        """The hands after a step."""
        self._body_q[self.columns] = self.q
        arrays = self.body.arrays
        place_body(self._body_q, arrays, self._frames, self._segments)
        motions = []
        for at, tip in enumerate(self.tips):
            tip_pose(arrays, tip, self._frames, self._turn[at], self._place[at])
            R, p = self.pose(at)
            velocity = self.velocity[6 * at : 6 * at + 3].copy()
            motions.append(TipMotion(R.copy(), p.copy(), velocity))
        return tuple(motions)

    def step(
        self,
        v: Vector,
        weights: Vector,
        dq_wanted: Vector,
        posture: Vector,
        world: World,
        period_s: float,
    ) -> tuple[bool, bool]:
        """Move by one period. Whether the last speed was held, and whether surfaces are missed."""
        dq = np.zeros(self.n)
        limits, params = self.limits, self.params
        wishes = Wishes(self.jacobian, v, weights, dq_wanted, posture)
        how = choose_velocity(
            self.q,
            self.dq,
            params.acceleration_rad_s2,
            period_s,
            wishes,
            self._keeping,
            self.count,
            self._room,
            dq,
        )
        held = how == STOPPED or not math.isfinite(float(dq @ dq))
        if held:
            dq = self._last_safe()
        share = 1.0 if how == MISSED else self._safe_share(dq, world, period_s)
        self.dq = share * dq
        self.velocity = self.jacobian @ self.dq
        moved = self.q + period_s * self.dq
        lowest = np.minimum(limits.lower_rad, self.q)  # who begins beyond a limit does not jump
        highest = np.maximum(limits.upper_rad, self.q)
        self.q = np.minimum(np.maximum(moved, lowest), highest)
        return held, how == MISSED

    def _last_safe(self) -> Vector:
        """The speed before, as far as the surfaces bear it."""
        count = self.count
        for share in (1.0, 0.75, 0.5, 0.25):
            dq = share * self.dq
            if (self._limb_gradients[:count] @ dq >= self._floors[:count]).all():
                return dq
        return np.zeros(self.n)

    def _safe_share(self, dq: Vector, world: World, period_s: float) -> float:
        """Share of a speed that touches nothing: the program sees surfaces as planes."""
        before = float(self.distances[: self.count].min(initial=math.inf))
        floor = min(TOUCH_M, before)
        ahead = world._replace(centres=world.centres + period_s * world.velocities)
        share = 1.0
        for _ in range(HALVINGS):
            if self._left(share * period_s * dq, ahead, floor - 1e-6) >= floor - 1e-6:
                return share
            share *= 0.5
        standing = self._left(np.zeros(self.n), ahead, -math.inf)
        return 1.0 if self._left(period_s * dq, ahead, -math.inf) > standing else 0.0

    def _left(self, way: Vector, world: World, enough: float) -> float:
        """Least distance of surfaces after a way (n,) from here; once below `enough` any one."""
        self._body_q[:] = self._ahead
        self._body_q[self.columns] = self.q + way
        left: float = clearance(
            self._body_q,
            self.body.arrays,
            world,
            self.mask,
            self._frames,
            self._segments,
            0.0,
            0.0,
            enough,
        )
        return left
