"""Every process of the stack, one row each: what `ulna up` and docker-compose.yml start.

The rows' order is the order in which things happen at one instant of virtual time.
"""

from dataclasses import dataclass

DEFAULT_ROBOT = "icub:reach"
"""The limbs that the main job moves; `icub` is the whole robot."""


@dataclass(frozen=True, slots=True)
class Process:
    """One row."""

    name: str
    module: str
    fifo_priority: int = 0  # SCHED_FIFO where permitted; 0 = ordinary scheduling
    nice: int = 0  # where SCHED_FIFO is not asked for or not permitted
    emulated_only: bool = False  # stands in for hardware: not started on a real robot
    reaches: bool = False  # needs a limb that reaches
    feels: bool = False  # needs a force/torque sensor
    on_can: bool = False  # keeps real time on the buses: started when the others have loaded


HUB = Process("hub", "services.hub", fifo_priority=55)

PROCESSES = (
    HUB,
    Process("boards", "services.boards", fifo_priority=50, emulated_only=True, on_can=True),
    Process("robot", "services.robot", fifo_priority=50, on_can=True),
    Process("guard", "services.guard", fifo_priority=45, on_can=True),
    Process("dynamics", "services.dynamics", fifo_priority=48, feels=True),
    Process("learner", "services.learner", nice=5, feels=True),
    # Not niced: the field stood still for 0.7 s beside others on two cores. Nor before others: then
    # whoever tells the field of objects (a camera's process, a client) stands still for as long.
    Process("ik", "services.ik", reaches=True),
    Process("cartesian", "services.cartesian", reaches=True),
    Process("field", "services.field", reaches=True),
)

STAGES = 3


def stage_of(row: Process) -> int:
    """When a process is started; each stage waits until the one before is at work.

    The loops on the buses come when the others have loaded: on a small machine they would leave no
    time for it. Emulated boards are powered up before the host looks for them, as real ones are.
    """
    if not row.on_can:
        return 0
    return 1 if row.emulated_only else 2


def process_row(name: str) -> Process:
    """The row of that name; ordinary scheduling for one that is not in the table (tests, tools)."""
    for row in PROCESSES:
        if row.name == name:
            return row
    return Process(name, "")
