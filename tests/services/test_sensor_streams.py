"""What the sensors beside force/torque publish, from emulated boards through CAN and HAL."""

import math

import pytest

from services.config import load_robot
from services.core.service import Inputs, Outputs, Period, Service
from services.core.stream import AnyStream
from services.emulated.simulation import Simulation
from services.messages import Hall, Imu, Inertial, Skin
from services.streams import HALL, IMU, INERTIAL, SKIN


class Reader(Service):
    """Keeps the newest message of every stream, and counts them."""

    trigger = Period(0.01)

    def __init__(self, *streams: AnyStream) -> None:
        self.reads = streams
        self.count = dict.fromkeys(streams, 0)
        self.newest: dict[AnyStream, object] = {}

    def step(self, now_ns: int, inputs: Inputs, outputs: Outputs) -> None:  # noqa: ARG002
        for stream in self.reads:
            message = inputs.new(stream)
            if message is not None:
                self.count[stream] += 1
                self.newest[stream] = message


def heard(selection: str, *streams: AnyStream) -> Reader:
    """Two seconds of a robot without the reaching limb."""
    reader = Reader(*streams)
    simulation = Simulation(load_robot(f"icub:{selection}"), guests={"reader": reader})
    simulation.executor.run(2.0)
    simulation.close()
    return reader


def test_a_hand_s_hall_sensors_and_an_arm_s_skin() -> None:
    stream, skin, inertial = HALL["r_mais"], SKIN["r_hand_skin"], INERTIAL["r_hand_skin"]
    reader = heard("right_hand", stream)
    hall = reader.newest[stream]
    assert isinstance(hall, Hall)
    assert len(hall.counts) == 15
    assert 150 < reader.count[stream] <= 200
    reader = heard("right_arm_skin", skin, inertial)
    touch, motion = reader.newest[skin], reader.newest[inertial]
    assert isinstance(touch, Skin)
    assert touch.taxels == bytes([touch.no_load]) * 192
    assert touch.errors == bytes(16)
    assert 40 <= reader.count[skin] <= 50
    assert isinstance(motion, Inertial)


def test_the_head_s_imu_feels_gravity() -> None:
    stream = IMU["head_imu"]
    reader = heard("head", stream)
    imu = reader.newest[stream]
    assert isinstance(imu, Imu)
    assert math.hypot(*imu.acceleration_m_s2) == pytest.approx(9.81, abs=0.2)
    assert math.hypot(*imu.quaternion) == pytest.approx(1.0, abs=1e-3)
    assert reader.count[stream] >= 150
