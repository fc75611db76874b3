"""The recording icubdyn: contact-free motion of a real iCub's right arm (Gijsberts, 2011).

Its archive is robotology/icub-main: src/modules/learningMachine/exampledata/icubdyn.tgz, sha256
ce6e95d44191b57a034702297032a3ae893f1c9280a06386b7a78114aef11d0f. It has no licence of its own and
therefore stays outside this repository. Three tables, in order of time, about 28 rows a second:
500 rows for hyperparameters (drawn from the next), 2000 for training, 5000 for the test.
"""

import hashlib
import io
import tarfile
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from dforc.arrays import Matrix, constant
from services.core.errors import ConfigError

SHA256 = "ce6e95d44191b57a034702297032a3ae893f1c9280a06386b7a78114aef11d0f"
SOURCE = "robotology/icub-main: src/modules/learningMachine/exampledata/icubdyn.tgz"
CHECKOUT = Path(__file__).resolve().parents[3]
DEFAULT_ARCHIVE = CHECKOUT.parent / "shared" / "data" / "icubdyn.tgz"

JOINTS = ("r_shoulder_pitch", "r_shoulder_roll", "r_shoulder_yaw", "r_elbow")
PERIOD_S = 0.0355
ROWS = {"hyper": 500, "train": 2000, "test": 5000}
COLUMNS = 18


@dataclass(frozen=True, slots=True, eq=False)
class Samples:
    """Rows of one table: joints in the order of JOINTS, wrench in the recording's own axes."""

    q_rad: Matrix  # (rows, 4)
    dq_rad_s: Matrix
    ddq_rad_s2: Matrix
    force_n: Matrix  # (rows, 3)
    torque_nm: Matrix

    def __len__(self) -> int:
        return len(self.q_rad)

    @property
    def inputs(self) -> Matrix:
        """Joint angles, velocities and accelerations side by side, (rows, 12)."""
        return np.hstack([self.q_rad, self.dq_rad_s, self.ddq_rad_s2])

    @property
    def wrenches(self) -> Matrix:
        """Force, then torque, (rows, 6)."""
        return np.hstack([self.force_n, self.torque_nm])


@dataclass(frozen=True, slots=True, eq=False)
class Recording:
    """The three tables."""

    hyper: Samples
    train: Samples
    test: Samples


def is_here() -> bool:
    """Whether the archive is where it is looked for by default."""
    return DEFAULT_ARCHIVE.is_file()


def find(data: Path | None = None) -> Path:
    """The archive's path: the one given, else the default one where that exists.

    Raises:
        ConfigError: there is none.
    """
    path = DEFAULT_ARCHIVE if data is None else data
    if path.is_file():
        return path
    lacking = (
        "the recording icubdyn.tgz is not here" if data is None else f"there is no file {path}"
    )
    raise ConfigError(f"{lacking}; --data FILE names it (from {SOURCE})")


def load(path: Path | None = None) -> Recording:
    """Read the archive, in memory.

    Raises:
        ConfigError: it is absent, or is not that archive.
    """
    archive = find(path)
    content = archive.read_bytes()
    if hashlib.sha256(content).hexdigest() != SHA256:
        raise ConfigError(
            f"{archive} is not the recording icubdyn.tgz (its sha256 differs); "
            f"--data FILE names it (from {SOURCE})"
        )
    return read(content)


def read(content: bytes) -> Recording:
    """The tables of an archive's bytes.

    Raises:
        ConfigError: a table is missing or has another shape.
    """
    try:
        with tarfile.open(fileobj=io.BytesIO(content), mode="r:gz") as archive:
            tables = {name: _table(archive, name, rows) for name, rows in ROWS.items()}
    except (tarfile.TarError, EOFError, OSError) as error:
        raise ConfigError(f"--data: no archive of the recording icubdyn: {error}") from error
    return Recording(**tables)


def _table(archive: tarfile.TarFile, name: str, rows: int) -> Samples:
    member = f"icubdyn_{name}.dat"
    try:
        file = archive.extractfile(member)
        values = np.loadtxt(file) if file is not None else np.empty((0, 0))
    except (KeyError, ValueError) as error:
        raise ConfigError(f"--data: the archive has no readable table {member}: {error}") from error
    if values.shape != (rows, COLUMNS):
        raise ConfigError(f"--data: {member} has shape {values.shape}, not {(rows, COLUMNS)}")
    if not np.isfinite(values).all():
        raise ConfigError(f"--data: {member} holds a number that is not finite")
    motion = np.deg2rad(values[:, :12])
    return Samples(
        q_rad=constant(motion[:, 0:4]),
        dq_rad_s=constant(motion[:, 4:8]),
        ddq_rad_s2=constant(motion[:, 8:12]),
        force_n=constant(values[:, 12:15]),
        torque_nm=constant(values[:, 15:18]),
    )
