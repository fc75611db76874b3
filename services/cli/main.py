"""The command `ulna`: one verb per file in this folder."""

import os
import sys
import tomllib
from importlib import import_module, metadata
from pathlib import Path

import cyclopts

from services.cli import experiment as experiments
from services.cli.complaint import complain
from services.core.errors import ProcessDiedError, ServiceError

PACKAGES = ("services", "hal", "dforc", "firmware_sim")
USAGE_ERROR = 2
# Linear algebra on one thread, as ./ulna has it: small matrices are slower on many.
ONE_THREAD = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS")
UP = """Start the stack, watch it, and stop it with Ctrl-C.

Ctrl-C brings the limbs down and idles them; a second one idles them at once.
"""

app = cyclopts.App(
    name="ulna",
    help="Control stack for torque-sensing humanoids: emulated or real boards, CAN, services.",
    version=lambda: version(),  # looked up when it is asked for
    version_flags=["--version"],
    # An option of several values needs no second one that empties it.
    default_parameter=cyclopts.Parameter(negative_iterable=()),
)
demo = cyclopts.App(name="demo", help="What the whole stack does, shown.")
can = cyclopts.App(name="can", help="CAN buses of this machine.")
dynamics = cyclopts.App(name="dynamics", help="Torques and contacts from force/torque sensors.")
learner = cyclopts.App(name="learner", help="What is learned beyond the rigid-body model.")
ik = cyclopts.App(name="ik", help="Postures for poses of the hands.")
cartesian = cyclopts.App(name="cartesian", help="Hands that go to poses.")
field = cyclopts.App(name="field", help="Force fields: goals, obstacles, modes, gains.")
objects = cyclopts.App(name="objects", help="What is in the world, for the field.")
field.command(objects)
joints = cyclopts.App(name="joints", help="Calibrate, move and park joints; what they do now.")
board = cyclopts.App(name="board", help="Emulated boards, one by one.")
experiment = cyclopts.App(name="experiment", help="Figures and tables of the papers, made again.")
GROUPS = (demo, experiment, can, board, joints, ik, cartesian, field, dynamics, learner)
for group in GROUPS:
    app.command(group)
# By name, so that a verb loads its own modules only: solver and compiler take a second.
board.command("services.cli.board:board_run", name="run")
board.command("services.cli.board:board_list", name="list")
board.command("services.cli.fault:board_fault", name="fault")
board.command("services.cli.fault:board_faults", name="faults")
for request in ("status", "calibrate", "home", "direct", "compliant", "stiff", "park"):
    joints.command(f"services.cli.joints:joints_{request}", name=request)
for request in ("ask", "status"):
    ik.command(f"services.cli.ik:ik_{request}", name=request)
for request in ("status", "go", "position", "stop", "ask", "info"):
    cartesian.command(f"services.cli.cartesian:cartesian_{request}", name=request)
for request in ("status", "mode", "set", "info", "goal", "stop"):
    field.command(f"services.cli.field:field_{request}", name=request)
field.command("services.cli.field_preview:field_preview", name="preview")
for request in ("list", "add", "move", "remove"):
    objects.command(f"services.cli.field_objects:objects_{request}", name=request)
for request in ("status", "calibrate", "reset", "assume", "source", "identify"):
    dynamics.command(f"services.cli.dynamics:dynamics_{request}", name=request)
for request in ("status", "save", "restore", "reset", "freeze", "resume"):
    learner.command(f"services.cli.learner:learner_{request}", name=request)
app.command("services.cli.up:up", name="up", help=UP)
demo.command("services.cli.demo:reach", name="reach")
for verb in experiments.VERBS:  # they load what they need when they run
    experiment.command(verb)
can.command("services.cli.can_up:can_up", name="up")
can.command("services.cli.can_scan:can_scan", name="scan")
can.command("services.cli.can_dump:can_dump", name="dump")
can.command("services.cli.can_send:can_send", name="send")
can.command("services.cli.can_stats:can_stats", name="stats")
can.command("services.cli.can_log:can_log", name="log")
can.command("services.cli.can_log:can_replay", name="replay")
can.command("services.cli.can_dbc:can_dbc", name="dbc")
can.command("services.cli.can_dbc:can_docs", name="docs")


def version() -> str:
    """Of the installed distribution, or of the checkout that runs without being installed."""
    try:
        return metadata.version("ulna")
    except metadata.PackageNotFoundError:
        project = Path(__file__).resolve().parents[2] / "pyproject.toml"
        return str(tomllib.loads(project.read_text(encoding="utf-8"))["project"]["version"])


def check_one_home() -> None:
    """Refuse to run with somebody else's package in the place of one of ours.

    Raises:
        ServiceError: the four packages do not share one parent folder.
    """
    homes = {name: Path(str(import_module(name).__file__)).parent.parent for name in PACKAGES}
    expected = homes["services"]
    for name, home in homes.items():
        if home != expected:
            raise ServiceError(
                f"package {name!r} comes from {home}, expected {expected}; "
                "use a clean virtual environment"
            )


def describe(arguments: list[str]) -> None:
    """Load the verbs of the group whose list is asked for: each describes itself."""
    names = [word for word in arguments if word not in {"-h", "--help"}]
    paths = [(group, [*group.name]) for group in GROUPS] + [(objects, ["field", "objects"])]
    for group, path in paths:
        if names == path:
            for verb in list(group):
                group[verb]


def main(arguments: list[str] | None = None) -> int:
    """Run one command line; errors that a user can mend are one sentence, never a traceback."""
    for setting in ONE_THREAD:  # read once, when numpy is imported: not yet, verbs are by name
        os.environ.setdefault(setting, "1")
    try:
        check_one_home()
        describe(sys.argv[1:] if arguments is None else arguments)
        status = app(arguments, result_action="return_value")
    except ServiceError as error:
        complain(error)
        if isinstance(error, ProcessDiedError) and error.log_tail:
            print(error.log_tail, file=sys.stderr)
        return USAGE_ERROR
    return status if isinstance(status, int) else 0


if __name__ == "__main__":
    raise SystemExit(main())
