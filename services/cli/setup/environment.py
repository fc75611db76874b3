"""Makes .venv from a lock file, or brings it up to date, for ./ulna and ./check.

Usage   python -m services.cli.setup.environment ROOT runtime|dev|peers
It runs before anything is installed: only the standard library and services/core/clock.py may be
imported here.

A stamp file in .venv, written last, says what is installed. No stamp means that an earlier set-up
was cut short: the folder is then made anew. One set-up at a time works on a checkout (flock); the
others wait and find the work done.
"""

import fcntl
import hashlib
import os
import platform
import shutil
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from importlib.util import find_spec
from pathlib import Path

from services.cli.setup.openmp import lend_openmp
from services.cli.setup.pip_output import PipOutput, explain
from services.cli.setup.pip_wheel import BootstrapError, place_pip
from services.core.clock import NS_PER_S, wall_ns

LOCKS = {
    "runtime": "requirements.lock",
    "dev": "requirements-dev.lock",
    "peers": "requirements-peers.lock",
}
# Each lock contains the ones before it; the peers are put on top of a finished dev environment.
CONTAINS = {"runtime": ("runtime",), "dev": ("runtime", "dev"), "peers": ("peers",)}
SIZES = {"runtime": "0.4 GB", "dev": "0.4 GB", "peers": "50 MB"}
# Compiling every module ahead would take longer than the few that are imported take on first use.
INSTALL = ("install", "--require-hashes", "--no-compile", "--progress-bar", "off", "--retries", "2")


class EnvironmentSetupError(Exception):
    """The environment cannot be made; the text is the one sentence that a user needs."""


def wanted_stamp(root: Path, kind: str) -> str:
    """What a finished .venv is stamped with; ./ulna computes the same with sha256sum."""
    content = (root / LOCKS[kind]).read_bytes() + (root / "pyproject.toml").read_bytes()
    return hashlib.sha256(content + os.fsencode(root)).hexdigest()


def stamp_file(root: Path, kind: str) -> Path:
    """The file that ./ulna compares at every start."""
    return root / ".venv" / f"ulna-{kind}.stamp"


def is_current(root: Path, kind: str) -> bool:
    """Whether .venv already holds exactly what the lock says."""
    stamp = stamp_file(root, kind)
    return stamp.is_file() and stamp.read_text() == wanted_stamp(root, kind)


def ensure(root: Path, kind: str) -> None:
    """Make the environment match the lock.

    Raises:
        EnvironmentSetupError: it cannot be done, with the reason and the remedy.
    """
    with _only_one(root) as turn:
        if is_current(root, kind):
            return
        if kind != "peers":
            _make(root, kind, turn)
            return
        if not is_current(root, "dev"):
            _make(root, "dev", turn)
        _finish(root, kind, wall_ns(), _install_lock(root, kind, turn))


def _make(root: Path, kind: str, turn: int) -> None:
    start_ns = wall_ns()
    _prepare_folder(root, kind)
    for each in LOCKS:
        stamp_file(root, each).unlink(missing_ok=True)
    output = _install_lock(root, kind, turn)
    lend_openmp(root / ".venv")
    _install_project(root)
    _compile(root)
    _finish(root, kind, start_ns, output)


def _finish(root: Path, kind: str, start_ns: int, output: PipOutput) -> None:
    for each in CONTAINS[kind]:
        stamp_file(root, each).write_text(wanted_stamp(root, each))
    say(f"set up in {(wall_ns() - start_ns) / NS_PER_S:.0f} s: {output.summary()}")


def say(text: str) -> None:
    """One line of progress, on stderr: stdout belongs to the command that follows."""
    print(f"ulna: {text}", file=sys.stderr, flush=True)


@contextmanager
def _only_one(root: Path) -> Iterator[int]:
    """Wait for this checkout's turn; gives the descriptor whose lock it is."""
    try:
        file = (root / ".venv.lock").open("w")
    except OSError as error:
        raise EnvironmentSetupError(f"cannot write in {root}: {error.strerror}") from error
    with file:
        try:
            fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            say("another set-up of this checkout is running; waiting for it")
            fcntl.flock(file, fcntl.LOCK_EX)
        yield file.fileno()


