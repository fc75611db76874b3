"""Axes whose board is elsewhere: the plant follows its POSITION frames."""

import math
from dataclasses import replace

import numpy as np
import pytest

from firmware_sim.description import RigSpec
from firmware_sim.rig import Rig
from hal.wire.can import Frame
from hal.wire.motor_periodic import POSITION

ARM_BUS, ELBOW_BOARD = 2, 2
YAW, ELBOW = 5, 6
FRAME_MS = 4


def driven_spec(spec: RigSpec) -> RigSpec:
    """The board of shoulder yaw and elbow is not in this process."""
    here = tuple(b for b in spec.boards if (b.bus, b.address) != (ARM_BUS, ELBOW_BOARD))
    axes = tuple(
        replace(axis, driven=(axis.bus, axis.address) == (ARM_BUS, ELBOW_BOARD))
        for axis in spec.axes
    )
    return replace(spec, boards=here, axes=axes)


def position(spec: RigSpec, yaw_rad: float, elbow_rad: float) -> Frame:
    ticks = [
        math.floor((math.degrees(angle) + axis.zero_deg) * axis.ticks_per_deg + 0.5)
        for axis, angle in zip(spec.axes[YAW : ELBOW + 1], (yaw_rad, elbow_rad), strict=True)
    ]
    return POSITION.frame(ELBOW_BOARD, *ticks)


def scripted(milliseconds: int) -> tuple[float, float]:
    """A motion that begins and ends at rest: shoulder yaw and elbow, rad."""
    way = 0.5 - 0.5 * math.cos(math.pi * min(milliseconds / 1500.0, 1.0))
    return math.radians(-20.0 * way), math.radians(45.0 + 40.0 * way)


def test_driven_joints_arrive_where_the_frames_say(exact_spec: RigSpec) -> None:
    rig = Rig(driven_spec(exact_spec))
    for ms in range(2000):
        frames = [(*position(exact_spec, *scripted(ms)), 0)] if ms % FRAME_MS == 0 else []
        rig.step({ARM_BUS: frames})
    assert np.degrees(rig.q_rad[YAW]) == pytest.approx(-20.0, abs=0.06)
    assert np.degrees(rig.q_rad[ELBOW]) == pytest.approx(85.0, abs=0.06)


def test_driven_half_of_the_arm_weighs_and_pulls_as_the_simulated_one(exact_spec: RigSpec) -> None:
    still = stuck(exact_spec)
    whole, half = Rig(still), Rig(driven_spec(still))
    elbow = whole.board(ARM_BUS, ELBOW_BOARD).ports[1]
    felt, differ = [], []
    for ms in range(1500):
        told = [(*position(still, whole.q_rad[YAW], whole.q_rad[ELBOW]), 0)]
        whole.step({})
        elbow.pwm, elbow.enabled = round(180.0 * math.sin(ms / 200.0)) if ms < 628 else 0, True
        half.step({ARM_BUS: told if ms % FRAME_MS == 0 else []})
        felt.append(whole.plant.wrenches[0].copy())
        differ.append(half.plant.wrenches[0] - felt[-1])
    moving, resting = np.array(differ[:800]), np.array(differ[1400:])
    assert (
        np.abs(felt[-1] - felt[0])[3:].max() > 0.15
    )  # Nm: the forearm hangs otherwise than before
    assert np.abs(resting)[:, 3:].max() < 0.05
    # A tick of the encoder is 0.09 degrees, and a frame tells it every 4 ms.
    assert moving[:, :3].std(axis=0).max() < 0.4
    assert moving[:, 3:].std(axis=0).max() < 0.1


def test_silent_axis_stands_still(exact_spec: RigSpec) -> None:
    rig = Rig(driven_spec(exact_spec))
    for ms in range(700):
        frames = [(*position(exact_spec, *scripted(ms)), 0)] if ms % FRAME_MS == 0 else []
        rig.step({ARM_BUS: frames})
    for _ in range(400):
        rig.step({})
    before = rig.q_rad
    for _ in range(200):
        rig.step({})
    assert rig.q_rad[YAW : ELBOW + 1] == pytest.approx(before[YAW : ELBOW + 1], abs=1e-4)


def test_driven_axes_are_not_held_to_limits(exact_spec: RigSpec) -> None:
    rig = Rig(driven_spec(exact_spec))
    assert "r_elbow" not in rig.limits_waiting
    assert "r_shoulder_pitch" in rig.limits_waiting


def stuck(spec: RigSpec) -> RigSpec:
    """So much friction that nothing moves by itself but shoulder yaw and elbow."""
    axes = []
    for index, axis in enumerate(spec.axes):
        assert axis.motor is not None
        friction_nm = axis.motor.coulomb_nm if index in (YAW, ELBOW) else 100.0
        axes.append(replace(axis, motor=replace(axis.motor, coulomb_nm=friction_nm)))
    return replace(spec, axes=tuple(axes))
