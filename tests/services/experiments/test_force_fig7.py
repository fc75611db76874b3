import json
from pathlib import Path

import numpy as np
import pytest

from services.core.errors import ConfigError
from services.experiments.forces import icubdyn
from services.experiments.forces.arm_learning import ArmTask, Rows, load_task, predict_then_update
from services.experiments.forces.fig7 import Curve, Outcome, force_fig7, rows_of


def test_a_label_that_is_late_is_learned_after_the_guess_that_it_is_late_for() -> None:
    told: list[tuple[int, int]] = []
    guesses: list[int] = []

    def predict(i: int) -> np.ndarray:
        guesses.append(i)
        return np.zeros(1)

    predict_then_update(
        predict, lambda i: told.append((i, guesses[-1])), np.ones((5, 1)), late=2, last=2
    )
    assert told == [(0, 2), (1, 3)]


def test_the_curve_is_the_average_so_far_in_the_variance_of_the_whole_test() -> None:
    y = np.array([[1.0] * 6, [-1.0] * 6, [1.0] * 6, [-1.0] * 6]) * 2.0  # variance 4
    rows = Rows(np.zeros((4, 12)), y, np.zeros((4, 6, 26)))
    task = ArmTask(rows, rows, rows, np.zeros(26))
    errors = np.array([[2.0] * 6, [0.0] * 6, [0.0] * 6, [4.0] * 6])
    np.testing.assert_allclose(task.curve(errors), [1.0, 0.5, 1 / 3, 1.25])
    assert task.error(errors) == pytest.approx(1.25)


def test_without_the_recording_it_says_where_it_is_from(tmp_path: Path) -> None:
    with pytest.raises(ConfigError, match=r"icubdyn\.tgz"):
        load_task(tmp_path / "icubdyn.tgz")


@pytest.mark.parametrize(
    ("deviation", "holds"), [(None, []), (5e-5, [True]), (2e-4, [False])], ids=str
)
def test_the_deviation_of_the_runs_has_a_bar_where_there_are_several(
    deviation: float | None, holds: list[bool]
) -> None:
    names = ("RFRR 200", "KRR, static", "semi-parametric, 1 s late", "semi-parametric, 5 s late")
    curves = {name: Curve(name, np.array([0.007]), deviation) for name in names}
    rows = [row for row in rows_of(Outcome(curves, {})) if "deviation" in row.name]
    assert [row.holds for row in rows] == holds


@pytest.mark.slow
@pytest.mark.skipif(not icubdyn.is_here(), reason="the recording icubdyn.tgz is not here")
def test_every_bar_holds_on_the_recording_in_the_short_form(tmp_path: Path) -> None:
    report, plot = tmp_path / "fig7.json", tmp_path / "fig7.png"
    assert force_fig7(short=True, json=report, plot=plot) == 0
    values = {row["name"]: row["value"] for row in json.loads(report.read_text())["rows"]}
    # figures of an independent implementation on the same rows
    assert values["persistence"] == pytest.approx(0.0115, abs=1e-4)
    assert values["CAD + offset"] == pytest.approx(0.0213, abs=1e-4)
    assert values["KRR, static"] == pytest.approx(0.0214, abs=5e-4)
    assert values["RFRR 200"] == pytest.approx(0.0074, abs=1e-4)
    assert plot.stat().st_size > 10_000
