"""The comparison of inverse kinematics: its judge, its clockwork and its targets."""

import sys
import tempfile
from pathlib import Path as File

import numpy as np
import pytest

from services.experiments.ik.arm import Arm, Array, both_arms, measured_arm
from services.experiments.ik.contenders import Answer, Nothing, Ours, Stock
from services.experiments.ik.measure import Run, follow, largest_step_rad, percent, search, worth
from services.experiments.ik.nlp import Form, PlainNlp
from services.experiments.ik.paths import CENTRE, GAIN_M, Path, joint_path, lap_of
from services.experiments.ik.peers import peers
from services.experiments.ik.poses import OURS, POSITION, Sample, at, bars
from services.experiments.ik.sets import Sizes, Targets, orientation_out, position_out, reachable
from services.experiments.ik.table import lines

FEW = Sizes(reachable=3, unreachable=2, objective_starts=3, starts=3)


@pytest.fixture(scope="module")
def arm() -> Arm:
    return measured_arm()


@pytest.fixture
def _own_folder(monkeypatch: pytest.MonkeyPatch, tmp_path: File) -> None:
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path))


def silent(_: str) -> None:
    """Nobody listens."""


def targets_at(arm: Arm, q: Array, best: float) -> Targets:
    R, p = arm.pose(q)
    return Targets(p[None], R[None], q[None], np.array([best]))


def test_the_rest_posture_is_inside_limits_and_rows(arm: Arm) -> None:
    # nearest is the row "arm against torso": 30 degrees of roll, 26.4188 asked for
    assert arm.violation(arm.rest) == pytest.approx(-np.radians(30.0 - 26.4188), abs=1e-12)


def test_a_row_that_is_crossed_counts_by_how_far(arm: Arm) -> None:
    q = arm.rest.copy()
    q[4] = np.radians(20.0)
    assert arm.violation(q) == pytest.approx(np.radians(6.4188), abs=1e-12)


def test_a_joint_beyond_its_range_counts_by_how_far(arm: Arm) -> None:
    q = arm.rest.copy()
    q[9] = arm.upper[9] + 0.25
    assert arm.violation(q) == pytest.approx(0.25, abs=1e-12)


def test_the_objective_is_eq_11s(arm: Arm) -> None:
    q = arm.rest.copy()
    q[0] += 0.2  # torso: weight 1
    q[6] += 0.3  # arm: weight 0.1
    R, _ = arm.pose(q)
    assert arm.objective(q, R) == pytest.approx(0.01 * (0.2**2 + 0.1 * 0.3**2), abs=1e-12)
    turned = arm.pose(arm.rest)[0]
    assert arm.angle_rad(arm.rest, turned) == pytest.approx(0.0, abs=1e-9)


def test_the_reference_solves_the_posture_it_is_given(arm: Arm) -> None:
    R, p = arm.pose(arm.rest)
    for form in (Form.SQUARED, Form.EXACT):
        q = PlainNlp(arm, form).solve(p, R, arm.rest + 0.02)
        assert q == pytest.approx(arm.rest, abs=1e-3)


def test_both_arms_have_two_tips_and_the_rows_twice() -> None:
    pair = both_arms()
    assert pair.A.shape == (14, 17)
    left, right = (pair.pose(pair.rest, tip)[1] for tip in range(2))
    assert left == pytest.approx(right * [1.0, -1.0, 1.0], abs=1e-3)  # y points to the right


@pytest.mark.usefixtures("_own_folder")
def test_reachable_targets_are_reached_by_ours_with_the_best_objective(arm: Arm) -> None:
    targets = reachable(arm, 1, FEW, silent)
    run = search([Ours(OURS, arm)], targets, np.tile(arm.rest, (3, 1)), 1)[OURS]
    found = worth(arm, targets.position, targets.rotation, run)
    assert found.feasible().all()
    assert found.optimal(targets.best).all()
    assert (run.said == 1.0).all()


@pytest.mark.usefixtures("_own_folder")
def test_targets_come_from_the_seed_and_are_kept(arm: Arm) -> None:
    said: list[str] = []
    first, again = (reachable(arm, 2, FEW, said.append) for _ in range(2))
    other = reachable(arm, 3, FEW, said.append)
    assert np.array_equal(first.position, again.position)
    assert np.array_equal(first.best, again.best)
    assert not np.array_equal(first.position, other.position)
    assert len(said) == 2


@pytest.mark.usefixtures("_own_folder")
def test_targets_out_of_reach_are_so_by_what_their_set_says(arm: Arm) -> None:
    turned = orientation_out(arm, 1, FEW, silent)
    assert (np.degrees(turned.best) >= 3.0).all()
    assert (np.degrees(turned.best) <= 29.0).all()
    away = position_out(arm, 1, FEW, silent)
    assert (away.best >= 0.013).all()


