"""Postures of a limb with its hands at their goals and clear of everything: a search in slices."""

from collections.abc import Generator, Iterator, Sequence

import numpy as np
from numpy.typing import NDArray

from dforc.arrays import Matrix, Vector
from dforc.collision.body import Body
from dforc.collision.obstacles import World
from dforc.ik.kernel_chain import Indices
from dforc.limits import JointLimits
from dforc.virtual_arm.goals import TipGoal
from dforc.virtual_arm.kernel_edge import march
from dforc.virtual_arm.kernel_planner import distance
from dforc.virtual_arm.kernel_posture import (
    FIRST_TRUST_RAD,
    QP_ROOM_ROWS,
    Aim,
    Work,
    approach,
    weigh,
)
from dforc.virtual_arm.kernel_random import EVERYWHERE, draw, room_of, seeds, uniform
from dforc.virtual_arm.scene import Surroundings

POSITION_M = 0.001  # largest error of a hand
ORIENTATION_RAD = np.radians(1.0)  # and its orientation where that can be had
MOST_POSTURES = 8
MOST_STEPS = 25  # of one try
STEPS_PER_TRY = 12  # that are reckoned for it: about the mean
STEPS = 6  # at a time
TURNS, STEPS_PER_TURN = 6, 4  # back, of hands that were let turn
SURFACES = 24  # nearest that one try looks at
BEYOND_M = 0.003  # aimed at beyond the margins, so that they are kept
REST_SHARE = 0.3  # of the distance to the rest posture in a posture's cost
SAME_M = 0.03  # postures nearer than this to each other count once
SMALL_SPREAD = 0.5  # of the joints' ranges: every other try begins this near the present posture


