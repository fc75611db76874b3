"""pip for a Python that came without it, from a stand-in for Debian's archive."""

import zipfile
from pathlib import Path

import pytest

from services.cli.setup import pip_wheel
from services.cli.setup.pip_wheel import BootstrapError, place_pip

# Knows no package before its own lists are fetched, as on a fresh machine.
APT_GET = """#!/bin/sh
case "$*" in
    *Dir::State::lists*update) touch updated ;;
    *download*) [ -e updated ] || exit 100; touch python3-pip-whl.deb ca-certificates.deb ;;
esac
"""
DPKG_DEB = """#!/bin/sh
mkdir -p "$3/usr/share"
cp -r "{archive}/." "$3/usr/share"
"""
CERTIFI = "CA_CERTS = '/etc/ssl/certs/ca-certificates.crt'\n"


@pytest.fixture
def venv(tmp_path: Path) -> Path:
    folder = tmp_path / "venv"
    (folder / "lib" / "python3.11" / "site-packages").mkdir(parents=True)
    return folder


@pytest.fixture
def programs(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A search path whose apt-get and dpkg-deb stand in for Debian's."""
    archive = tmp_path / "archive"
    (archive / "python-wheels").mkdir(parents=True)
    with zipfile.ZipFile(archive / "python-wheels" / "pip-23.0.1-py3-none-any.whl", "w") as wheel:
        wheel.writestr("pip/__main__.py", "")
        wheel.writestr("pip/_vendor/certifi/core.py", CERTIFI)
    certificates = archive / "ca-certificates" / "mozilla"
    certificates.mkdir(parents=True)
    for name in ("one", "two"):
        (certificates / f"{name}.crt").write_text(f"certificate {name}")
    folder = tmp_path / "programs"
    folder.mkdir()
    for name, text in {"apt-get": APT_GET, "dpkg-deb": DPKG_DEB.format(archive=archive)}.items():
        (folder / name).write_text(text)
        (folder / name).chmod(0o755)
    monkeypatch.setenv("PATH", f"{folder}:/usr/bin:/bin")
    return folder


def certifi(venv: Path) -> str:
    return (venv / "lib/python3.11/site-packages/pip/_vendor/certifi/core.py").read_text()


@pytest.mark.usefixtures("programs")
def test_unpacks_pip_with_certificates_where_the_system_has_none(
    venv: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(pip_wheel, "has_system_certificates", lambda: False)
    place_pip(venv)
    bundle = venv / "ca-certificates.crt"
    assert bundle.read_text() == "certificate one\ncertificate two"
    assert certifi(venv) == f"CA_CERTS = '{bundle}'\n"


@pytest.mark.usefixtures("programs")
def test_leaves_the_systems_certificates_in_use(
    venv: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(pip_wheel, "has_system_certificates", lambda: True)
    place_pip(venv)
    assert certifi(venv) == CERTIFI
    assert not (venv / "ca-certificates.crt").exists()


def test_says_what_to_install_where_the_archive_cannot_be_reached(
    venv: Path, programs: Path
) -> None:
    (programs / "apt-get").write_text("#!/bin/sh\nexit 100\n")
    with pytest.raises(BootstrapError, match="apt-get install python3-venv"):
        place_pip(venv)
