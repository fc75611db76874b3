"""The run directory: which stacks are up on this host, and where their hubs listen.

`<stack>.lock` is locked by the supervisor for as long as it lives, so a crashed one leaves nothing
to clear by hand; `<stack>.json` tells others pid and endpoint; `<stack>/` has the logs.
"""

import fcntl
import os
import tempfile
from pathlib import Path

import msgspec

from services.core.clock import RealClock
from services.core.errors import AlreadyRunningError, NotRunningError, ServiceError

LOCK_ATTEMPTS = 10
LOCK_RETRY_NS = 2_000_000


class RunRecord(msgspec.Struct, frozen=True, kw_only=True):
    """What a running stack tells others."""

    name: str
    robot: str
    pid: int
    endpoint: str = ""  # empty until the hub listens
    can: str = ""
    reference: str = ""  # name[:parts][@site] that the stack runs


def run_directory() -> Path:
    """This user's directory; made when it is not there.

    Raises:
        ServiceError: something is in the way, or it belongs to somebody else.
    """
    base = os.environ.get("XDG_RUNTIME_DIR")
    path = Path(base) / "ulna" if base else Path(tempfile.gettempdir()) / f"ulna-{os.getuid()}"
    try:
        path.mkdir(mode=0o700, parents=True, exist_ok=True)
        owner = path.stat().st_uid
    except OSError as error:
        raise ServiceError(f"cannot use the run directory {path}: {error.strerror}") from error
    if owner != os.getuid():
        raise ServiceError(f"the run directory {path} belongs to user {owner}, not to us")
    return path


class Claim:
    """A stack name that is ours until release() or the end of this process."""

    def __init__(self, name: str, robot: str, reference: str = "") -> None:
        """Take the name.

        Raises:
            AlreadyRunningError: a living process has it.
        """
        self._directory = run_directory()
        self._path = self._directory / f"{name}.json"
        self._lock = os.open(self._directory / f"{name}.lock", os.O_CREAT | os.O_RDWR, 0o600)
        if not _lock(self._lock):
            pid = int(os.pread(self._lock, 32, 0) or b"0")
            os.close(self._lock)
            raise AlreadyRunningError(name, pid)
        os.ftruncate(self._lock, 0)
        os.pwrite(self._lock, str(os.getpid()).encode(), 0)
        self.record = RunRecord(name=name, robot=robot, pid=os.getpid(), reference=reference)
        self._path.unlink(missing_ok=True)  # of a stack that crashed
        self.logs = self._directory / name
        self.logs.mkdir(mode=0o700, exist_ok=True)

    def publish(self, endpoint: str, can: str) -> None:
        """Tell others where the hub listens."""
        self.record = msgspec.structs.replace(self.record, endpoint=endpoint, can=can)
        draft = self._path.with_suffix(".draft")
        draft.write_bytes(msgspec.json.encode(self.record))
        draft.replace(self._path)

    def release(self) -> None:
        """Give the name back; the logs stay until the next stack of that name."""
        self._path.unlink(missing_ok=True)
        os.close(self._lock)


def read_record(name: str) -> RunRecord:
    """What the running stack of that name tells.

    Raises:
        NotRunningError: there is none; those that run are listed.
    """
    records = {record.name: record for record in running()}
    if name not in records:
        others = ", ".join(records) or "none"
        raise NotRunningError(f"no stack named {name!r} is up here; running: {others}")
    return records[name]


def running() -> tuple[RunRecord, ...]:
    """Every stack of this user whose supervisor lives and whose hub listens."""
    directory = run_directory()
    records = []
    for path in sorted(directory.glob("*.json")):
        try:
            record = msgspec.json.decode(path.read_bytes(), type=RunRecord)
        except (OSError, msgspec.DecodeError):
            continue  # it has just ended, or is not ours
        if _is_locked(directory / f"{record.name}.lock"):
            records.append(record)
    return tuple(records)


def _lock(descriptor: int) -> bool:
    """Take the lock; tries again for a moment, because running() looks by locking, too."""
    clock = RealClock()
    for _ in range(LOCK_ATTEMPTS):
        try:
            fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            clock.sleep_until(clock.now_ns() + LOCK_RETRY_NS)
        else:
            return True
    return False


def _is_locked(path: Path) -> bool:
    try:
        probe = os.open(path, os.O_RDONLY)
    except OSError:
        return False
    try:
        fcntl.flock(probe, fcntl.LOCK_SH | fcntl.LOCK_NB)
    except BlockingIOError:
        return True
    finally:
        os.close(probe)
    return False
