"""Gives pip to a virtual environment whose Python came without it, as Debian's does.

Debian splits ensurepip off into the package python3-venv. Installing needs root; *fetching* the
packages that hold pip and the certificates needs nobody: they go into a scratch folder and are
unpacked from there. apt checks their signatures. Standard library only: ./ulna runs this before
anything is installed.
"""

import os
import subprocess
import tempfile
import zipfile
from pathlib import Path

PACKAGES = ("python3-pip-whl", "ca-certificates")
SYSTEM_CERTIFICATES = Path("/etc/ssl/certs/ca-certificates.crt")
REMEDY = "install it once (Debian: apt-get install python3-venv) and start again"


class BootstrapError(Exception):
    """pip could not be had; the text says what to do."""


def place_pip(venv: Path) -> None:
    """Put pip, and certificates where the system has none, into a fresh virtual environment.

    Raises:
        BootstrapError: apt is missing, or cannot reach its archive.
    """
    with tempfile.TemporaryDirectory(prefix="ulna-pip-") as scratch_name:
        scratch = Path(scratch_name)
        try:
            _fetch(scratch)
            for archive in scratch.glob("*.deb"):
                _run(["dpkg-deb", "-x", archive.name, "unpacked"], scratch)
        except (OSError, subprocess.CalledProcessError) as error:
            raise BootstrapError(f"this Python's venv module lacks ensurepip; {REMEDY}") from error
        unpacked = scratch / "unpacked"
        wheels = sorted(unpacked.glob("usr/share/python-wheels/pip-*.whl"))
        if not wheels:
            raise BootstrapError(f"{PACKAGES[0]} holds no pip; {REMEDY}")
        site_packages = _unzip(wheels[-1], venv)
        if not has_system_certificates():
            authorities = sorted(unpacked.glob("usr/share/ca-certificates/**/*.crt"))
            bundle = venv / "ca-certificates.crt"
            bundle.write_text("\n".join(path.read_text() for path in authorities))
            _point_pip_at(bundle, site_packages)


def has_system_certificates() -> bool:
    """Whether the file that Debian's pip reads is there (package ca-certificates)."""
    return SYSTEM_CERTIFICATES.is_file()


def _fetch(scratch: Path) -> None:
    """Download the packages; where the system's package lists are empty, with lists of our own."""
    download = ["apt-get", "-qq", *_options(scratch, {}), "download", *PACKAGES]
    try:
        _run(download, scratch)
    except subprocess.CalledProcessError:
        (scratch / "lists" / "partial").mkdir(parents=True)
        (scratch / "archives" / "partial").mkdir(parents=True)
        own = _options(scratch, {"Dir::State::lists": "lists", "Dir::Cache": "."})
        _run(["apt-get", "-qq", *own, "update"], scratch)
        _run(["apt-get", "-qq", *own, "download", *PACKAGES], scratch)


def _options(scratch: Path, folders: dict[str, str]) -> list[str]:
    pairs = {key: f"{scratch}/{value}" for key, value in folders.items()}
    # The scratch folder is private to this user, which apt's own download user could not enter.
    pairs |= {"APT::Sandbox::User": "root", "Acquire::Languages": "none"}
    return [item for key, value in pairs.items() for item in ("-o", f"{key}={value}")]


def _run(command: list[str], folder: Path) -> None:
    environment = {**os.environ, "LC_ALL": "C"}
    subprocess.run(command, cwd=folder, env=environment, check=True, capture_output=True)


def _unzip(wheel: Path, venv: Path) -> Path:
    """A wheel without scripts is ready for `python -m pip` as soon as it is unpacked."""
    (site_packages,) = venv.glob("lib/python3*/site-packages")
    with zipfile.ZipFile(wheel) as archive:
        archive.extractall(site_packages)
    return site_packages


def _point_pip_at(bundle: Path, site_packages: Path) -> None:
    """Debian's pip reads the system's certificates when it is imported; here are ours instead."""
    source = site_packages / "pip" / "_vendor" / "certifi" / "core.py"
    text = source.read_text(encoding="utf-8")
    source.write_text(text.replace(str(SYSTEM_CERTIFICATES), str(bundle)), encoding="utf-8")
