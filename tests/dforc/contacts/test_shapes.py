import math

import numpy as np
import pytest

from dforc.contacts.shapes import (
    LinkCapsule,
    LinkShapes,
    ShapeTableError,
    capsules_between_joints,
)
from dforc.errors import NotFiniteError


def capsule(link: str = "arm", radius_m: float = 0.05, end: float = 0.2) -> LinkCapsule:
    return LinkCapsule(link=link, start_m=(0.0, 0.0, 0.0), end_m=(end, 0.0, 0.0), radius_m=radius_m)


def test_capsules_move_with_their_links() -> None:
    shapes = LinkShapes([capsule("arm"), capsule("hand"), capsule("arm", end=0.1)])
    quarter_about_z = np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])
    posed = shapes.posed(
        np.array([np.eye(3), quarter_about_z]), np.array([[0.0, 0.0, 1.0], [0.5, 0.0, 0.0]])
    )
    assert posed.links == ("arm", "hand")
    np.testing.assert_allclose(
        posed.end_m, [[0.2, 0.0, 1.0], [0.5, 0.2, 0.0], [0.1, 0.0, 1.0]], atol=1e-15
    )


def test_poses_by_name_are_those_of_the_links() -> None:
    shapes = LinkShapes([capsule("arm"), capsule("hand")])
    posed = shapes.posed_by(lambda link: (np.eye(3), np.full(3, float(len(link)))))
    np.testing.assert_allclose(posed.start_m, [[3.0] * 3, [4.0] * 3])


def test_only_some_links_keep_their_capsules() -> None:
    shapes = LinkShapes([capsule("arm"), capsule("hand"), capsule("arm")])
    assert shapes.only(["hand", "massless frame"]).links == ("hand",)
    assert len(shapes.only(["arm"]).capsules) == 2


def test_links_without_any_shape_are_refused() -> None:
    with pytest.raises(ShapeTableError, match="no capsule"):
        LinkShapes([capsule("arm")]).only(["leg"])


@pytest.mark.parametrize("radius_m", [0.0, -0.1])
def test_a_capsule_without_thickness_is_refused(radius_m: float) -> None:
    with pytest.raises(ShapeTableError, match="hand"):
        LinkShapes([capsule("arm"), capsule("hand", radius_m)])


def test_a_capsule_that_is_not_finite_is_refused() -> None:
    with pytest.raises(NotFiniteError):
        LinkShapes([capsule("arm", math.nan)])


def test_without_a_table_a_link_reaches_to_each_child_joint_once() -> None:
    made = capsules_between_joints({"chest": [(0.0, 0.1, 0.2)] * 2, "hand": []}, 0.03)
    assert [(c.link, c.end_m, c.radius_m) for c in made] == [
        ("chest", (0.0, 0.1, 0.2), 0.03),
        ("hand", (0.0, 0.0, 0.0), 0.03),
    ]
