"""Streams of targets, 5 mm from one to the next: two lemniscates and a path through joint space."""

from dataclasses import dataclass

import numpy as np

from services.experiments.ik.arm import Arm, Array
from services.experiments.ik.kept import kept
from services.experiments.ik.nlp import Form, PlainNlp

VERSION = 1  # of what is kept between runs
STEP_M = 0.005  # per tick of 10 ms
STARTS = 6
JOINT_STEP_RAD = np.radians(2.0)  # at most, between two targets of the joint path
SAMPLES = 20_000
REACHED_M = 1e-4
CENTRE = (-0.25, 0.15, 0.09)  # of the public experiment pattacini/iros2010, as its gain
GAIN_M = 0.13
FAR_CENTRE = (-0.35, 0.28, 0.12)
FAR_GAIN_M = 0.26


@dataclass(frozen=True, eq=False)
class Path:
    """One target per tick, and how close an independent solver comes to it."""

    name: str
    position: Array  # (k, 3)
    rotation: Array  # (k, 3, 3)
    start: Array  # (n,)
    nearest_m: Array  # (k,)

    def __len__(self) -> int:
        return len(self.position)

    def reached(self) -> "np.ndarray[tuple[int], np.dtype[np.bool_]]":
        """Which ticks (k,) have their position in reach."""
        return np.asarray(self.nearest_m <= REACHED_M)

    def well_reached(self) -> "np.ndarray[tuple[int], np.dtype[np.bool_]]":
        """Those whose neighbours are in reach, too.

        On the edge itself the arm is straight, and no bounded joint step follows the hand.
        """
        inner = self.reached()
        return np.asarray(inner & np.append(inner[1:], True) & np.append(True, inner[:-1]))

    def cut(self, ticks: int) -> "Path":
        """The first ticks."""
        return Path(
            self.name,
            self.position[:ticks],
            self.rotation[:ticks],
            self.start,
            self.nearest_m[:ticks],
        )


def lap_of(centre: tuple[float, float, float], gain: float) -> Array:
    """A lying eight in the frontal plane, once around in steps of 5 mm from its middle (k, 3)."""
    turn = np.linspace(0.0, 2.0 * np.pi, SAMPLES)
    wide = gain / (1.0 + np.sin(turn) ** 2)
    curve = np.column_stack(
        [np.zeros(SAMPLES), wide * np.cos(turn), wide * np.cos(turn) * np.sin(turn)]
    )
    lap = _even(curve + np.array(centre))[:-1]
    return np.roll(lap, -(len(lap) // 4), axis=0)


def lemniscate(arm: Arm, ticks: int, *, far: bool = False) -> Path:
    """The hand along the eight in one orientation; `far` leaves the workspace."""
    centre, gain = (FAR_CENTRE, FAR_GAIN_M) if far else (CENTRE, GAIN_M)
    lap = lap_of(centre, gain)

    def make() -> dict[str, Array]:
        nlp = PlainNlp(arm, Form.NEAREST)
        R, _ = arm.pose(nlp.solve(lap[0], np.eye(3), arm.rest))
        start = PlainNlp(arm, Form.EXACT).solve(lap[0], R, arm.rest)
        return {"R": R, "start": start, "nearest_m": _nearest(arm, nlp, lap, R, start)}

    known = kept(arm, "far" if far else "lemniscate", (VERSION, centre, gain), make)
    laps = -(-ticks // len(lap))
    return Path(
        "lemniscate leaving the workspace" if far else "lemniscate",
        np.tile(lap, (laps, 1))[:ticks],
        np.broadcast_to(known["R"], (ticks, 3, 3)),
        known["start"],
        np.tile(known["nearest_m"], laps)[:ticks],
    )


def joint_path(arm: Arm, seed: int, ticks: int) -> Path:
    """Straight in joint space between random postures inside the rows: every pose is in reach."""
    rng = np.random.default_rng([seed, 4])
    q = arm.postures(rng, 1)[0]
    start = q
    found: list[tuple[Array, Array]] = []
    while len(found) < ticks:
        to = arm.postures(rng, 1)[0]
        while len(found) < ticks and np.abs(to - q).max() > 1e-6:
            q = _stepped(arm, q, to)
            found.append(arm.pose(q))
    rotation, position = (np.array(part) for part in zip(*found, strict=True))
    return Path("random joint path", position, rotation, start, np.zeros(ticks))


def _stepped(arm: Arm, q: Array, to: Array) -> Array:
    """Along the straight way until the hand has gone 5 mm or a joint 2 degrees."""
    way = to - q
    share = min(1.0, float(JOINT_STEP_RAD / np.abs(way).max()))
    moved = arm.distance_m(q + share * way, arm.pose(q)[1])
    share *= min(1.0, STEP_M / max(moved, 1e-9))
    return q + share * way


def _even(curve: Array) -> Array:
    """The same curve in equal steps of 5 mm, near enough to close."""
    length = np.append(0.0, np.cumsum(np.linalg.norm(np.diff(curve, axis=0), axis=1)))
    at = np.linspace(0.0, length[-1], round(length[-1] / STEP_M) + 1)
    return np.column_stack([np.interp(at, length, curve[:, i]) for i in range(3)])


def _nearest(arm: Arm, nlp: PlainNlp, points: Array, R: Array, q: Array) -> Array:
    """Smallest distance to each point: from both neighbours' postures, and from others."""
    rng = np.random.default_rng(5)
    best = np.full(len(points), np.inf)
    postures = np.tile(q, (len(points), 1))

    def attempt(i: int, starts: Array) -> None:
        for start in starts:
            end = nlp.solve(points[i], R, start)
            distance = arm.distance_m(end, points[i])
            if distance < best[i]:
                best[i], postures[i] = distance, end

    order = list(range(len(points)))
    for i in order:
        attempt(i, np.array([postures[i - 1], arm.rest]))
    for i in reversed(order):
        if best[i] > REACHED_M:
            attempt(i, np.vstack([postures[(i + 1) % len(points)], arm.postures(rng, STARTS)]))
    return best
