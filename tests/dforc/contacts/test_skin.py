import pytest

from dforc.contacts.skin import SkinContact, SkinContacts, SkinPatch, UnknownBoardError
from dforc.errors import ShapeError

NO_LOAD = 240
OK = bytes(16)
TRIANGLES = tuple((0.01 * triangle, 0.0, 0.0) for triangle in range(16))
HAND = SkinPatch(
    board="hand skin", limb="arm", link="hand", point_m=(0.0, 0.0, 0.1), triangles_m=TRIANGLES
)
NEAR = SkinPatch(board="near skin", limb="arm", link="forearm", point_m=(0.0, 0.2, 0.0))
FAR = SkinPatch(board="far skin", limb="arm", link="forearm", point_m=(0.0, 0.4, 0.0))
FOOT = SkinPatch(board="foot skin", limb="leg", link="foot", point_m=(0.0, 0.0, 0.0))


def taxels(pressed: dict[int, int]) -> bytes:
    return bytes(NO_LOAD - pressed.get(taxel, 0) for taxel in range(192))


def felt(**pressed: dict[int, int]) -> tuple[SkinContact, ...]:
    skin = SkinContacts([HAND, NEAR, FAR, FOOT])
    for name, levels in pressed.items():
        skin.hear(f"{name} skin", taxels(levels), OK, NO_LOAD, 1_000_000_000)
    return skin.contacts(1_000_000_000)


def test_untouched_skin_is_no_contact() -> None:
    assert felt(hand={}, near={}) == ()


def test_a_taxel_that_only_wavers_is_not_pressed() -> None:
    assert felt(hand={5: 9}) == ()
    assert felt(hand={5: 10})[0].taxels == 1


def test_the_point_is_weighted_with_the_pressure_of_the_triangles() -> None:
    (contact,) = felt(hand={12: 10, 36: 30})  # triangles 1 and 3, at 0.01 and 0.03
    assert contact.link == "hand"
    assert contact.point_m == pytest.approx((0.025, 0.0, 0.0))
    assert contact.pressure == 40.0
    assert contact.taxels == 2


def test_two_boards_of_a_link_are_one_contact() -> None:
    (contact,) = felt(near={0: 10}, far={0: 30})
    assert contact.link == "forearm"
    assert contact.point_m == pytest.approx((0.0, 0.35, 0.0))


def test_a_small_contact_that_is_alone_keeps_its_moment() -> None:
    assert felt(hand={0: 50})[0].kind == "wrench"


def test_a_small_contact_beside_another_of_its_limb_is_a_pure_force() -> None:
    hand, forearm = felt(hand={0: 50}, near=dict.fromkeys(range(10), 50))
    assert (hand.kind, forearm.kind) == ("force", "wrench")
    hand, forearm = felt(hand={0: 50}, near=dict.fromkeys(range(9), 50))
    assert (hand.kind, forearm.kind) == ("force", "force")


def test_a_contact_of_another_limb_does_not_matter() -> None:
    assert [contact.kind for contact in felt(hand={0: 50}, foot={0: 50})] == ["wrench", "wrench"]


def test_a_triangle_that_was_not_read_feels_nothing() -> None:
    skin = SkinContacts([HAND])
    errors = bytes([0, 1, *[0] * 14])
    skin.hear("hand skin", taxels({0: 20, 12: 200}), errors, NO_LOAD, 0)
    assert skin.contacts(0)[0].pressure == 20.0


def test_a_board_counts_for_two_tenths_of_a_second_after_its_last_word() -> None:
    skin = SkinContacts([HAND])
    skin.hear("hand skin", taxels({0: 50}), OK, NO_LOAD, 1_000_000_000)
    assert len(skin.contacts(1_200_000_000)) == 1
    assert skin.contacts(1_200_000_001) == ()


def test_a_released_board_is_no_contact_at_once() -> None:
    skin = SkinContacts([HAND])
    skin.hear("hand skin", taxels({0: 50}), OK, NO_LOAD, 0)
    skin.hear("hand skin", taxels({}), OK, NO_LOAD, 0)
    assert skin.contacts(0) == ()


def test_a_board_without_a_place_is_refused_by_name() -> None:
    with pytest.raises(UnknownBoardError, match=r"'belly'.*hand skin"):
        SkinContacts([HAND]).hear("belly", taxels({}), OK, NO_LOAD, 0)


def test_a_sample_of_another_size_is_refused() -> None:
    with pytest.raises(ShapeError, match="191 taxels"):
        SkinContacts([HAND]).hear("hand skin", bytes(191), OK, NO_LOAD, 0)


def test_a_patch_with_some_of_its_triangles_is_refused() -> None:
    patch = SkinPatch(
        board="b", limb="l", link="k", point_m=(0.0, 0.0, 0.0), triangles_m=TRIANGLES[:15]
    )
    with pytest.raises(ShapeError, match="15 triangles"):
        SkinContacts([patch])
