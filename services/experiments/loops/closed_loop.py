"""The closed loops on the boards, on the whole robot in virtual time, over its CAN frames.

Torque steps, stiffness under pushes, hand guiding, and velocity on top of impedance.
"""

from contextlib import closing
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path

from rich.console import Console

from services.config import load_robot
from services.emulated.simulation import Progress, Simulation
from services.experiments.loops.expected import Expected, expected
from services.experiments.loops.guiding import DRIFT_S, Guiding, guiding
from services.experiments.loops.impedance import Deflection, pushes
from services.experiments.loops.limbs import limbs
from services.experiments.loops.plot import draw
from services.experiments.loops.rows import deflection_rows, guiding_rows, step_rows, turn_rows
from services.experiments.loops.torque import TorqueStep, torque_steps
from services.experiments.loops.trial import LoopTrial, Trial
from services.experiments.loops.velocity import Turn, turns
from services.experiments.loops.world import World
from services.experiments.reporting import tell_motion, working
from services.experiments.rows import Row, at_most, publish
from services.robotfile.robot_tables import RobotFile

WHOLE_ROBOT = "icub"
TRIALS = ("torque", "impedance", "guiding", "velocity")
ROUNDS, SHORT_ROUNDS = 6, 2
SHORT_DRIFT_S = 1.0
LONGEST_TICKS = 300_000


@dataclass(slots=True, kw_only=True)
class Found:
    """What all trials of one run gave."""

    steps: list[TorqueStep] = field(default_factory=list)
    deflections: list[Deflection] = field(default_factory=list)
    guidings: list[Guiding] = field(default_factory=list)
    turns: list[Turn] = field(default_factory=list)
    expected: Expected = field(default_factory=Expected)
    limit_violations: int = 0
    board_faults: int = 0
    frames_lost: int = 0
    virtual_s: float = 0.0
    failure: str = ""

    def add(self, other: "Found") -> None:
        """What another run gave beside it."""
        self.steps += other.steps
        self.deflections += other.deflections
        self.guidings += other.guidings
        self.turns += other.turns
        self.expected.add(other.expected)
        self.limit_violations += other.limit_violations
        self.board_faults += other.board_faults
        self.frames_lost += other.frames_lost
        self.virtual_s += other.virtual_s
        self.failure = self.failure or other.failure

    def rows(self) -> list[Row]:
        """Every figure, with its bar."""
        carried = self.failure or "yes"
        return [
            Row("trials carried through", carried, "", "yes", not self.failure),
            *step_rows(self.steps, self.expected.steps),
            *deflection_rows(self.deflections, self.expected.pushes),
            *guiding_rows(self.guidings, self.expected.guidings),
            *turn_rows(self.turns, self.expected.turns),
            at_most("limit violations", self.limit_violations, "", 0),
            at_most("faults of the boards", self.board_faults, "", 0),
            at_most("frames lost", self.frames_lost, "", 0),
        ]


def closed_loop(
    *,
    robot: str = WHOLE_ROBOT,
    seed: int = 0,
    short: bool = False,
    json: Path | None = None,
    plot: Path = Path("closed-loop.png"),
) -> int:
    """Run all trials, draw the figure, and return 0 when every bar holds."""
    robot_file = load_robot(robot)
    console = Console()
    with working(console, "closed loops of the emulated robot") as tell:
        found = run(robot_file, seed, short=short, progress=partial(tell_motion, tell, seed))
    draw(found.steps, found.deflections, found.guidings, found.turns, plot)
    status = publish(f"closed loops, {robot}, plant {seed}", found.rows(), json)
    console.print(f"plot: {plot}")
    return status


def run(
    robot: RobotFile,
    seed: int,
    trials: tuple[str, ...] = TRIALS,
    *,
    short: bool = False,
    progress: Progress | None = None,
) -> Found:
    """All trials on one emulated robot; `progress` is told the virtual seconds and what happens.

    What was found before a trial failed is kept, beside the reason.
    """
    found, world = Found(), World()
    rounds, only = (SHORT_ROUNDS, 1) if short else (ROUNDS, None)
    found.expected = expected(limbs(robot), trials, rounds=rounds, only=only)
    guest = LoopTrial(robot, world, _trials(found, trials, short=short))
    with closing(Simulation(robot, seed, guests={"closed_loop": guest})) as simulation:
        world.surround(simulation.rig)
        simulation.run(guest, progress, LONGEST_TICKS, after_tick=world.tick)
        found.limit_violations = simulation.rig.limit_violations
        found.board_faults = simulation.rig.board_faults
        found.frames_lost = guest.frames_lost
        found.virtual_s = simulation.executor.ticks * 1e-3
    found.failure = guest.failure or ("" if guest.finished else f"no end of: {guest.progress}")
    return found


def _trials(found: Found, names: tuple[str, ...], *, short: bool) -> list[Trial]:
    scripts: dict[str, Trial] = {
        "torque": partial(torque_steps, found=found.steps, only=1 if short else None),
        "impedance": partial(
            pushes, found=found.deflections, rounds=SHORT_ROUNDS if short else ROUNDS
        ),
        "guiding": partial(
            guiding, found=found.guidings, drift_s=SHORT_DRIFT_S if short else DRIFT_S
        ),
        "velocity": partial(turns, found=found.turns),
    }
    return [scripts[name] for name in names]
