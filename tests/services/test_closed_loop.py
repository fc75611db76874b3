"""The trials of the closed loops: their arithmetic, and one arm taken through two of them."""

import numpy as np
import pytest
from numpy.typing import NDArray

from services.config import load_robot
from services.experiments.closed_loop import run
from services.experiments.loop_impedance import Deflection, predicted
from services.experiments.loop_limbs import Point, limbs
from services.experiments.loop_torque import TorqueStep

Vector = NDArray[np.float64]

AT_S: Vector = np.linspace(-0.4, 0.599, 1000)


def step_of(tau_nm: Vector) -> TorqueStep:
    wanted = np.where(AT_S > -1e-9, 3.0, 1.0)
    return TorqueStep(joint="elbow", at_s=AT_S, tau_nm=tau_nm, wanted_nm=wanted)


def test_a_first_order_answer_rises_in_ln_9_of_its_time() -> None:
    step = step_of(np.where(AT_S > -1e-9, 3.0 - 2.0 * np.exp(-AT_S / 0.02), 1.0))
    assert step.amplitude_nm == 2.0
    assert step.rise_s == pytest.approx(0.02 * np.log(9.0), abs=0.0015)
    assert step.overshoot == pytest.approx(0.0, abs=1e-6)
    assert step.steady_error == pytest.approx(0.0, abs=1e-6)


def test_a_step_that_stops_short_and_overshoots_says_so() -> None:
    tau = np.where(AT_S > -1e-9, 2.8, 1.0)
    tau[(AT_S >= 0.05) & (AT_S < 0.1)] = 3.2
    step = step_of(tau)
    assert step.steady_error == pytest.approx(0.1)
    assert step.overshoot == pytest.approx(0.2)  # 0.4 of 2 above where it ends


def test_deflection_counts_along_the_predicted_one() -> None:
    pushed = Deflection(
        limb="left_arm",
        place="hand",
        force_n=(0.0, 0.0, -20.0),
        predicted_m=np.array([0.0, 0.0, -0.05]),
        moved_m=np.array([0.01, 0.0, -0.045]),
        back_m=0.0,
        rest_rad_s=0.0,
        trace_m=np.zeros(1),
    )
    assert pushed.ratio == pytest.approx(0.9)


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
    (led,) = found.guidings
    assert np.degrees(led.drift_rad) < 0.5
    assert led.force_n < 15.0
    assert led.led_m > 0.05
    assert (found.limit_violations, found.board_faults, found.frames_lost) == (0, 0, 0)
