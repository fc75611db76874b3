"""Compile what the Cartesian controller needs before somebody waits for it."""

from dataclasses import replace

import numpy as np

from dforc.cartesian.controller import CartesianController
from dforc.cartesian.params import Law
from dforc.cartesian.state import Measurement
from dforc.cartesian.targets import STILL, PoseTarget, ReachTarget, SpeedTarget, Target, TipSpeed

TWICE = 2  # the second period of a target takes other ways than the first


def warm(controller: CartesianController) -> None:
    """Run every compiled function once, on a plan of its own."""
    n, tips = controller.limits.n, controller.tips
    q = controller.limits.project(np.zeros(n))
    poses = [tip.pose(q) for tip in tips]
    targets: tuple[Target | None, ...] = (
        ReachTarget(tips=[PoseTarget(position_m=p, rotation=R) for R, p in poses], q_rad=q),
        SpeedTarget(tips=[TipSpeed(linear_m_s=STILL)] * len(tips)),
        None,
    )
    measured = Measurement(q_rad=q, compliant=(True,) * n)
    for law in Law:
        other = controller.changed(params=replace(controller.params, law=law))
        state = other.start(q)
        for target in targets:
            for _ in range(TWICE):
                state, _ = other.step(state, measured, target)
