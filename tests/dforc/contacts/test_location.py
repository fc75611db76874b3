import math

import numpy as np
import pytest

from dforc.arrays import Vector
from dforc.contacts import location
from dforc.contacts.location import Location, WrenchNoise, locate
from dforc.contacts.shapes import LinkCapsule, LinkShapes, PosedShapes
from dforc.errors import NotFiniteError

ORIGIN = np.zeros(3)


def posed(*capsules: LinkCapsule) -> PosedShapes:
    shapes = LinkShapes(capsules)
    count = len(shapes.links)
    return shapes.posed(np.tile(np.eye(3), (count, 1, 1)), np.zeros((count, 3)))


def rod(link: str, start: float, end: float, y: float = 0.0) -> LinkCapsule:
    return LinkCapsule(link=link, start_m=(start, y, 0.0), end_m=(end, y, 0.0), radius_m=0.03)


# An arm along x: the sensor at its root, 3 cm thick.
ARM = posed(rod("upper", 0.03, 0.12), rod("fore", 0.2, 0.3), rod("hand", 0.4, 0.45))


def pushed(force: tuple[float, ...], at: tuple[float, ...], shapes: PosedShapes = ARM) -> Location:
    f, p = np.array(force), np.array(at)
    return locate(f, np.cross(p, f), ORIGIN, shapes)


@pytest.mark.parametrize(("x", "link"), [(0.08, "upper"), (0.25, "fore"), (0.42, "hand")])
def test_a_push_from_above_is_found_where_its_line_enters(x: float, link: str) -> None:
    found = pushed((0.0, 0.0, -10.0), (x, 0.0, 0.03))
    assert (found.link, found.certainty) == (link, "sure")
    np.testing.assert_allclose(found.point_m, [x, 0.0, 0.03], atol=0.003)


def test_the_surface_is_on_the_side_that_the_force_comes_from() -> None:
    found = pushed((0.0, 8.0, 0.0), (0.25, -0.03, 0.0))
    np.testing.assert_allclose(found.point_m, [0.25, -0.03, 0.0], atol=0.003)


def test_a_known_point_elsewhere_gives_the_same_place() -> None:
    force, at = np.array([0.0, 0.0, -10.0]), np.array([0.25, 0.0, 0.03])
    known = np.array([-0.3, 0.2, 0.1])
    found = locate(force, np.cross(at - known, force), known, ARM)
    assert (found.link, found.certainty) == ("fore", "sure")
    np.testing.assert_allclose(found.point_m, at, atol=0.003)


def test_a_force_that_could_push_two_links_is_unsure() -> None:
    across = posed(rod("near", 0.0, 0.3, y=0.0), rod("behind", 0.0, 0.3, y=0.2))
    found = pushed((0.0, 10.0, 0.0), (0.15, -0.03, 0.0), across)
    assert found.certainty == "unsure"
    assert found.share < 0.6
    assert "several links" in found.reason


def test_a_force_beside_every_link_is_unsure() -> None:
    found = pushed((0.0, 0.0, -10.0), (0.25, 0.2, 0.0))
    assert (found.link, found.certainty) == ("", "unsure")
    np.testing.assert_array_equal(found.point_m, ORIGIN)


@pytest.mark.parametrize(("degrees", "certainty"), [(30.0, "sure"), (75.0, "unsure")])
def test_a_force_that_would_slide_off_is_no_sure_contact(degrees: float, certainty: str) -> None:
    angle = math.radians(degrees)
    force = (10.0 * math.sin(angle), 0.0, -10.0 * math.cos(angle))
    found = pushed(force, (0.25, 0.0, 0.03), posed(rod("fore", 0.2, 0.3)))
    assert (found.link, found.certainty) == ("fore", certainty)


def test_a_moment_along_the_force_is_not_from_a_pure_force() -> None:
    force = np.array([0.0, 0.0, -10.0])
    moment = np.cross([0.25, 0.0, 0.03], force)
    clean = locate(force, moment, ORIGIN, ARM)
    turned = locate(force, moment + np.array([0.0, 0.0, 0.2]), ORIGIN, ARM)
    assert clean.certainty == "sure"
    assert turned.certainty == "unsure"
    assert "pure force" in turned.reason


def test_a_moment_along_the_force_within_the_noise_is_nothing() -> None:
    force = np.array([0.0, 0.0, -10.0])
    moment = np.cross([0.25, 0.0, 0.03], force) + np.array([0.0, 0.0, 0.2])
    noise = WrenchNoise(force_n=0.05, moment_nm=0.06)
    assert locate(force, moment, ORIGIN, ARM, noise).certainty == "sure"