def _prepare_folder(root: Path, kind: str) -> None:
    folder = root / ".venv"
    finished_before = any(stamp_file(root, each).is_file() for each in LOCKS)
    if finished_before and _runs(folder / "bin" / "python"):
        say(f"bringing .venv up to date with {LOCKS[kind]}")
        return
    say(f"making .venv with Python {platform.python_version()} from {LOCKS[kind]} (first use only)")
    try:
        shutil.rmtree(folder, ignore_errors=True)
        _make_venv(folder)
    except BootstrapError as error:
        raise EnvironmentSetupError(str(error)) from error
    except (OSError, subprocess.CalledProcessError) as error:
        raise EnvironmentSetupError(f"cannot make {folder}: {error}") from error


def _make_venv(folder: Path) -> None:
    import venv  # here, so that a Python without it still reaches the sentence of main()

    has_ensurepip = find_spec("ensurepip") is not None  # Debian keeps it in a package of its own
    venv.EnvBuilder(with_pip=has_ensurepip, symlinks=True, clear=True).create(folder)
    if not has_ensurepip:
        say("this Python has no ensurepip; fetching pip with apt-get (the system stays as it is)")
        place_pip(folder)


def _runs(python: Path) -> bool:
    try:
        return subprocess.run([python, "-c", "import pip"], capture_output=True).returncode == 0
    except OSError:
        return False


def _install_lock(root: Path, kind: str, turn: int) -> PipOutput:
    lock = root / LOCKS[kind]
    packages = _pins(lock)
    if kind == "peers":
        packages -= _pins(root / LOCKS["dev"])
    say(
        f"fetching {packages} packages, {SIZES[kind]} unless they are here already; the large ones:"
    )
    output = PipOutput(say)
    log_path = root / ".venv" / "setup.log"
    command = [*_pip(root), *INSTALL, "-r", str(lock)]
    with (
        log_path.open("w") as log,
        subprocess.Popen(
            command,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
            errors="replace",
            env=_pip_environment(),
            pass_fds=(turn,),  # a pip that outlives us still keeps the others waiting
        ) as process,
    ):
        assert process.stdout is not None
        for line in process.stdout:
            log.write(line)
            output.feed(line)
    if process.returncode != 0:
        raise EnvironmentSetupError(explain(output.tail, log_path))
    return output


def _pins(lock: Path) -> int:
    return sum("==" in line for line in lock.read_text().splitlines())


def _install_project(root: Path) -> None:
    """Install the checkout itself, editable: the command, and the python-can plug-in."""
    done = subprocess.run(
        [
            *_pip(root),
            "install",
            "-q",
            "--no-deps",
            "--no-build-isolation",
            "--no-index",
            "-e",
            str(root),
        ],
        capture_output=True,
        text=True,
        env=_pip_environment(),
    )
    if done.returncode != 0:
        raise EnvironmentSetupError(
            f"cannot install the checkout into .venv: {done.stderr.strip()[-600:]}"
        )


def _compile(root: Path) -> None:
    """Compile the inner loops ahead; what does not work here, works at the first use."""
    say("compiling inner loops: boards, dynamics, reaching, fields (once; a minute or two)")
    python = root / ".venv" / "bin" / "python"
    done = subprocess.run(
        [str(python), "-m", "services.warm"],
        cwd=root,
        capture_output=True,
        text=True,
        env=_pip_environment(),
    )
    if done.returncode != 0:
        say(f"it could not be compiled ahead: {done.stderr.strip()[-300:]}")


def _pip(root: Path) -> tuple[str, ...]:
    python = root / ".venv" / "bin" / "python"
    return (str(python), "-m", "pip", "--disable-pip-version-check", "--no-input")


def _pip_environment() -> dict[str, str]:
    """The user's own pip settings, less what would put the packages elsewhere."""
    dropped = ("PYTHONPATH", "PYTHONHOME", "PIP_TARGET", "PIP_PREFIX", "PIP_NO_BINARY")
    environment = {key: value for key, value in os.environ.items() if key not in dropped}
    environment["PIP_USER"] = "0"
    return environment


def main(arguments: list[str]) -> int:
    """Entry point; exit status 0 when .venv is ready."""
    root, kind = Path(arguments[0]), arguments[1]
    if find_spec("venv") is None:
        say(f"{sys.executable} has no venv module (Debian: apt-get install python3-venv)")
        return 1
    try:
        ensure(root, kind)
    except EnvironmentSetupError as failure:
        say(str(failure))
        return 1
    except KeyboardInterrupt:
        say("set-up interrupted; the next start begins it again")
        return 130
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
