"""The trials of the closed loops: their arithmetic, and one arm taken through two of them."""

import math

import numpy as np
import pytest
from numpy.typing import NDArray

from services.config import load_robot
from services.experiments.loops.closed_loop import run
from services.experiments.loops.expected import expected
from services.experiments.loops.impedance import Deflection, predicted
from services.experiments.loops.limbs import Point, limbs
from services.experiments.loops.rows import deflection_rows, guiding_rows, step_rows, turn_rows
from services.experiments.loops.torque import TorqueStep
from services.experiments.rows import Row

Vector = NDArray[np.float64]

AT_S: Vector = np.linspace(-0.4, 0.599, 1000)


def step_of(tau_nm: Vector) -> TorqueStep:
    wanted = np.where(AT_S > -1e-9, 3.0, 1.0)
    return TorqueStep(joint="elbow", at_s=AT_S, tau_nm=tau_nm, wanted_nm=wanted)


def test_a_first_order_answer_crosses_and_settles_by_its_time_constant() -> None:
    step = step_of(np.where(AT_S > -1e-9, 3.0 - 2.0 * np.exp(-AT_S / 0.02), 1.0))
    assert step.amplitude_nm == 2.0
    assert step.dead_s == pytest.approx(0.02 * np.log(10.0 / 9.0), abs=0.0015)
    assert step.first_crossing_s == pytest.approx(0.02 * np.log(9.0), abs=0.0015)
    # 15 % of the step is left after ln(1 / 0.15) time constants; the mean of 5 ms looks 2 ms ahead
    assert step.settling_s == pytest.approx(0.02 * np.log(1.0 / 0.15) - 0.002, abs=0.0015)
    assert step.overshoot == pytest.approx(0.0, abs=1e-6)
    assert step.change_error == pytest.approx(0.0, abs=1e-6)
    assert step.absolute_error == pytest.approx(0.0, abs=1e-6)


def test_a_step_that_stops_short_and_overshoots_says_so() -> None:
    tau = np.where(AT_S > -1e-9, 2.8, 1.0)
    tau[(AT_S >= 0.05) & (AT_S < 0.1)] = 3.2
    step = step_of(tau)
    assert step.change_error == pytest.approx(0.1)
    assert step.overshoot == pytest.approx(0.2)  # 0.4 of 2 above where it ends


def test_a_spike_that_falls_back_crosses_early_but_settles_late() -> None:
    tau = np.where(AT_S > 0.0085, 3.0, 1.0)
    tau[(AT_S > 0.0205) & (AT_S < 0.0895)] = 1.0 + 2.0 * 0.68
    step = step_of(tau)
    assert step.dead_s == pytest.approx(0.009, abs=1e-9)
    assert step.first_crossing_s == pytest.approx(0.0, abs=1e-9)
    assert step.settling_s == pytest.approx(0.088, abs=0.0011)  # 3 ms of 5 beyond the gap


def test_an_answer_that_keeps_swinging_never_settles() -> None:
    swing = 0.8 * np.sin(2.0 * np.pi * AT_S / 0.1)
    assert math.isinf(step_of(np.where(AT_S > -1e-9, 3.0 + swing, 1.0)).settling_s)


def test_a_torque_that_is_off_by_as_much_before_and_after_has_no_error_of_the_change() -> None:
    step = step_of(np.where(AT_S > -1e-9, 2.9, 0.9))
    assert step.change_error == pytest.approx(0.0, abs=1e-9)
    assert step.absolute_error_nm == pytest.approx(0.1)
    assert step.absolute_error == pytest.approx(0.05)


def test_a_group_of_joints_without_data_fails() -> None:
    step = step_of(np.where(AT_S > -1e-9, 3.0, 1.0))
    assert all(row.holds is not False for row in step_rows([step], ["elbow"]))
    rows = step_rows([step], ["elbow", "ankle_roll"])
    assert rows[0] == Row("torque steps measured", 1, "", "all 2", holds=False)
    ankle = [row for row in rows if "ankle" in row.name]
    assert len(ankle) == 8
    assert all(row.holds is False for row in ankle)


