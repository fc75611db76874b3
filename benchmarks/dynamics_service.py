"""What a step of the whole-body dynamics service costs, in virtual time, without the executor.

    python -m benchmarks.dynamics_service [--json FILE]

Readings with noise come every millisecond, joint states every fourth, as in virtual time; every
sensor is calibrated, so every part gets its torques. A look (contacts, health, samples) comes each
tenth millisecond. An idle service that reads the same streams shows what the bench itself costs.
"""

import argparse
from pathlib import Path

import msgspec
import numpy as np
from numpy.typing import NDArray

from services.config import load_robot
from services.core.clock import NS_PER_MS, wall_ns
from services.core.service import Inputs, Outputs, Service
from services.core.stream import Stream
from services.core.testing import Bench
from services.dynamics import Dynamics
from services.experiments.rows import Row, at_most, publish
from services.messages import JointState, Wrench
from services.streams import DYNAMICS_CALL
from services.wholebody.dynamics_messages import DynamicsRequest

ROUNDS = 7
TICKS = 1000
WARM_TICKS = 500
STATE_EVERY, LOOK_EVERY = 4, 10
BARS_US = {"icub:reach": 25.0, "icub:arms": 40.0, "icub": 80.0}
NOISE = 0.05  # N and Nm: more than a sensor's, so that none seems frozen


class Idle(Service):
    """Reads what another service reads, and does nothing."""

    def __init__(self, like: Service) -> None:
        self.reads, self.trigger = like.reads, like.trigger

    def step(self, now_ns: int, inputs: Inputs, outputs: Outputs) -> None:
        """Nothing."""


class Feed:
    """One service under plausible messages; the duration of every step, by the tick's number."""

    def __init__(self, dynamics: Dynamics, service: Service) -> None:
        self.bench = Bench(service)
        self.times_ns: list[list[int]] = [[] for _ in range(STATE_EVERY * LOOK_EVERY)]
        self._body = dynamics.body
        self._random = np.random.default_rng(0)
        self._tick = 0

    def run(self, ticks: int) -> None:
        """So many milliseconds."""
        for _ in range(ticks):
            messages = self._messages(self.bench.clock.now_ns())
            start_ns = wall_ns()
            self.bench.put_together(messages)
            self.times_ns[self._tick % len(self.times_ns)].append(wall_ns() - start_ns)
            self.bench.clock.advance_ns(NS_PER_MS)
            self._tick += 1

    def plain_us(self) -> float:
        """Median of the steps without a look."""
        plain = [ns for i, times in enumerate(self.times_ns) if i % LOOK_EVERY for ns in times]
        return float(np.median(plain)) * 1e-3

    def look_us(self) -> float:
        """Median of the steps with one."""
        looks = [ns for times in self.times_ns[::LOOK_EVERY] for ns in times]
        return float(np.median(looks)) * 1e-3

    def _messages(self, now_ns: int) -> dict[Stream[msgspec.Struct], msgspec.Struct]:
        messages: dict[Stream[msgspec.Struct], msgspec.Struct] = {}
        for sensor in self._body.sensors:
            messages[sensor.wrench] = _wrench(now_ns, NOISE * self._random.standard_normal(6))
        if self._tick % STATE_EVERY == 0:
            for part in self._body.parts:
                messages[part.state] = _state(now_ns, part.size)
        return messages


def _wrench(now_ns: int, values: NDArray[np.float64]) -> Wrench:
    fx, fy, fz, mx, my, mz = values.tolist()
    return Wrench(stamp_ns=now_ns, force_n=(fx, fy, fz), torque_nm=(mx, my, mz), arrival_ns=now_ns)


def _state(now_ns: int, size: int) -> JointState:
    return JointState(
        stamp_ns=now_ns,
        q_rad=(0.3,) * size,
        dq_rad_s=(0.0,) * size,
        tau_nm=(0.0,) * size,
        control_mode=(0,) * size,
        compliant=(False,) * size,
        valid=True,
    )


def rows(references: tuple[str, ...] = tuple(BARS_US)) -> list[Row]:
    """Rows of each robot, with the idle service in turns."""
    found = []
    for reference in references:
        dynamics = Dynamics(load_robot(reference))
        busy, idle = Feed(dynamics, dynamics), Feed(dynamics, Idle(dynamics))
        busy.run(20)
        busy.bench.request(DYNAMICS_CALL, DynamicsRequest(action="calibrate"))
        busy.run(WARM_TICKS)
        for feed in (busy, idle):
            for times in feed.times_ns:
                times.clear()
        for _ in range(ROUNDS):
            busy.run(TICKS)
            idle.run(TICKS)
        name = f"{reference}: a step of dynamics"
        found += [
            at_most(f"{name}, median", busy.plain_us(), "us", BARS_US[reference]),
            Row(f"{name} with a look, each tenth, median", busy.look_us(), "us"),
            Row(f"{reference}: a step of nothing, median", idle.plain_us(), "us"),
        ]
    return found


def main() -> int:
    """Run all."""
    parser = argparse.ArgumentParser(description=str(__doc__).partition("\n")[0])
    parser.add_argument("--json", type=Path, default=None)
    arguments = parser.parse_args()
    return publish("the dynamics service, virtual time", rows(), arguments.json)


if __name__ == "__main__":
    raise SystemExit(main())