def test_the_lemniscate_goes_five_millimetres_a_tick_and_closes() -> None:
    lap = lap_of(CENTRE, GAIN_M)
    steps = np.linalg.norm(np.diff(np.vstack([lap, lap[0]]), axis=0), axis=1)
    assert steps == pytest.approx(0.005, abs=1e-4)
    assert lap[0] == pytest.approx(CENTRE, abs=1e-3)
    assert np.abs(lap - CENTRE).max() == pytest.approx(GAIN_M, abs=1e-4)


def test_the_joint_path_keeps_limits_and_steps(arm: Arm) -> None:
    path = joint_path(arm, 0, 200)
    steps = np.linalg.norm(np.diff(path.position, axis=0), axis=1)
    assert steps.max() < 0.0055
    assert arm.distance_m(path.start, path.position[0]) < 0.0055


def test_ticks_beside_one_out_of_reach_are_not_well_reached(arm: Arm) -> None:
    path = joint_path(arm, 0, 6)
    nearest = np.array([0.0, 0.0, 0.0, 0.002, 0.0, 0.0])
    edged = Path(path.name, path.position, path.rotation, path.start, nearest)
    assert edged.reached().tolist() == [True, True, True, False, True, True]
    assert edged.well_reached().tolist() == [True, True, False, False, False, True]
    assert edged.cut(2).well_reached().tolist() == [True, True]


class Counted(Nothing):
    """Counts its calls, and each answer is another posture."""

    def __init__(self) -> None:
        self.calls = 0

    def solve(self, position: Array, rotation: Array, q0: Array) -> Answer:  # noqa: ARG002
        self.calls += 1
        return Answer(q0 + 0.01, None)

    track = solve


def test_every_tick_starts_from_the_answer_before(arm: Arm) -> None:
    path = joint_path(arm, 0, 3)
    counted = Counted()
    run = follow([counted], path, repeats=3)[counted.name]
    assert run.q[:, 0] - path.start[0] == pytest.approx([0.01, 0.02, 0.03])
    assert largest_step_rad(run) == pytest.approx(0.01)
    assert counted.calls == 1 + 3 * 3  # one to warm up


def test_a_missing_answer_is_wrong_in_every_way(arm: Arm) -> None:
    targets = targets_at(arm, arm.rest, 0.0)
    run = Run(np.full((1, arm.n), np.nan), np.array([1.0]), np.array([0.0]))
    found = worth(arm, targets.position, targets.rotation, run)
    assert not found.feasible().any()
    assert not found.loosely_feasible().any()
    assert not found.optimal(np.array([1.0])).any()


def test_an_answer_a_hair_outside_a_row_is_not_feasible(arm: Arm) -> None:
    q = arm.rest.copy()
    q[4] = np.radians(26.4188) - 2e-6
    targets = targets_at(arm, q, 0.0)
    found = worth(arm, targets.position, targets.rotation, _run_of(q))
    assert not found.feasible()[0]
    assert found.loosely_feasible()[0]


def test_a_wrong_answer_breaks_the_bars(arm: Arm) -> None:
    away = targets_at(arm, arm.rest, 0.0)
    beyond = Targets(
        away.position + np.array([0.0, 0.0, 0.02]), away.rotation, away.near, np.array([0.018])
    )
    runs = {OURS: _run_of(arm.rest)}
    worths = {OURS: worth(arm, beyond.position, beyond.rotation, runs[OURS])}
    rows = {row.name.split(": ")[1]: row for row in bars(Sample(POSITION, beyond, runs, worths))}
    assert not rows["said so"].holds  # it claimed to have reached it
    assert rows["all limits kept"].holds
    assert rows["excess distance, largest"].value == pytest.approx(2.0)
    assert not rows["excess distance, largest"].holds


def test_a_peer_that_is_not_installed_is_named_with_where_to_get_it(
    arm: Arm, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(sys.modules, "PyKDL", None)
    found, missing = peers(arm, ("KDL", "SciPy"))
    assert [c.name for c in found] == ["SciPy SLSQP, x = 0"]
    assert missing["KDL"].startswith("not measured: ")
    assert "python3-pykdl" in missing["KDL"]


def test_the_table_has_a_line_for_everybody(arm: Arm) -> None:
    targets = targets_at(arm, arm.rest, 0.0)
    runs = search([Nothing(), Stock(arm, Form.EXACT, "ipopt")], targets, targets.near, 1)
    worths = {n: worth(arm, targets.position, targets.rotation, run) for n, run in runs.items()}
    found = lines({"cold": Sample("cold", targets, runs, worths)})
    assert [line.solver for line in found] == ["empty call", "IPOPT, x = 0"]
    assert [line.cold for line in found] == ["100.0/100.0", "100.0/100.0"]
    assert found[0].position == ""


def test_percentiles_take_infinite_numbers() -> None:
    values = np.array([1.0, 2.0, 3.0, np.inf])
    assert at(values, 50) == 2.0
    assert at(values, 90) == np.inf
    assert percent(np.array([True, False])) == 50.0


def _run_of(q: Array) -> Run:
    return Run(q[None], np.array([1.0]), np.array([1.0]))
