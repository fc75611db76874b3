"""Compile the boards' millisecond before somebody waits for it.

    python -m firmware_sim.boards.warm

Numba keeps what it compiled on disk; without this the first process to run a board compiles it.
"""

from firmware_sim.boards.bll import Bll
from firmware_sim.boards.modes import CALIB_HARD_STOP, POSITION
from firmware_sim.description import BoardSpec


def warm() -> None:
    """Run everything that is compiled once: every function that Python calls, on a board."""
    board = Bll(BoardSpec(bus=0, address=1, type="bll", firmware=(2, 0x50)))
    axis = board.axes[0]
    axis.enter(POSITION)
    axis.reference.advance()
    board.tick()
    axis.enter(CALIB_HARD_STOP)
    board.tick()
    axis.port.current_ma = 2 * axis.current_limit_ma
    board.tick()
    axis.idle()
    axis.fault()


if __name__ == "__main__":
    warm()
