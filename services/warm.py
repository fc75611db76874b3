"""Compile the emulated robot's inner loop before somebody waits for it: python -m services.warm.

Numba keeps on disk what it has compiled, so this takes seconds once and nothing afterwards.
"""

from firmware_sim.boards.warm import warm
from firmware_sim.rig import Rig
from services.config import load_robot
from services.emulation import rig_spec
from services.processes import DEFAULT_ROBOT


def main() -> int:
    """Run everything that is compiled: every door of the boards, and the plant."""
    warm()
    Rig(rig_spec(load_robot(DEFAULT_ROBOT), seed=0)).step({})
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
