"""Contacts: detection on the real recording, location without skin, and what a location costs.

python -m benchmarks.dynamics_contacts [--data icubdyn.tgz] [--json FILE]
"""

import argparse
from collections.abc import Callable
from pathlib import Path

import numpy as np

from benchmarks.contact_detection import detection_rows
from benchmarks.contact_location import ARM, SEED, Scene, location_rows
from dforc.contacts.location import locate
from services.config import load_robot
from services.core.clock import RealClock
from services.experiments.rows import Row, publish
from services.robotfile.model_file import urdf_path
from services.robotfile.shape_tables import link_shapes

CALLS = 200
ROUNDS = 9


def rows(data: Path | None = None) -> list[Row]:
    """All figures; a recording that is not there is a row that says so."""
    return [*detection_rows(data), *location_rows(), *cost_rows()]


def cost_rows() -> list[Row]:
    """One location on the right arm, capsules posed by then, beside an empty call."""
    robot = load_robot("icub")
    shapes = link_shapes(robot).only(ARM.links)
    scene = Scene(urdf_path(robot.robot.urdf), ARM)
    (push,) = scene.contacts(1, np.random.default_rng(SEED))
    order = [ARM.links.index(link) for link in shapes.links]
    posed = shapes.posed(push.rotations[order], push.positions_m[order])
    moment = np.cross(push.point_m - push.sensor_m, push.force_n)
    empty, full = [], []
    for _ in range(ROUNDS):
        empty.append(_per_call_us(lambda: None))
        full.append(_per_call_us(lambda: locate(push.force_n, moment, push.sensor_m, posed)))
    return [
        Row("location, one call", float(np.median(full)), "us"),
        Row("location, an empty call beside it", float(np.median(empty)), "us"),
    ]


def _per_call_us(call: Callable[[], object]) -> float:
    clock = RealClock()
    start_ns = clock.now_ns()
    for _ in range(CALLS):
        call()
    return (clock.now_ns() - start_ns) * 1e-3 / CALLS


def main() -> int:
    """Print the table; 0 when every bar holds."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--data", type=Path, help="the archive icubdyn.tgz")
    parser.add_argument("--json", type=Path, help="also write the rows there")
    options = parser.parse_args()
    return publish("Contacts", rows(options.data), options.json)


if __name__ == "__main__":
    raise SystemExit(main())
