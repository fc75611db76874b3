"""Fingers on tendons: tensions, stops, things in the hand, and what the Hall sensors read."""

import math
from typing import NamedTuple

import numpy as np
import pytest

from firmware_sim.description import AxisSpec, FingerSpec
from firmware_sim.plants import kernel
from firmware_sim.plants.tendons import PRELOAD_RAD, TENDON_NM_RAD, Halls, Tendons

SPRING = 0.02


def tendon(
    *fingers: FingerSpec, ticks_per_deg: float = -2.22, zero_deg: float = -220.5
) -> AxisSpec:
    return AxisSpec(
        bus=5,
        address=7,
        axis=0,
        joint="index",
        motor=None,
        ticks_per_deg=ticks_per_deg,
        zero_deg=zero_deg,
        mechanism="tendon",
        fingers=fingers,
    )


MIDDLE = FingerSpec(name="middle", range_deg=(0.0, 90.0), hall=(4,), spring_nm_rad=SPRING)
TIP = FingerSpec(name="tip", range_deg=(0.0, 80.0), hall=(5,), spring_nm_rad=2 * SPRING)
DISTAL = tendon(MIDDLE, TIP)


class Pulled(NamedTuple):
    """A tendon at some place: tension (Nm) and its slope, angle of its fingers and its slope."""

    tension: float
    slope: float
    angle: float
    angle_slope: float
    fingers_deg: list[float]


def pull(hand: Tendons, wound_rad: float) -> Pulled:
    state = np.zeros((kernel.STATE_ROWS, 1))
    state[kernel.X], state[kernel.DX] = wound_rad, 1.0
    angle, speed = np.zeros(1), np.zeros(1)
    at = np.zeros(1, dtype=np.intp)
    kernel.pull(state, at, hand.wound_rad, hand.table, angle, speed)
    tension = state[kernel.PULL]
    fingers = np.degrees(hand.finger_rad(tension)).tolist()
    slope = float(state[kernel.PULL_SLOPE, 0])
    return Pulled(float(tension[0]), slope, float(angle[0]), float(speed[0]), fingers)


def wound(hand: Tendons, degrees: float) -> tuple[float, list[float]]:
    """Tension and finger angles (deg) where so much is wound."""
    pulled = pull(hand, math.radians(degrees))
    return pulled.tension, pulled.fingers_deg


def test_slack_tendon_leaves_the_fingers_open() -> None:
    assert wound(Tendons([DISTAL]), -30.0) == (0.0, [0.0, 0.0])


def test_stiffer_finger_closes_half_as_fast() -> None:
    # 0.02 Nm/rad x 1 rad and the preload of 0.3 rad: the other spring is at 0.65 of that
    hand = Tendons([DISTAL])
    tension = SPRING * (1.0 + PRELOAD_RAD)
    tip = tension / (2 * SPRING) - PRELOAD_RAD
    pulled = pull(hand, 1.0 + tip + tension / TENDON_NM_RAD)
    assert pulled.tension == pytest.approx(tension)
    assert pulled.fingers_deg == pytest.approx([np.degrees(1.0), np.degrees(tip)])
    assert pulled.angle == pytest.approx(1.0 + tip)


def test_closed_finger_only_stretches_the_tendon() -> None:
    hand = Tendons([DISTAL])
    tension, fingers = wound(hand, 400.0)
    assert fingers == pytest.approx([90.0, 80.0])
    assert tension == pytest.approx(TENDON_NM_RAD * np.radians(400.0 - 170.0))


def test_thing_in_the_hand_stops_one_finger_and_the_other_goes_on() -> None:
    hand = Tendons([DISTAL])
    hand.block("middle", np.radians(25.0))
    _, fingers = wound(hand, 130.0)
    assert fingers[0] == pytest.approx(25.0)
    assert fingers[1] == pytest.approx(80.0)
    hand.block("middle", None)
    _, fingers = wound(hand, 400.0)
    assert fingers[0] == pytest.approx(90.0)


def test_unknown_finger_is_refused() -> None:
    with pytest.raises(KeyError):
        Tendons([DISTAL]).block("thumb", 0.0)


def test_what_is_wound_at_an_angle_gives_that_angle() -> None:
    hand = Tendons([DISTAL])
    pulled = pull(hand, hand.wound_at(0, math.radians(110.0)))
    assert math.degrees(pulled.angle) == pytest.approx(110.0)


def test_slope_of_the_tension_is_its_derivative_in_every_segment() -> None:
    hand = Tendons([DISTAL])
    for degrees in (1.0, 20.0, 120.0, 175.0, 300.0):
        at = pull(hand, math.radians(degrees))
        after = pull(hand, math.radians(degrees) + 1e-6)
        assert (after.tension - at.tension) / 1e-6 == pytest.approx(at.slope, rel=1e-4)
        turned = (after.angle - at.angle) / 1e-6
        assert turned == pytest.approx(at.angle_slope, rel=1e-4, abs=1e-6)


def test_hall_bytes_add_up_to_the_position_of_the_axis() -> None:
    hand, halls = Tendons([DISTAL]), Halls([DISTAL])
    assert halls.places == ((5, 4), (5, 5))
    fingers = np.radians([30.0, 10.0])
    # (40 - 220.5) x -2.22 = 400.71 in two bytes: 244.755 - 66.6 and 244.755 - 22.2
    assert halls.read(fingers) == [178, 223]
    assert sum(halls.read(fingers)) == pytest.approx((40.0 - 220.5) * -2.22, abs=1.0)
    assert len(hand.fingers) == 2


def test_hall_byte_stays_a_byte() -> None:
    steep = tendon(
        FingerSpec(name="base", range_deg=(0.0, 90.0), hall=(0,)), ticks_per_deg=-2.5, zero_deg=-120
    )
    assert Halls([steep]).read(np.array([0.0])) == [255]


def test_joint_that_no_sensor_sees_does_not_count_in_the_angle() -> None:
    little = FingerSpec(name="little", range_deg=(0.0, 90.0), spring_nm_rad=SPRING)
    hand = Tendons([tendon(MIDDLE, little)])
    assert math.degrees(pull(hand, math.radians(400.0)).angle) == pytest.approx(90.0)
