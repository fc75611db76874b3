"""Who commands the hand, as the field sees it."""

import pytest

from services.core.clock import NS_PER_MS
from services.fields.takeover import Takeover
from services.messages import NAN3, CartesianStatus

ARM = "right_arm"


def status(mode: str, reason: str = "", limb: str = ARM) -> CartesianStatus:
    return CartesianStatus(
        stamp_ns=0,
        state="waiting",
        q_rad=(),
        hand_position_m=NAN3,
        hand_rotation_rad=NAN3,
        mode=mode,
        limb=limb,
        reason=reason,
    )


def after(takeover: Takeover, milliseconds: int, told: CartesianStatus | None) -> str:
    """The reason once a status has lasted for so long."""
    takeover.reason(0, ARM, told)
    return takeover.reason(milliseconds * NS_PER_MS, ARM, told)


@pytest.mark.parametrize("mode", ["idle", "field"])
def test_the_point_goes_where_nobody_else_commands(mode: str) -> None:
    assert after(Takeover(), 1000, status(mode)) == ""
    assert after(Takeover(), 1000, None) == ""


@pytest.mark.parametrize("mode", ["pose", "tracking", "velocity", "stopping"])
def test_a_request_that_commands_for_a_tenth_of_a_second_has_taken_over(mode: str) -> None:
    takeover = Takeover()
    assert after(takeover, 99, status(mode)) == ""
    assert f"(mode {mode}); give the goal again" in after(takeover, 100, status(mode))


def test_what_was_taken_over_stays_so_until_the_goal_is_given_again() -> None:
    takeover = Takeover()
    after(takeover, 200, status("pose"))
    assert takeover.reason(300 * NS_PER_MS, ARM, status("idle")) != ""
    takeover.begin(400 * NS_PER_MS, ARM, status("idle"))
    assert takeover.reason(400 * NS_PER_MS, ARM, status("idle")) == ""


def test_a_new_goal_pauses_where_a_request_commands_so_that_the_points_are_heard() -> None:
    takeover = Takeover()
    takeover.begin(0, ARM, status("pose"))
    assert takeover.reason(119 * NS_PER_MS, ARM, status("pose")) == "taking over from a request"
    assert takeover.reason(120 * NS_PER_MS, ARM, status("pose")) == ""


def test_another_limb_that_stops_makes_room() -> None:
    assert after(Takeover(), 1000, status("stopping", limb="left_arm")) == ""


def test_joints_that_take_no_set_points_are_waited_for() -> None:
    takeover = Takeover()
    halted = status("field", reason="r_elbow is in idle")
    assert after(takeover, 100, halted) == "r_elbow is in idle"
    assert takeover.reason(200 * NS_PER_MS, ARM, status("field")) == ""
