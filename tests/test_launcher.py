"""./ulna with a stand-in for the environment: no network, no installation."""

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from services.cli.setup.environment import stamp_file, wanted_stamp

ROOT = Path(__file__).resolve().parents[1]
COMMAND = '#!/bin/sh\necho "$PYTHONPATH|$PYTHONSAFEPATH|$#|$*"\n'


@pytest.fixture
def checkout(tmp_path: Path) -> Path:
    """A checkout whose .venv is finished; its command prints what it was given."""
    root = tmp_path / "a checkout"
    root.mkdir()
    for name in ("ulna", "pyproject.toml", "requirements.lock", "requirements-dev.lock"):
        shutil.copy(ROOT / name, root / name)
    shutil.copytree(ROOT / "services", root / "services")
    programs = root / ".venv" / "bin"
    programs.mkdir(parents=True)
    (programs / "python").symlink_to(sys.executable)
    (programs / "ulna").write_text(COMMAND)
    (programs / "ulna").chmod(0o755)
    stamp_file(root, "runtime").write_text(wanted_stamp(root, "runtime"))
    return root


def run(command: list[str | Path], folder: Path, path: str | None = None) -> tuple[int, str, str]:
    environment = {"PATH": path or os.environ["PATH"], "PYTHONPATH": "/elsewhere"}
    done = subprocess.run(command, cwd=folder, env=environment, capture_output=True, text=True)
    return done.returncode, done.stdout, done.stderr


def folder_with(tmp_path: Path, programs: dict[str, str]) -> str:
    """A search path with the few system programs that the launcher uses, and these scripts."""
    folder = tmp_path / "path"
    folder.mkdir()
    for name in ("sh", "cat", "dirname", "readlink", "sha256sum"):
        (folder / name).symlink_to(str(shutil.which(name)))
    for name, text in programs.items():
        (folder / name).write_text(text)
        (folder / name).chmod(0o755)
    return str(folder)


def test_passes_its_arguments_on_from_any_folder(checkout: Path, tmp_path: Path) -> None:
    status, out, err = run([checkout / "ulna", "demo", "two words"], tmp_path)
    assert (status, err) == (0, "")
    assert out == f"{checkout}:/elsewhere|1|2|demo two words\n"


def test_works_through_a_symbolic_link(checkout: Path, tmp_path: Path) -> None:
    (tmp_path / "link").symlink_to(checkout / "ulna")
    status, out, _ = run(["./link"], tmp_path)
    assert (status, out) == (0, f"{checkout}:/elsewhere|1|0|\n")


def test_says_when_there_is_no_python(checkout: Path, tmp_path: Path) -> None:
    stamp_file(checkout, "runtime").unlink()
    status, out, err = run([checkout / "ulna"], tmp_path, folder_with(tmp_path, {}))
    assert (status, out) == (1, "")
    assert err == (
        "ulna: Python 3.11, 3.12 or 3.13 is needed and was not found"
        " (Debian 12: apt-get install python3)\n"
    )


@pytest.mark.parametrize("changed", ["requirements.lock", "pyproject.toml"])
def test_sets_up_again_when_the_lock_changes(checkout: Path, tmp_path: Path, changed: str) -> None:
    with (checkout / changed).open("a") as file:
        file.write("# another line\n")
    python = '#!/bin/sh\n[ "$1" = -c ] || echo "set-up: $*"\n'
    path = folder_with(tmp_path, {"python3.11": python})
    status, out, _ = run([checkout / "ulna", "up"], tmp_path, path)
    assert status == 0
    assert out.splitlines() == [
        f"set-up: -B -m services.cli.setup.environment {checkout} runtime",
        f"{checkout}:/elsewhere|1|1|up",
    ]


def test_stops_when_the_set_up_fails(checkout: Path, tmp_path: Path) -> None:
    stamp_file(checkout, "runtime").unlink()
    python = '#!/bin/sh\n[ "$1" = -c ] || exit 1\n'
    path = folder_with(tmp_path, {"python3.11": python})
    assert run([checkout / "ulna", "up"], tmp_path, path) == (1, "", "")


def test_the_set_up_needs_nothing_installed() -> None:
    code = "import services.cli.setup.environment"
    command = [sys.executable, "-S", "-P", "-W", "error", "-c", code]
    environment = {"PATH": os.environ["PATH"], "PYTHONPATH": str(ROOT)}
    subprocess.run(command, env=environment, check=True)
