"""Compile the inner loops before somebody waits for them: python -m services.warm.

Numba keeps on disk what it has compiled, so this takes seconds once and nothing afterwards.
"""

from firmware_sim.boards.warm import warm
from firmware_sim.rig import Rig
from services.cartesian import Cartesian
from services.config import load_robot
from services.dynamics import Dynamics
from services.emulated.emulation import rig_spec
from services.field import Field
from services.ik import Ik
from services.processes import DEFAULT_ROBOT


def main() -> int:
    """Run everything that is compiled: doors of the boards, plant, dynamics, reaching."""
    warm()
    robot = load_robot(DEFAULT_ROBOT)
    Rig(rig_spec(robot, seed=0)).step({})
    Dynamics(robot)
    Ik(robot)
    Cartesian(robot)
    Field(robot).warm()
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
