"""Whatever is sent through the HAL, no joint of the whole robot passes a limit.

Taking power away is not among it: a limb that is switched off falls, on the real robot too.
"""

from collections.abc import Callable, Iterator
from functools import partial

import numpy as np
import pytest
from numpy.typing import NDArray

from benchmarks.whole_robot import WholeRobot
from firmware_sim.boards.motor_board import MotorBoard
from hal.wire.modes import ControlMode

Vector = NDArray[np.float64]

TOLERANCE_RAD = np.radians(0.2)
BEYOND_RAD = 2.0
ROOM_DEG = 6.0  # at home; torque mode asks for 5
FAST_RAD_S = 3.0  # more than any joint may have


class Bench:
    """The whole robot, calibrated, every joint about where it is parked."""

    def __init__(self) -> None:
        self.whole = WholeRobot("icub")
        self.whole.calibrated()
        self.hal, self.rig = self.whole.hal, self.whole.rig
        described = self.hal.description.joints
        self.names = tuple(joint.name for joint in described)
        self.every = range(len(described))
        self.low = np.radians([joint.min_deg for joint in described])
        self.high = np.radians([joint.max_deg for joint in described])
        room = np.radians([joint.margin_deg + ROOM_DEG for joint in described])
        park = np.radians([self.whole.file.joints[name].park_deg for name in self.names])
        self.home = np.clip(park, self.low + room, self.high - room)
        self.felt = [
            i
            for i, joint in enumerate(described)
            if None not in (joint.torque_source, joint.torque_pid, joint.impedance)
        ]
        sources = [joint.torque_source for joint in described]
        self.full_nm = np.array([0.0 if one is None else one.full_scale_nm for one in sources])
        self.torques_nm: Vector = np.zeros(len(described))
        self._order = [self.rig.joints.index(name) for name in self.names]
        self.worst: Vector = np.full(len(described), -np.inf)

    def tick(self, milliseconds: int) -> None:
        for _ in range(milliseconds):
            self.hal.set_joint_torques(self.every, self.torques_nm.tolist(), self.whole.now_ns)
            self.whole.tick()
            q = self.rig.plant.q_rad[self._order]
            np.maximum(self.worst, np.maximum(self.low - q, q - self.high), out=self.worst)

    def do(self, action: str, value: str = "", q: Vector | None = None, only: bool = False) -> None:
        names = [self.names[i] for i in self.felt] if only else self.names
        task = self.hal.request(action, names, value, () if q is None else q.tolist())
        while not task.done:
            self.tick(1)
        assert task.ok, task.reason

    def go_home(self) -> None:
        """Whatever was before: stiff, position mode, parked; then nothing has been seen yet."""
        self.torques_nm[:] = 0.0
        self.do("mode", "position")
        self.do("interaction", "stiff")
        self.do("move", q=self.home)
        self.worst[:] = -np.inf

    def passed(self) -> dict[str, float]:
        """Joints that were outside their limits, and how far, degrees."""
        outside = np.flatnonzero(self.worst > TOLERANCE_RAD).tolist()
        return {self.names[i]: round(float(np.degrees(self.worst[i])), 2) for i in outside}


@pytest.fixture(scope="module")
def warm() -> Iterator[Bench]:
    bench = Bench()
    yield bench
    bench.whole.close()


@pytest.fixture
def bench(warm: Bench) -> Bench:
    warm.go_home()
    assert warm.rig.limits_waiting == ()
    return warm


def directed(bench: Bench, way: Vector) -> None:
    """Set-points far outside."""
    bench.do("mode", "direct")
    far = np.where(way > 0.0, bench.high + BEYOND_RAD, bench.low - BEYOND_RAD).tolist()
    for _ in range(350):
        assert bench.hal.set_positions(bench.every, far)
        bench.tick(20)


def hurried(bench: Bench, way: Vector) -> None:
    """Velocities into the limits, until the caller falls silent."""
    bench.do("mode", "velocity")
    for _ in range(250):
        assert bench.hal.set_velocities(bench.every, (FAST_RAD_S * way).tolist())
        bench.tick(20)
    bench.tick(500)


def moved(bench: Bench, way: Vector) -> None:
    """Moves from one limit to the other as fast as they may be."""
    margin = np.radians([joint.margin_deg for joint in bench.hal.description.joints])
    ends = bench.low + margin, bench.high - margin
    for side in (way, -way):
        bench.do("move", q=np.where(side > 0.0, ends[1], ends[0]))
        bench.tick(500)