def test_a_trial_without_data_fails() -> None:
    for rows in (
        deflection_rows([], ["hand"]),
        guiding_rows([], ["left_arm"]),
        turn_rows([], ["elbow"]),
    ):
        assert [row.holds for row in rows] == [False] * len(rows)
        assert len(rows) > 3


def test_a_figure_that_is_no_number_fails_wherever_it_stands() -> None:
    good = step_of(np.where(AT_S > -1e-9, 3.0, 1.0))
    for steps in ([good, step_of(good.tau_nm * np.nan)], [step_of(good.tau_nm * np.nan), good]):
        rows = step_rows(steps, ["elbow", "elbow"])
        assert [row.holds for row in rows] == [True, *[False] * 8]


def test_a_run_expects_every_joint_push_and_limb_of_its_trials() -> None:
    (limb,) = limbs(load_robot("icub:left_leg"))
    must = expected([limb], ("torque", "impedance", "guiding"), rounds=7, only=None)
    assert must.steps == list(limb.torque)
    assert must.pushes == ["knee", "foot", "knee", "foot", "knee", "foot", "knee"]
    assert must.guidings == ["left_leg"]
    assert must.turns == []


def test_deflection_counts_along_the_predicted_one() -> None:
    pushed = Deflection(
        limb="left_arm",
        place="hand",
        force_n=(0.0, 0.0, -20.0),
        predicted_m=np.array([0.0, 0.0, -0.05]),
        moved_m=np.array([0.01, 0.0, -0.045]),
        back_m=0.0,
        rest_rad_s=0.0,
        rest_mean_rad_s=0.0,
        trace_m=np.zeros(1),
    )
    assert pushed.ratio == pytest.approx(0.9)
    assert pushed.axis == "-z"


def test_springs_give_way_by_torque_over_stiffness() -> None:
    robot = load_robot("icub:left_leg")
    (limb,) = limbs(robot)
    point = Point(robot, limb, "l_lower_leg")
    q = np.radians(limb.posture_deg)
    force = np.array([2.0, 0.0, 0.0])  # small, so that levers stay what they are
    still, bent = predicted(robot, limb, point, (q, q), force)
    torques = point.jacobian(q).T @ force
    assert still.tolist() == q.tolist()
    assert np.degrees(bent - still) == pytest.approx(torques / 2.0, abs=2e-3)  # 2 Nm/deg
    assert abs(torques[0]) > 0.3


def test_a_point_off_the_link_moves_with_the_turning_too() -> None:
    robot = load_robot("icub:left_leg")
    (limb,) = limbs(robot)
    point = Point(robot, limb, "l_sole", (0.0, 0.08, 0.02))
    q, h = np.radians(limb.posture_deg), 1e-6
    for joint, unit in enumerate(np.eye(len(q))):
        slope = (point.place_m(q + h * unit) - point.place_m(q - h * unit)) / (2.0 * h)
        assert point.jacobian(q)[:, joint] == pytest.approx(slope, abs=1e-8)


@pytest.mark.slow
def test_an_arm_gives_way_as_its_stiffness_says_and_can_be_led_by_the_hand() -> None:
    found = run(load_robot("icub:left_arm"), 0, ("impedance", "guiding"), short=True)
    assert [one.place for one in found.deflections] == ["hand", "elbow"]
    assert all(0.9 <= one.ratio <= 1.1 for one in found.deflections)
    assert all(one.back_m < 0.005 for one in found.deflections)
    assert all(0.0 <= one.rest_mean_rad_s < np.radians(1.0) for one in found.deflections)
    (led,) = found.guidings
    assert np.degrees(led.drift_rad) < 0.5
    assert 0.0 < led.force_n < led.peak_n < 15.0
    assert led.led_m > 0.05
    assert all(row.holds is not False for row in found.rows() if "at rest" not in row.name)
    assert (found.limit_violations, found.board_faults, found.frames_lost) == (0, 0, 0)
