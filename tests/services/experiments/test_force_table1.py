"""Table 1 on the real recording, on a short emulated run, and what is printed of them."""

import io
import json
from pathlib import Path

import numpy as np
import pytest
from rich.console import Console

from services.config import load_robot
from services.experiments.forces import icubdyn
from services.experiments.forces.arm_learning import load_task
from services.experiments.forces.icubdyn import Recording
from services.experiments.forces.identified_arm import identified_nmse
from services.experiments.forces.paper_table1 import PAPER
from services.experiments.forces.recorded_arm import BARS, recorded_rows
from services.experiments.forces.table1 import (
    Errors,
    force_table1,
    interpretation,
    table,
)
from services.experiments.forces.wrench_errors import Comparison, limbs, of_recording

here = pytest.mark.skipif(not icubdyn.is_here(), reason="the recording icubdyn.tgz is not here")


@pytest.fixture(scope="module")
def recording() -> Recording:
    return icubdyn.load()


@pytest.fixture(scope="module")
def by_drawing(recording: Recording) -> Comparison:
    return of_recording(recording, "iCubLisboa01")


@here
def test_drawing_and_a_constant_offset_predict_the_real_arm(by_drawing: Comparison) -> None:
    assert (by_drawing.std <= BARS).all()
    assert by_drawing.std.round(3).tolist() == [0.779, 0.709, 0.391, 0.069, 0.057, 0.049]
    assert by_drawing.nmse == pytest.approx(0.0213, abs=5e-5)


@here
def test_a_model_of_another_generation_is_found_out(
    recording: Recording, by_drawing: Comparison
) -> None:
    wrong = of_recording(recording, "iCubGazeboV2_5")
    assert wrong.nmse > 3.0 * by_drawing.nmse


@here
def test_no_other_assignment_of_axes_fits(by_drawing: Comparison) -> None:
    """What tells that the recording's axes and signs are those of the model's sensor frame."""
    swapped = by_drawing.predicted[:, [0, 2, 1, 3, 5, 4]] * [1, -1, -1, 1, -1, -1]
    assert Comparison(by_drawing.measured, swapped).nmse > 40.0 * by_drawing.nmse
    turned = Comparison(by_drawing.measured, -by_drawing.predicted)
    assert turned.nmse > 40.0 * by_drawing.nmse


@here
def test_identified_parameters_are_better_than_the_drawing() -> None:
    once, online = identified_nmse(load_task())
    assert once <= 0.0170
    assert online <= once


@here
def test_every_bar_of_the_recording_holds() -> None:
    rows = recorded_rows()
    assert [row.holds for row in rows].count(True) == 9
    assert not any(row.holds is False for row in rows)


def test_a_recording_that_is_not_here_is_one_row_that_says_how_to_name_it(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(icubdyn, "DEFAULT_ARCHIVE", tmp_path / "icubdyn.tgz")
    (row,) = recorded_rows()
    assert row.holds is None
    assert str(row.value).startswith("not here; --data FILE names it")


def test_mean_spread_and_nmse_of_known_errors() -> None:
    predicted = np.zeros((4, 6))
    measured = np.tile([[1.0], [3.0], [1.0], [3.0]], (1, 6))
    compared = Comparison(measured, predicted)
    assert compared.mean.tolist() == [2.0] * 6
    assert compared.std.tolist() == [1.0] * 6
    assert compared.nmse == 5.0  # mean square 5, variance 1


def test_each_arm_and_leg_has_one_sensor_in_the_table() -> None:
    assert limbs(load_robot("icub")) == {
        "left_arm": "l_arm_ft",
        "right_arm": "r_arm_ft",
        "left_leg": "l_leg_ft",
        "right_leg": "r_leg_ft",
    }


def test_prints_the_papers_values_once_below_those_of_the_limb() -> None:
    compared = Comparison(np.ones((2, 6)), np.zeros((2, 6)))
    console = Console(width=120, record=True, file=io.StringIO())
    errors = [Errors("left_leg", "emulated", compared), Errors("left_leg", "recorded", compared)]
    console.print(table(errors))
    text = console.export_text()
    assert text.count("left leg") == 1
    assert text.count("-5.148") == 1
    assert text.count("1.000") == 12  # two means


def test_says_what_the_spread_is_of_the_papers() -> None:
    half = np.array(PAPER["right_arm"].std) / 2
    compared = Comparison(np.vstack([half, -half]), np.zeros((2, 6)))
    (line,) = interpretation([Errors("right_arm", "emulated", compared)])
    assert line.startswith("Emulated: the spread is 0.50 to 0.50 times the paper's.")


@pytest.mark.slow
def test_the_emulated_arm_errs_by_what_its_plant_differs(tmp_path: Path) -> None:
    file = tmp_path / "table1.json"
    assert force_table1(robot="icub:reach", short=True, json=file) == 0
    rows = {row["name"]: row["value"] for row in json.loads(file.read_text())["rows"]}
    errors = [rows[f"right_arm, emulated: {c}, std"] for c in ("fx", "fy", "fz")]
    moved = [
        rows[f"right_arm, emulated: {c}, std of what was measured"] for c in ("fx", "fy", "fz")
    ]
    assert 0.02 < max(errors) < 0.6  # not the estimator's own model, and not far from it
    assert min(moved) > 1.0
