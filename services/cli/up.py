"""`ulna up`: start the processes of the stack, watch them, and bring them down in the safe way."""

import signal
from collections.abc import Callable
from typing import Annotated

import cyclopts

from hal.errors import HalError
from services.board_news import BoardNews
from services.cli.complaint import complain
from services.config import load_robot
from services.core.errors import ProcessDiedError, ServiceError
from services.processes import DEFAULT_ROBOT
from services.stack import Stack
from services.stack_choice import Can, choose_can, real_interfaces, rows_for
from services.streams import ROBOT_STATUS

StackName = Annotated[str, cyclopts.Parameter(alias="--name")]  # as it was called at first


def up(
    robot: str = DEFAULT_ROBOT, *, can: Can | None = None, seed: int = 0, stack: StackName = ""
) -> int:
    """Start the stack, watch it, and stop it with Ctrl-C.

    Ctrl-C brings the limbs down and idles them; a second one idles them at once.

    Args:
        robot: name[:parts][@site] of a robot in robots/, or a robot file.
        can: what carries the CAN frames; mixed is socketcan on the interfaces that are up and zenoh
            on the others [socketcan where all are up, mixed where real boards are on those that
            are, else zenoh].
        seed: of the emulated robot's random draws.
        stack: its name, by which the other verbs find it; tells stacks of one robot apart [the
            robot's].

    Returns:
        Exit status: 0 stopped by the user, 1 a process died, 2 could not start.
    """
    try:
        robot_file = load_robot(robot)
        interfaces = tuple(bus.channel for bus in robot_file.buses.values())
        chosen, reason = choose_can(can, interfaces, real_interfaces(robot_file))
        print(f"CAN over {chosen}: {reason}", flush=True)
        rows = rows_for(robot_file)
        running = Stack(robot, can=chosen, seed=seed, name=stack, rows=rows, report=_say)
        for number in (signal.SIGTERM, signal.SIGHUP):
            signal.signal(number, signal.default_int_handler)  # a stop like Ctrl-C
        with running:
            print(f"up, hub at {running.endpoint}; Ctrl-C stops", flush=True)
            running.wait(_board_news(running))
    except KeyboardInterrupt:
        print("stopped", flush=True)
        return 0
    except ProcessDiedError as error:
        complain(f"{error}; the end of its log:\n{error.log_tail}")
        return 1
    except (ServiceError, HalError) as error:
        complain(error)
        return 2
    return 0


def _board_news(stack: Stack) -> Callable[[], None]:
    """What prints a line when a board's state changes."""
    news = BoardNews()

    def look() -> None:
        for status in stack.client.new(ROBOT_STATUS):
            for line in news.lines(status):
                _say(line)

    return look


def _say(text: str) -> None:
    print(text, flush=True)
