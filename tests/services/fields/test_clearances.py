"""Distances are told of objects where they are, whatever room is kept around them."""

import numpy as np
import pytest

from dforc.collision.obstacles import sphere
from services.fields.arm_clearance import solids_of
from services.fields.around import around_limb
from services.fields.clearances import hand_clearance, surface_distances
from services.fields.mode import HandPoint, Surroundings
from services.fields.seen import SeenObject, Sighting

NOWHERE = np.zeros(0)
HAND = (HandPoint(position_m=np.array((0.1, 0.0, 0.0)), rotation=np.eye(3)),)


def beside(speed_m_s: float) -> Surroundings:
    """A ball of 4 cm around the origin that comes towards the hand."""
    ball = sphere("ball", (0.0, 0.0, 0.0), 0.04)
    velocity = (speed_m_s, 0.0, 0.0)
    kept = Sighting((0.005, 0.0, 0.0), velocity, 0.004)
    one = SeenObject(
        name="ball", source="", solid=ball, role="obstacle", on=True, sigma_m=0.003, avoided=kept
    )
    return around_limb((one,), None, (NOWHERE, NOWHERE))


@pytest.mark.parametrize("speed_m_s", [0.0, 0.4, 1.5])
def test_of_a_hand_from_a_ball_that_moves_is_that_of_now(speed_m_s: float) -> None:
    around = beside(speed_m_s)
    assert surface_distances(HAND, around) == pytest.approx([0.06])
    clearance_m, nearest = hand_clearance(HAND, around)
    assert clearance_m == pytest.approx(0.06)
    assert nearest == ("hand", "ball")


def test_solids_are_where_the_objects_are_and_have_no_margin() -> None:
    around = beside(0.4)
    assert around.world.margins[0] > 0.05
    solids = solids_of(around)
    assert solids.centres.tolist() == [[0.0, 0.0, 0.0]]
    assert solids.margins.tolist() == [0.0]
    assert solids_of(Surroundings()).centres.shape == (0, 3)