def switched(bench: Bench, way: Vector) -> None:
    """Modes that change in full motion, again and again: each takes where it is as reference."""
    far = np.where(way > 0.0, bench.high + BEYOND_RAD, bench.low - BEYOND_RAD).tolist()
    for mode in ("direct", "velocity", "position") * 5:
        bench.do("mode", mode)
        for _ in range(30):
            if mode == "direct":
                bench.hal.set_positions(bench.every, far)
            elif mode == "velocity":
                bench.hal.set_velocities(bench.every, (FAST_RAD_S * way).tolist())
            bench.tick(10)


def driven(bench: Bench, way: Vector) -> None:
    """Full PWM, joint by joint for as long as it stays in open loop."""
    bench.do("mode", "pwm")
    for _ in range(800):
        for joint in bench.every:
            if bench.hal.joints.control_mode[joint] == ControlMode.OPENLOOP:
                bench.hal.set_duties([joint], [100.0 * way[joint]])
        bench.tick(5)


def forced(bench: Bench, way: Vector) -> None:
    """Full torques where the torque sensor feels nothing."""
    bench.tick(5)
    bench.do("mode", "torque", only=True)
    for _ in range(600):
        for joint in bench.felt:
            if bench.hal.joints.control_mode[joint] == ControlMode.TORQUE:
                bench.hal.set_torques([joint], [bench.full_nm[joint] * way[joint]])
        bench.tick(5)


def biased(bench: Bench, way: Vector, share: float) -> None:
    """Springs with offsets, and half the full scale of torque that is not there."""
    bench.tick(5)
    bench.do("interaction", "compliant", only=True)
    bench.torques_nm[:] = -0.5 * way * bench.full_nm
    offsets = (share * way * bench.full_nm)[bench.felt].tolist()
    for _ in range(600):
        assert bench.hal.set_impedance_offsets(bench.felt, offsets)
        bench.tick(5)


def calibrated(bench: Bench, way: Vector) -> None:
    """Calibration once more in full motion, of those that do not look for a hard stop."""
    bench.do("mode", "direct")
    far = np.where(way > 0.0, bench.high + BEYOND_RAD, bench.low - BEYOND_RAD).tolist()
    for _ in range(90):
        bench.hal.set_positions(bench.every, far)
        bench.tick(10)
    described = bench.hal.description.joints
    found = [joint.name for joint in described if joint.calibration.type == ABSOLUTE]
    task = bench.hal.request("calibrate", found, "again")
    while not task.done:
        bench.tick(1)
    assert task.ok, task.reason


ABSOLUTE = 3
WAYS = {"up": (1.0, 1.0), "down": (-1.0, -1.0), "odd": (-1.0, 1.0), "even": (1.0, -1.0)}
Attack = Callable[[Bench, Vector], None]
ATTACKS: dict[str, Attack] = {
    "directed": directed,
    "hurried": hurried,
    "moved": moved,
    "switched": switched,
    "driven": driven,
    "forced": forced,
    **{f"biased {share}": partial(biased, share=share) for share in (0.2, 0.45, 0.7, 1.0)},
    "calibrated": calibrated,
}
# One that a position loop has to hold, two that the watch on joints without one has to: an offset
# as of a weight is what a wrong torque gains speed with before anything looks wrong.
WORST = {"directed odd", "forced down", "biased 0.45 down"}
CASES = [
    pytest.param(attack, way, id=case, marks=[] if case in WORST else [pytest.mark.long])
    for name, attack in ATTACKS.items()
    for way in WAYS
    for case in [f"{name} {way}"]
]


@pytest.mark.parametrize(("attack", "way"), CASES)
def test_no_joint_passes_a_limit(bench: Bench, attack: Attack, way: str) -> None:
    before = bench.rig.limit_violations
    attack(bench, np.resize(WAYS[way], len(bench.names)))

    assert bench.passed() == {}
    assert bench.rig.limit_violations == before


def test_no_buffer_of_a_board_overruns_when_everything_is_sent_each_millisecond(
    bench: Bench,
) -> None:
    bench.tick(5)
    bench.do("mode", "direct")
    bench.do("interaction", "compliant", only=True)
    pids = [joint.position_pid for joint in bench.hal.description.joints]
    tuned = []
    for ms in range(300):
        bench.hal.set_positions(bench.every, (bench.home + 1e-3 * (ms % 7)).tolist())
        bench.hal.set_impedance_offsets(bench.felt, [0.01 * (ms % 5)] * len(bench.felt))
        if ms == 20:
            tuned = [bench.hal.tune(n, p) for n, p in zip(bench.names, pids, strict=True)]
        bench.tick(1)

    assert [task.reason for task in tuned] == [""] * len(bench.names)
    motor_boards = [
        board
        for spec in bench.hal.description.boards
        if isinstance(board := bench.rig.board(spec.bus, spec.address), MotorBoard)
    ]
    assert len(motor_boards) == 20
    assert {board.dropped["overrun"] for board in motor_boards} == {0}