def test_more_noise_makes_a_narrow_link_unsure() -> None:
    force = np.array([0.0, 0.0, -5.0])
    moment = np.cross([0.38, 0.0, 0.03], force)
    assert locate(force, moment, ORIGIN, ARM).certainty == "sure"
    noisy = locate(force, moment, ORIGIN, ARM, WrenchNoise(force_n=1.0, moment_nm=0.5))
    assert noisy.certainty == "unsure"


def test_a_small_force_is_unsure() -> None:
    found = pushed((0.0, 0.0, -0.9), (0.25, 0.0, 0.03))
    assert (found.link, found.reason) == ("", "the force is too small")


def test_an_end_of_one_capsule_inside_another_of_its_link_is_no_surface() -> None:
    bent = posed(rod("arm", 0.0, 0.1), rod("arm", 0.1, 0.2))
    found = pushed((0.0, 0.0, -10.0), (0.1, 0.0, 0.03), bent)
    assert (found.link, found.certainty) == ("arm", "sure")
    np.testing.assert_allclose(found.point_m, [0.1, 0.0, 0.03], atol=0.003)


def test_along_a_bent_link_only_its_outer_surface_is_pushed() -> None:
    bent = posed(rod("arm", 0.0, 0.1), rod("arm", 0.1, 0.2))
    found = pushed((10.0, 0.0, 0.0), (-0.03, 0.0, 0.0), bent)
    np.testing.assert_allclose(found.point_m, [-0.03, 0.0, 0.0], atol=0.003)


def test_surface_inside_another_link_is_not_pushed() -> None:
    jointed = posed(rod("fore", 0.2, 0.3), rod("hand", 0.3, 0.4))
    found = pushed((10.0, 0.0, 0.0), (0.17, 0.0, 0.0), jointed)
    assert (found.link, found.certainty) == ("fore", "sure")


def test_the_same_wrench_gives_the_same_answer_twice() -> None:
    first = pushed((1.0, 2.0, -10.0), (0.25, 0.0, 0.03))
    again = pushed((1.0, 2.0, -10.0), (0.25, 0.0, 0.03))
    np.testing.assert_array_equal(first.point_m, again.point_m)
    assert first.share == again.share


@pytest.mark.parametrize("bad", [math.nan, math.inf])
def test_a_wrench_that_is_not_finite_is_refused(bad: float) -> None:
    moment: Vector = np.array([0.0, bad, 0.0])
    with pytest.raises(NotFiniteError):
        locate(np.array([0.0, 0.0, -10.0]), moment, ORIGIN, ARM)


def test_lines_enter_capsules_where_small_steps_along_them_do() -> None:
    generator = np.random.default_rng(5)
    shapes = posed(rod("a", -0.1, 0.1), rod("ball", 0.05, 0.05, y=0.05))
    points = generator.uniform(-0.05, 0.05, (200, 3))
    directions = generator.normal(size=(200, 3))
    directions /= np.linalg.norm(directions, axis=1)[:, None]
    s, hit = location._first_crossing(points, directions, shapes)
    steps = np.arange(-0.4, 0.4, 2e-4)
    for line in range(200):
        walked = points[line] + steps[:, None] * directions[line]
        for capsule, (low, high, y) in enumerate([(-0.1, 0.1, 0.0), (0.05, 0.05, 0.05)]):
            nearest = np.stack(
                [np.clip(walked[:, 0], low, high), np.full(len(steps), y), 0.0 * steps], axis=1
            )
            inside = np.linalg.norm(walked - nearest, axis=1) < 0.03
            if inside.sum() > 1:
                assert hit[line, capsule]
                assert abs(s[line, capsule] - steps[inside.argmax()]) < 3e-4
            elif not inside.any() and hit[line, capsule]:  # grazed between two steps
                on_line = points[line] + s[line, capsule] * directions[line]
                foot = [np.clip(on_line[0], low, high), y, 0.0]
                assert np.linalg.norm(on_line - foot) == pytest.approx(0.03, abs=1e-6)


def test_answers_to_any_wrench_are_finite() -> None:
    generator = np.random.default_rng(6)
    for scale in 10.0 ** generator.uniform(-3, 3, 300):
        found = locate(scale * generator.normal(size=3), generator.normal(size=3), ORIGIN, ARM)
        assert np.isfinite(found.point_m).all()
        assert 0.0 <= found.share <= 1.0
