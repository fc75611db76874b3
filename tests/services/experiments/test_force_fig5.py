"""Figure 5: the swings keep the limits, and the figure is drawn."""

import json
import math
from pathlib import Path

import numpy as np
import pytest

from services.config import load_robot
from services.core.errors import ConfigError
from services.experiments.forces.fig5 import draw, force_fig5
from services.experiments.forces.free_motion import EASE_S, SWINGS, eased, swing_of
from services.experiments.forces.wrench_errors import Comparison
from services.robotfile.wiring import joint_limits_deg

PNG = b"\x89PNG"


@pytest.mark.parametrize("joint", SWINGS)
def test_swings_stay_inside_limits_and_speeds(joint: str) -> None:
    robot = load_robot("icub")
    swing = swing_of(robot, joint)
    low, high = joint_limits_deg(robot, joint)
    middle, amplitude = math.degrees(swing.middle_rad), math.degrees(swing.amplitude_rad)
    assert low < middle - amplitude < middle + amplitude < high
    fastest = amplitude * swing.turn_rad_s
    assert fastest <= 0.75 * robot.joints[joint].max_velocity_deg_s + 1e-9
    assert amplitude >= 4.0


def test_the_rows_of_both_shoulders_are_kept() -> None:
    robot = load_robot("icub")
    swings = {joint: swing_of(robot, joint) for joint in SWINGS}
    for row in robot.rows:
        terms = [(c, swings[joint]) for joint, c in row.coefficients.items()]
        middle = sum(c * math.degrees(s.middle_rad) for c, s in terms)
        reach = sum(abs(c) * math.degrees(s.amplitude_rad) for c, s in terms)
        assert row.lower_deg <= middle - reach
        assert middle + reach <= row.upper_deg


def test_a_swing_begins_at_its_middle_and_at_rest() -> None:
    swing = swing_of(load_robot("icub"), "l_elbow")
    assert swing.at(0.0) == swing.middle_rad
    assert abs(swing.at(0.01) - swing.middle_rad) < 1e-6
    assert (eased(0.0), eased(EASE_S / 2), eased(EASE_S), eased(9.0)) == (0.0, 0.5, 1.0, 1.0)


def test_draws_six_panels(tmp_path: Path) -> None:
    wave = np.sin(np.linspace(0.0, 1.0, 50))[:, None] * np.arange(1.0, 7.0)
    path = tmp_path / "figure.png"
    draw(Comparison(wave, 0.9 * wave), "left_arm", path)
    assert path.read_bytes().startswith(PNG)


def test_refuses_a_limb_without_a_sensor() -> None:
    with pytest.raises(
        ConfigError, match=r"--limb head: .*left_arm, right_arm, left_leg, right_leg"
    ):
        force_fig5(limb="head")


@pytest.mark.slow
def test_the_model_explains_what_the_left_arms_sensor_reads(tmp_path: Path) -> None:
    file, plot = tmp_path / "fig5.json", tmp_path / "fig5.png"
    assert force_fig5(robot="icub:left_arm", short=True, json=file, plot=plot) == 0
    assert plot.read_bytes().startswith(PNG)
    rows = {row["name"]: row for row in json.loads(file.read_text())["rows"]}
    shares = [row for name, row in rows.items() if "explains" in name]
    assert len(shares) == 6
    assert all(row["value"] >= 0.9 for row in shares)
