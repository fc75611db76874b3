import json
import os
from pathlib import Path

import pytest

from services.core.errors import AlreadyRunningError, NotRunningError
from services.core.rundir import Claim, read_record, run_directory, running


@pytest.fixture(autouse=True)
def directory(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.setenv("XDG_RUNTIME_DIR", str(tmp_path))
    return tmp_path / "ulna"


def test_a_claim_tells_others_pid_and_endpoint() -> None:
    claim = Claim("icub", "icub")
    assert running() == ()  # nothing to connect to before the hub listens
    claim.publish("tcp/127.0.0.1:7447", "zenoh")
    record = read_record("icub")
    claim.release()
    assert record.pid == os.getpid()
    assert record.endpoint == "tcp/127.0.0.1:7447"
    assert record.can == "zenoh"


def test_a_second_claim_is_refused_with_the_pid_of_the_first() -> None:
    claim = Claim("icub", "icub")
    with pytest.raises(AlreadyRunningError, match=f"already running .pid {os.getpid()}."):
        Claim("icub", "icub")
    other = Claim("icub-test", "icub")
    other.release()
    claim.release()
    Claim("icub", "icub").release()


def test_what_a_crashed_stack_leaves_does_not_count(directory: Path) -> None:
    run_directory()
    stale = {"name": "icub", "robot": "icub", "pid": 1, "endpoint": "tcp/127.0.0.1:1"}
    (directory / "icub.json").write_text(json.dumps(stale))
    (directory / "icub.lock").write_text("1")
    assert running() == ()
    with pytest.raises(NotRunningError, match="no stack named 'icub' is up here; running: none"):
        read_record("icub")
    claim = Claim("icub", "icub")
    assert not (directory / "icub.json").exists()
    claim.release()


def test_others_may_not_look_into_the_run_directory() -> None:
    assert run_directory().stat().st_mode & 0o777 == 0o700