class GoalSearch:
    """Random starts, a projection from each; the best postures found are kept."""

    def __init__(
        self,
        body: Body,
        columns: Indices,
        limits: JointLimits,
        tips: Sequence[int],
        rest_rad: Vector,
        seed: int = 0,
        mask: NDArray[np.bool_] | None = None,
    ) -> None:
        """Args: tips are the body's, in the order of the goals; mask as for PosturePlanner."""
        n, size = limits.n, len(body.joints)
        self._surroundings = Surroundings(body, columns, mask)
        self._scene = self._surroundings.scene
        self._room, self._tips = room_of(limits), tuple(tips)
        self._limits, self._rest, self._seed = limits, limits.project(rest_rad), seed
        self._work = Work(
            H=np.zeros((n, n)),
            g=np.zeros(n),
            qp=np.zeros((QP_ROOM_ROWS + 3 * n, n)),
            lower=np.zeros(len(limits.C)),
            upper=np.zeros(len(limits.C)),
            J=np.zeros((6, size)),
            rotation=np.zeros((3, 3)),
            position=np.zeros(3),
            turn=np.zeros(3),
            distances=np.zeros(SURFACES),
            gradients=np.zeros((SURFACES, size)),
            drifts=np.zeros(SURFACES),
            which=np.zeros((SURFACES, 2), dtype=np.int64),
            mask=self._surroundings.mask,
            q=np.zeros(n),
            trust=np.zeros(1),
        )
        self._draws = np.zeros(2, dtype=np.int64)
        self._found: list[tuple[float, float, Vector]] = []  # cost, orientation error, posture
        self._tried = 0
        self._steps: Iterator[int] = iter(())

    def begin(
        self,
        goals: Sequence[TipGoal | None],
        world: World,
        q_now: Vector,
        others_q: Vector,
        margin_m: float,
        self_margin_m: float,
        seed: int | None = None,
    ) -> None:
        """Forget what was found and search for these goals.

        Args:
            goals: one for every tip; None where a hand may be anywhere.
            world: stays as it is now for this search.
            q_now: present posture (n,).
            others_q: the whole body's posture (N,).
            margin_m: between the body and obstacles, beyond their own.
            self_margin_m: between parts of the body.
            seed: another than the search's own, for another attempt.
        """
        wanted = [(tip, one) for tip, one in zip(self._tips, goals, strict=True) if one is not None]
        turns = [np.eye(3) if one.rotation is None else one.rotation for _, one in wanted]
        self._aim = Aim(
            tips=np.array([tip for tip, _ in wanted], dtype=np.int64),
            positions=np.array([one.position_m for _, one in wanted]).reshape(-1, 3),
            rotations=np.array(turns).reshape(-1, 3, 3),
            turned=np.array([one.rotation is not None for _, one in wanted], dtype=np.bool_),
        )
        self._untwisted = self._aim._replace(turned=np.zeros(len(wanted), dtype=np.bool_))
        self._scene = self._surroundings.scene_of(world, others_q, margin_m, self_margin_m)
        self._nearness = np.array([margin_m + BEYOND_M, self_margin_m + BEYOND_M])
        self._now = self._limits.project(q_now)
        self._draws[:] = seeds(self._seed if seed is None else seed)
        self._found, self._tried, self._steps = [], 0, self._tries()

    def advance(self, tries: int) -> int:
        """Do the work of so many tries, and go on in the middle of one the next time.

        Returns the number of postures found so far. It takes STEPS_PER_TRY + STEPS steps for each.
        """
        budget = tries * STEPS_PER_TRY
        while budget > 0:
            budget -= next(self._steps, budget)
        return len(self._found)

    @property
    def postures(self) -> Matrix:
        """Those found (g, n), the best first: near the present posture, and the rest posture.

        If some have all orientations within a degree (of the best there is), only those.
        """
        return np.array([q for _, _, q in self._best()]).reshape(-1, self._limits.n)

    @property
    def orientation_error_rad(self) -> float:
        """Largest orientation error of the best posture; 0 if there is none."""
        best = self._best()
        return best[0][1] if best else 0.0

    @property
    def tried(self) -> int:
        """Starts tried since `begin`."""
        return self._tried

    def _best(self) -> list[tuple[float, float, Vector]]:
        least = min((turned for _, turned, _ in self._found), default=0.0)
        allowed = max(ORIENTATION_RAD, least + ORIENTATION_RAD)
        return [one for one in self._found if one[1] <= allowed]

    def _tries(self) -> Iterator[int]:
        """One try after the other; the steps taken, a few at a time."""
        while True:
            yield from self._try()
            self._tried += 1

    def _try(self) -> Iterator[int]:
        """Every third try lets the hands turn as they like, and turns them back afterwards.

        With the orientation in it from the start, the cost has its least inside an obstacle where
        only another orientation is clear of it.
        """
        q = np.empty(self._limits.n)
        reference, pull = self._start(q)
        freely = self._tried % 3 == 2 and bool(self._aim.turned.any())
        aim = self._untwisted if freely else self._aim
        if not (yield from self._settles(q, reference, pull, aim, MOST_STEPS)):
            return
        best = q.copy()
        for _ in range(TURNS if freely else 0):
            if not (yield from self._settles(q, reference, pull, self._aim, STEPS_PER_TURN)):
                break
            best[:] = q
        self._keep(best, self._turned(best, reference, pull))

    def _settles(
        self, q: Vector, reference: Vector, pull: float, aim: Aim, most: int
    ) -> Generator[int, None, bool]:
        """Move q towards the aim; whether the hands are there and all is clear."""
        self._work.trust[0] = FIRST_TRUST_RAD
        far, taken = np.inf, STEPS
        while taken == STEPS and most > 0:
            far, _, taken = approach(
                q,
                reference,
                pull,
                self._scene,
                self._room,
                aim,
                self._nearness,
                self._work,
                min(STEPS, most),
            )
            most -= taken
            yield taken + 1
        if far > POSITION_M:
            return False
        free, _, _ = march(self._scene, q, q)
        return bool(free >= 1.0)

    def _turned(self, q: Vector, reference: Vector, pull: float) -> float:
        """Largest orientation error."""
        _, _, turned = weigh(q, reference, pull, self._scene, self._aim, self._nearness, self._work)
        return float(turned)

    def _start(self, q: Vector) -> tuple[Vector, float]:
        """A start into q; the posture that it is pulled to, and how much."""
        if self._tried < 2:
            q[:] = self._rest if self._tried else self._now
            return q.copy(), 1.0
        spread = SMALL_SPREAD if self._tried % 2 else EVERYWHERE
        draw(self._draws, self._room, self._now, spread, q)
        to_now = uniform(self._draws)
        return q + to_now * (self._now - q), 1.0

    def _keep(self, q: Vector, turned: float) -> None:
        metric = self._scene.moving.metric
        cost = distance(metric, q, self._now) + REST_SHARE * distance(metric, q, self._rest)
        score = cost + 100.0 * max(0.0, turned - ORIENTATION_RAD)
        for k, (other, _, posture) in enumerate(self._found):
            if distance(metric, q, posture) < SAME_M:
                if score >= other:
                    return
                del self._found[k]
                break
        self._found.append((score, turned, q))
        self._found.sort(key=lambda one: one[0])
        del self._found[MOST_POSTURES:]
