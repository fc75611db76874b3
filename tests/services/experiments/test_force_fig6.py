import json
from pathlib import Path

import numpy as np
import pytest

from services.experiments.forces.fig6 import force_fig6
from services.experiments.forces.made_arm import JOINTS, made_arm


def test_the_made_torques_are_model_friction_and_noise() -> None:
    arm = made_arm(0, 1, 300, 1, 200)
    assert arm.train.x.shape == (300, 21)
    left = arm.train.tau_nm - arm.train.regressors @ arm.drawing
    dq_rad_s = arm.train.x[:, 7:14]
    fast = np.abs(dq_rad_s[:, 0]) > 0.3
    # shoulder pitch: 0.3 Nm of Coulomb and 0.1 Nms/rad of viscous friction; noise is 2 %
    friction = 0.3 * np.sign(dq_rad_s[fast, 0]) + 0.1 * dq_rad_s[fast, 0]
    assert np.abs(left[fast, 0] - friction).std() < 0.03
    assert np.abs(left[fast, 0]).mean() > 0.3


def test_the_velocities_are_those_of_the_angles() -> None:
    x = made_arm(3, 1, 200, 1, 10).train.x
    q, dq, ddq = x[:, :7], x[:, 7:14], x[:, 14:]
    np.testing.assert_allclose(np.gradient(q, 0.02, axis=0)[2:-2], dq[2:-2], atol=0.02)
    np.testing.assert_allclose(np.gradient(dq, 0.02, axis=0)[2:-2], ddq[2:-2], atol=0.08)


@pytest.mark.slow
def test_the_short_form_names_every_learner_and_draws(tmp_path: Path) -> None:
    report, plot = tmp_path / "fig6.json", tmp_path / "fig6.png"
    assert force_fig6(short=True, json=report, plot=plot) == 0
    rows = {row["name"]: row for row in json.loads(report.read_text())["rows"]}
    assert rows["LWPR"]["value"] is None
    assert "not run" in rows["LGP"]["bar"]
    assert {f"KRR 150: {joint}" for joint in JOINTS} <= set(rows)
    # friction is the smaller part of the torque, and features learn it
    assert rows["semi-parametric 200"]["value"] < 0.3 * rows["CAD, no friction"]["value"]
    assert plot.stat().st_size > 10_000
