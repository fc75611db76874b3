"""Every figure of the Cartesian controller, with its bar; both laws side by side.

    python -m benchmarks.cartesian [--json FILE] [--short] [--moves N] [--seed N] [--no-boards]

On the iCub's right arm with the torso (10 joints): random moves on an ideal arm and on one with
60 ms of lag and 20 ms of delay, moving targets, changes in motion, both hands at once, and what a
tick costs; then random reaches of both arms through boards and CAN.
"""

import argparse
import sys
from pathlib import Path

from benchmarks.cartesian_both import both_hands_rows
from benchmarks.cartesian_changes import change_rows
from benchmarks.cartesian_moves import gamma_rows, move_rows, random_moves, robot_speed_rows
from benchmarks.cartesian_streams import law_rows, stream_rows, tick_rows
from services.config import load_robot
from services.experiments.cartesian.arm import Arm
from services.experiments.cartesian.boards import board_rows
from services.experiments.rows import Row, publish

ROBOT = "icub:arms"
MOVES, SHORT_MOVES = 100, 20


def main() -> int:
    """Run what was asked for."""
    parser = argparse.ArgumentParser(description=str(__doc__).partition("\n")[0])
    parser.add_argument("--json", type=Path, default=None)
    parser.add_argument("--short", action="store_true", help="fewer moves and reaches")
    parser.add_argument("--moves", type=int, default=None)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--no-boards", action="store_true", help="nothing through boards and CAN")
    arguments = parser.parse_args()
    count = arguments.moves or (SHORT_MOVES if arguments.short else MOVES)
    robot = load_robot(ROBOT)
    arm = Arm(robot, "right_arm", torso=True)
    say(f"seed {arguments.seed}: {count} moves of the right arm with the torso ...")
    moves = random_moves(arm, count, arguments.seed)
    few = moves[: max(10, count // 5)]
    rows: list[Row] = law_rows(arm)
    rows += move_rows(arm, moves)
    say("any gamma, the robot's speeds ...")
    rows += gamma_rows(arm, few)
    rows += robot_speed_rows(arm, few)
    say("moving targets, changes in motion ...")
    rows += stream_rows(arm)
    rows += change_rows(arm, moves[: max(10, count // 2)], arguments.seed)
    say("both hands, time of a tick ...")
    rows += both_hands_rows(robot, max(5, count // 5), arguments.seed)
    rows += tick_rows(arm, few)
    if not arguments.no_boards:
        say("through boards and CAN ...")
        rows += board_rows(short=arguments.short, seed=arguments.seed)
    return publish("Cartesian controller", rows, arguments.json)


def say(what: str) -> None:
    """Tell how far it is."""
    print(what, file=sys.stderr, flush=True)


if __name__ == "__main__":
    raise SystemExit(main())
