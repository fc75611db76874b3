"""When the environment is made anew, brought up to date, or left alone."""

import fcntl
from pathlib import Path

import pytest

from services.cli.setup.environment import (
    EnvironmentSetupError,
    ensure,
    is_current,
    main,
    stamp_file,
    wanted_stamp,
)
from services.cli.setup.openmp import lend_openmp


@pytest.fixture
def checkout(tmp_path: Path) -> Path:
    (tmp_path / ".venv").mkdir()
    (tmp_path / "pyproject.toml").write_text("[project]\n")
    (tmp_path / "requirements.lock").write_text("numpy==2.4.6\n")
    (tmp_path / "requirements-dev.lock").write_text("numpy==2.4.6\npytest==9.2.0\n")
    peers = "idyntree==15.1.0\nnumpy==2.4.6\npytest==9.2.0\n"
    (tmp_path / "requirements-peers.lock").write_text(peers)
    return tmp_path


def test_is_not_current_without_a_stamp(checkout: Path) -> None:
    assert not is_current(checkout, "runtime")


def test_is_current_with_the_stamp_of_the_same_lock_and_place(checkout: Path) -> None:
    stamp_file(checkout, "runtime").write_text(wanted_stamp(checkout, "runtime"))
    assert is_current(checkout, "runtime")
    assert not is_current(checkout, "dev")


def test_a_moved_checkout_is_not_current(checkout: Path, tmp_path: Path) -> None:
    stamp_file(checkout, "runtime").write_text(wanted_stamp(checkout, "runtime"))
    moved = checkout.rename(tmp_path.parent / f"{tmp_path.name}-moved")
    assert not is_current(moved, "runtime")


def test_a_current_environment_is_left_alone(checkout: Path) -> None:
    stamp = stamp_file(checkout, "runtime")
    stamp.write_text(wanted_stamp(checkout, "runtime"))
    ensure(checkout, "runtime")
    assert sorted(p.name for p in (checkout / ".venv").iterdir()) == [stamp.name]


def test_lets_the_next_one_in_when_it_is_done(checkout: Path) -> None:
    stamp_file(checkout, "runtime").write_text(wanted_stamp(checkout, "runtime"))
    ensure(checkout, "runtime")
    with (checkout / ".venv.lock").open("w") as file:
        fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)


def test_says_so_where_it_cannot_write(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    nowhere = tmp_path / "missing"
    with pytest.raises(EnvironmentSetupError, match=r"cannot write in .*missing: No such file"):
        ensure(nowhere, "runtime")
    assert main([str(nowhere), "runtime"]) == 1
    assert capsys.readouterr().err.startswith(f"ulna: cannot write in {nowhere}: ")


def test_links_casadis_openmp_where_the_system_has_none(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    site_packages = tmp_path / "lib" / "python3.11" / "site-packages"
    (site_packages / "casadi").mkdir(parents=True)
    (site_packages / "cmeel.prefix" / "lib").mkdir(parents=True)
    bundled = site_packages / "casadi" / "libgomp-870cb1d0.so.1.0.0"
    bundled.touch()
    monkeypatch.setattr("services.cli.setup.openmp.LIBRARY", "libgomp-of-nobody.so.1")
    lend_openmp(tmp_path)
    link = site_packages / "cmeel.prefix" / "lib" / "libgomp-of-nobody.so.1"
    assert link.resolve() == bundled


def stand_in_for_pip(checkout: Path, says: str, status: int) -> Path:
    """A .venv/bin/python that only notes what it is called with; the file of its notes."""
    notes = checkout / "calls"
    python = checkout / ".venv" / "bin" / "python"
    python.parent.mkdir()
    runs = '[ "$1" = -c ] && exit 0'
    python.write_text(f'#!/bin/sh\n{runs}\necho "$*" >> {notes}\necho "{says}"\nexit {status}\n')
    python.chmod(0o755)
    return notes


def finish(checkout: Path, kind: str) -> None:
    stamp_file(checkout, kind).write_text(wanted_stamp(checkout, kind))


def test_peers_are_put_on_top_of_a_finished_dev_environment(checkout: Path) -> None:
    finish(checkout, "runtime")
    finish(checkout, "dev")
    notes = stand_in_for_pip(checkout, "Requirement already satisfied", 0)
    ensure(checkout, "peers")
    (call,) = notes.read_text().splitlines()
    assert call.endswith(
        f"--require-hashes --no-compile --progress-bar off --retries 2 -r "
        f"{checkout}/requirements-peers.lock"
    )
    assert all(is_current(checkout, kind) for kind in ("runtime", "dev", "peers"))


def test_a_peer_that_the_index_lacks_is_named_and_leaves_the_rest_as_it_was(
    checkout: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    finish(checkout, "runtime")
    finish(checkout, "dev")
    stand_in_for_pip(checkout, "ERROR: No matching distribution found for idyntree==15.1.0", 1)
    assert main([str(checkout), "peers"]) == 1
    said = capsys.readouterr().err
    assert "fetching 1 packages" in said
    assert "ulna: no ready-made package of idyntree==15.1.0 for this machine and Python" in said
    assert [is_current(checkout, kind) for kind in ("dev", "peers")] == [True, False]


def test_an_environment_that_is_made_anew_has_no_peers(checkout: Path) -> None:
    finish(checkout, "dev")
    finish(checkout, "peers")
    (checkout / "requirements.lock").write_text("numpy==2.5.0\n")
    stand_in_for_pip(checkout, "ERROR: surprise", 1)
    with pytest.raises(EnvironmentSetupError, match="pip failed"):
        ensure(checkout, "runtime")
    assert not is_current(checkout, "peers")
