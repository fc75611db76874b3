"""Boards whose motors turn wheels on a bench."""

from dataclasses import replace

import numpy as np
import pytest

from firmware_sim.description import RigSpec
from firmware_sim.plants.bench import BenchRig
from hal.wire import motor
from hal.wire.motor_periodic import POSITION

ARM_BUS = 2
ELBOW = 1  # of the board's two axes


@pytest.fixture
def bench(spec: RigSpec) -> BenchRig:
    """The elbow's board alone, its axes held where they stood."""
    boards = tuple(board for board in spec.boards if (board.bus, board.address) == (ARM_BUS, 2))
    axes = tuple(axis for axis in spec.axes if (axis.bus, axis.address) == (ARM_BUS, 2))
    alone = tuple(replace(board, coupled=False) for board in boards)
    rig = BenchRig(replace(spec, boards=alone, axes=axes, sensors=()))
    frames = [
        motor.GET_FIRMWARE_VERSION.request(2, ELBOW, 1, 6),
        motor.SET_POS_PID.request(2, ELBOW, 32000, 60, 20, 13),
        motor.SET_POS_PIDLIMITS.request(2, ELBOW, 0, 800, 800),
        motor.SET_MIN_POSITION.request(2, ELBOW, 0),
        motor.SET_MAX_POSITION.request(2, ELBOW, 4095),
        motor.SET_PWM_LIMIT.request(2, ELBOW, 800),
        motor.SET_BCAST_POLICY.request(2, ELBOW, POSITION.mask_bit),
        motor.CALIBRATE_ENCODER.request(2, ELBOW, 3, 2559, 10, 1371),
    ]
    for can_id, data in frames:
        rig.step({ARM_BUS: [(can_id, data, 0)]})
    return rig


def test_wheel_without_power_stays_where_it_is(spec: RigSpec) -> None:
    rig = BenchRig(spec)
    begin = rig.q_rad
    for _ in range(200):
        rig.step({})
    assert rig.q_rad == begin  # the arm of the same description would fall


def test_wheel_goes_where_its_board_is_told(bench: BenchRig) -> None:
    can_id, data = motor.POSITION_MOVE.request(2, ELBOW, round((70.0 + 180.0) * 11.375), 23)
    sent = bench.step({ARM_BUS: [(can_id, data, 0)]})[ARM_BUS]
    for _ in range(2500):
        sent += bench.step({})[ARM_BUS]
    assert bench.joints == ("r_shoulder_yaw", "r_elbow")
    assert np.degrees(bench.q_rad[1]) == pytest.approx(70.0, abs=0.3)
    last = [data for can_id, data in sent if can_id == 0x121][-1]
    values = POSITION.parse(last)
    assert values is not None
    assert values[1] / 11.375 - 180.0 == pytest.approx(70.0, abs=0.3)
