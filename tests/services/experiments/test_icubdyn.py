"""Reading the recording of a real right arm: what is in it, and what is refused."""

import io
import math
import tarfile
from pathlib import Path

import numpy as np
import pytest

from services.core.errors import ConfigError
from services.experiments.forces import icubdyn
from services.experiments.forces.icubdyn import ROWS, find, load, read

ROW = " ".join(map(str, [90, 180, -90, 45, 18, 36, 54, 72, 360, 0, 0, 0, 1.5, 2, 3, 0.1, 0.2, 0.3]))

here = pytest.mark.skipif(not icubdyn.is_here(), reason="the recording icubdyn.tgz is not here")


def archive(tables: dict[str, str]) -> bytes:
    content = io.BytesIO()
    with tarfile.open(fileobj=content, mode="w:gz") as tar:
        for name, text in tables.items():
            member = tarfile.TarInfo(f"icubdyn_{name}.dat")
            member.size = len(text)
            tar.addfile(member, io.BytesIO(text.encode()))
    return content.getvalue()


def whole(row: str = ROW) -> dict[str, str]:
    return {name: f"{row}\n" * rows for name, rows in ROWS.items()}


def test_turns_degrees_into_radians_and_leaves_newtons_alone() -> None:
    recording = read(archive(whole()))
    assert [len(part) for part in (recording.hyper, recording.train, recording.test)] == [
        500,
        2000,
        5000,
    ]
    last = recording.test.q_rad[-1].tolist()
    assert last == pytest.approx([math.pi / 2, math.pi, -math.pi / 2, math.pi / 4])
    assert recording.test.dq_rad_s[0, 0] == pytest.approx(math.pi / 10)
    assert recording.train.ddq_rad_s2[0].tolist() == pytest.approx([2 * math.pi, 0, 0, 0])
    assert recording.hyper.force_n[0].tolist() == [1.5, 2.0, 3.0]
    assert recording.hyper.torque_nm[0].tolist() == [0.1, 0.2, 0.3]


def test_puts_motion_and_wrench_side_by_side() -> None:
    samples = read(archive(whole())).hyper
    assert samples.inputs.shape == (500, 12)
    assert samples.inputs[0, 4] == samples.dq_rad_s[0, 0]
    assert samples.wrenches[0].tolist() == [1.5, 2.0, 3.0, 0.1, 0.2, 0.3]


def test_refuses_an_archive_that_lacks_a_table() -> None:
    tables = whole()
    del tables["test"]
    with pytest.raises(ConfigError, match=r"--data: the archive has no .* icubdyn_test\.dat"):
        read(archive(tables))


def test_refuses_a_table_of_another_shape() -> None:
    tables = whole() | {"hyper": f"{ROW}\n" * 499}
    with pytest.raises(ConfigError, match=r"icubdyn_hyper\.dat has shape \(499, 18\), not \(500"):
        read(archive(tables))


def test_refuses_words_in_the_place_of_numbers() -> None:
    tables = whole() | {"hyper": ROW.replace("90", "ninety")}
    with pytest.raises(ConfigError, match=r"no readable table icubdyn_hyper\.dat"):
        read(archive(tables))


def test_refuses_what_is_not_finite() -> None:
    tables = whole() | {"hyper": f"{ROW}\n" * 499 + ROW.replace("1.5", "nan")}
    with pytest.raises(ConfigError, match="not finite"):
        read(archive(tables))


def test_refuses_bytes_that_are_no_archive() -> None:
    with pytest.raises(ConfigError, match="--data: no archive of the recording"):
        read(b"nothing")


def test_refuses_a_cut_archive() -> None:
    with pytest.raises(ConfigError, match="--data"):
        read(archive(whole())[:-200])


def test_an_absent_file_is_named_with_the_option_and_the_source(tmp_path: Path) -> None:
    missing = tmp_path / "icubdyn.tgz"
    with pytest.raises(ConfigError, match=r"no file .*icubdyn\.tgz; --data FILE .*icub-main"):
        load(missing)


def test_an_archive_of_another_content_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "icubdyn.tgz"
    path.write_bytes(archive(whole()))
    with pytest.raises(ConfigError, match=r"is not the recording icubdyn\.tgz"):
        load(path)


def test_says_so_where_nothing_is_given_and_nothing_is_there(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(icubdyn, "DEFAULT_ARCHIVE", tmp_path / "icubdyn.tgz")
    with pytest.raises(ConfigError, match=r"the recording icubdyn\.tgz is not here; --data FILE"):
        find()


@here
def test_the_first_row_of_the_real_test_table() -> None:
    test = load().test
    assert np.degrees(test.q_rad[0]).tolist() == pytest.approx(
        [-79.3392, 15.1877, 50.3066, 52.7924]
    )
    assert test.wrenches[0].tolist() == [35.018, -44.6915, 41.0067, -0.266724, -2.42322, 0.43335]


@here
def test_the_hyperparameter_rows_are_among_the_training_rows() -> None:
    recording = load()
    train = {tuple(row) for row in recording.train.inputs.tolist()}
    assert {tuple(row) for row in recording.hyper.inputs.tolist()} <= train
