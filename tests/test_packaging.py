"""What is packaged: four packages, the robot files, one command, and the locks they run on."""

import os
import re
import subprocess
import sys
import tomllib
import zipfile
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[1]
PACKAGES = {"services", "hal", "dforc", "firmware_sim"}


@pytest.fixture(scope="module")
def wheel(tmp_path_factory: pytest.TempPathFactory) -> zipfile.ZipFile:
    folder = tmp_path_factory.mktemp("wheel")
    command = [sys.executable, "-m", "hatchling", "build", "-t", "wheel", "-d", str(folder)]
    subprocess.run(command, cwd=ROOT, check=True, capture_output=True)
    (path,) = folder.glob("ulna-*.whl")
    return zipfile.ZipFile(path)


@pytest.fixture(scope="module")
def site(wheel: zipfile.ZipFile, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The wheel unpacked, as pip would."""
    folder = tmp_path_factory.mktemp("site")
    wheel.extractall(folder)
    return folder


@pytest.fixture(scope="module")
def project() -> dict[str, object]:
    return tomllib.loads((ROOT / "pyproject.toml").read_text())


def pins(lock: str) -> dict[str, tuple[str, frozenset[str]]]:
    """Package -> version with its marker, and hashes."""
    text = (ROOT / lock).read_text().replace("\\\n", " ")
    found = {}
    for line in text.splitlines():
        if match := re.match(r"([\w.-]+)==([^ ]+ *(?:;.*?)?) +--hash", line):
            hashes = frozenset(re.findall(r"--hash=sha256:([0-9a-f]{64})", line))
            found[match[1]] = (match[2], hashes)
    return found


def names(requirements: list[str]) -> set[str]:
    found = (re.match(r"[\w.-]+", text) for text in requirements)
    return {match[0].lower().replace("_", "-") for match in found if match}


def test_the_wheel_holds_exactly_the_four_packages(wheel: zipfile.ZipFile) -> None:
    roots = {name.split("/")[0] for name in wheel.namelist()}
    assert {root for root in roots if not root.endswith(".dist-info")} == PACKAGES


def test_the_wheel_holds_every_source_file(wheel: zipfile.ZipFile) -> None:
    sources = {
        str(path.relative_to(ROOT))
        for name in PACKAGES
        for path in (ROOT / name).rglob("*")
        if path.is_file() and "__pycache__" not in path.parts
    }
    assert sources - set(wheel.namelist()) == set()
    assert {f"{name}/py.typed" for name in PACKAGES} <= sources


def test_the_wheel_holds_the_robot_files(wheel: zipfile.ZipFile) -> None:
    packed = wheel.read("services/_robots/icub/robot.toml")
    assert packed == (ROOT / "robots" / "icub" / "robot.toml").read_bytes()


def test_the_wheel_declares_the_command_and_the_can_plug_in(wheel: zipfile.ZipFile) -> None:
    (name,) = (name for name in wheel.namelist() if name.endswith("entry_points.txt"))
    lines = wheel.read(name).decode().split("\n")
    assert "ulna = services.cli.main:main" in lines
    assert "ulna_zenoh = hal.buses.zenoh:ZenohBus" in lines


def on_the_wheel(site: Path, arguments: list[str], folder: Path) -> str:
    """Run this Python with the unpacked wheel in the place of the checkout."""
    done = subprocess.run(
        [sys.executable, "-P", *arguments],
        cwd=folder,
        env={**os.environ, "PYTHONPATH": str(site)},
        capture_output=True,
        text=True,
    )
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


def test_the_unpacked_wheel_reads_its_own_robot_file(site: Path, tmp_path: Path) -> None:
    code = (
        "from services.config import load_robot, robots_folder\n"
        "load_robot('icub')\n"
        "print(robots_folder())"
    )
    assert on_the_wheel(site, ["-c", code], tmp_path) == f"{site}/services/_robots\n"


@pytest.mark.slow
def test_the_tests_pass_on_the_unpacked_wheel(site: Path, tmp_path: Path) -> None:
    """A checkout hides files that the wheel lacks; config and HAL are what reads data files."""
    pytest_on_it = ["-m", "pytest", "-q", "-c", str(ROOT / "pyproject.toml"), "-o", "pythonpath="]
    no_cache = ["-p", "no:cacheprovider", "-p", "no:xdist"]
    tests = [str(ROOT / "tests" / "hal"), str(ROOT / "tests" / "services" / "test_config.py")]
    out = on_the_wheel(site, [*pytest_on_it, *no_cache, *tests], tmp_path)
    assert re.search(r"^\d+ passed", out.splitlines()[-1])


def test_the_dev_lock_contains_the_runtime_lock() -> None:
    runtime, dev = pins("requirements.lock"), pins("requirements-dev.lock")
    assert len(runtime) >= 40
    assert {name: pin for name, pin in runtime.items() if dev.get(name) != pin} == {}


def test_the_peers_lock_contains_the_dev_lock() -> None:
    dev, peers = pins("requirements-dev.lock"), pins("requirements-peers.lock")
    assert {name: pin for name, pin in dev.items() if peers.get(name) != pin} == {}


def test_every_pin_has_hashes() -> None:
    for lock in ("requirements.lock", "requirements-dev.lock", "requirements-peers.lock"):
        entries = pins(lock)
        assert len(entries) == len(re.findall(r"^\S+==", (ROOT / lock).read_text(), re.MULTILINE))
        assert all(hashes for _, hashes in entries.values())


def test_every_declared_dependency_is_locked(project: dict[str, dict[str, list[str]]]) -> None:
    groups = project["dependency-groups"]
    runtime = names([*project["project"]["dependencies"], *groups["build"]])
    dev = names([text for text in groups["dev"] if isinstance(text, str)])
    assert runtime - pins("requirements.lock").keys() == set()
    assert dev - pins("requirements-dev.lock").keys() == set()


def test_comparison_partners_are_in_a_lock_of_their_own(
    project: dict[str, dict[str, list[str]]],
) -> None:
    peers = names(project["dependency-groups"]["peers"])
    assert peers & pins("requirements-dev.lock").keys() == set()
    assert peers - pins("requirements-peers.lock").keys() == set()
