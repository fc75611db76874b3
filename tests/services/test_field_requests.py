"""What the field is asked: goals, previews, information, and what it refuses."""

import math

import msgspec
import numpy as np
import pytest

from services.fields.messages import ACTIONS, FieldRequest
from services.messages import WorldObject
from services.robotfile.robot_tables import RobotFile
from services.streams import FIELD_CALL, VIRTUAL_POINT
from tests.services.field_stand import PERIOD_S, STILL, FieldStand, ball

PMP_FOR_3_S = FieldRequest(action="preview", mode="pmp", duration_s=3.0)


@pytest.fixture
def stand(robot: RobotFile) -> FieldStand:
    stand = FieldStand(robot)
    stand.run(0.05)
    return stand


def test_a_goal_is_numbered_and_taken_up(stand: FieldStand) -> None:
    goal = stand.goal(-0.05, 0.0, 0.0)
    assert stand.ask(FieldRequest(action="goal", goal=goal)).goal == 1
    assert stand.ask(FieldRequest(action="goal", goal=goal)).goal == 2  # asked for again: anew
    stand.run(3.0)
    status = stand.told()
    assert (status.goal, status.state) == (2, "arrived")


@pytest.mark.parametrize(
    ("request_", "why"),
    [
        (FieldRequest(action="dance"), "unknown action 'dance'; known: goal, stop, set, info"),
        (FieldRequest(action="goal"), "a goal is asked for, and none is given"),
        (FieldRequest(action="preview"), "there is no goal to preview; give one"),
        (FieldRequest(action="forget", source="x"), "no source 'x' of objects; there are: none"),
        (FieldRequest(action="set", mode="none"), "unknown mode 'none'"),
    ],
)
def test_what_cannot_be_done_is_refused_with_what_can(
    stand: FieldStand, request_: FieldRequest, why: str
) -> None:
    reply = stand.ask(request_)
    assert not reply.ok
    assert why in reply.reason


def test_a_preview_tells_the_path_that_is_then_gone(stand: FieldStand) -> None:
    stand.see(ball("ball", stand.beside(-0.1, 0.01, 0.0)))
    stand.run(PERIOD_S)
    goal = stand.goal(-0.2, 0.0, 0.0)
    found = stand.ask(FieldRequest(action="preview", goal=goal)).preview
    assert found is not None
    assert stand.bench.sent(VIRTUAL_POINT) == []
    assert found.arrives
    assert found.path[-1].position_m == pytest.approx(stand.beside(-0.2, 0.0, 0.0), abs=0.005)
    assert found.path[-1].t_s == pytest.approx(found.arrival_s)
    stand.send(goal)
    stand.run(found.arrival_s)
    gone = np.array([point.position_m for point in stand.bench.sent(VIRTUAL_POINT)])
    foreseen = np.array([point.position_m for point in found.path])
    count = len(gone) // 5
    assert foreseen[:count] == pytest.approx(gone[4::5][:count], abs=1e-12)
    centre = np.array(stand.beside(-0.1, 0.01, 0.0))
    closest = np.linalg.norm(gone - centre, axis=1).min() - 0.05
    assert found.closest_m == pytest.approx(closest, abs=1e-9)
    assert found.closest_to == "hand - ball"


def test_a_preview_of_another_mode_changes_nothing(stand: FieldStand) -> None:
    stand.send(stand.goal(-0.1, 0.0, 0.0))
    stand.run(0.3)
    before = len(stand.bench.sent(VIRTUAL_POINT))
    token = stand.bench.request(FIELD_CALL, PMP_FOR_3_S)
    stand.run(2.0)
    reply = dict(stand.bench.replies(FIELD_CALL))[token]
    assert reply.preview is not None
    assert reply.preview.mode == "pmp"
    assert reply.preview.path[0].q_rad != ()
    assert len(stand.bench.sent(VIRTUAL_POINT)) - before == 200  # not one period without a point
    assert {point.mode for point in stand.bench.sent(VIRTUAL_POINT)} == {"dforc"}


def test_a_preview_begins_where_the_point_is(stand: FieldStand) -> None:
    stand.send(stand.goal(-0.1, 0.0, 0.0))
    stand.run(0.5)
    point = stand.bench.last(VIRTUAL_POINT)
    found = stand.ask(FieldRequest(action="preview")).preview
    assert found is not None
    away = math.dist(found.path[0].position_m, point.position_m)
    assert away == pytest.approx(0.05 * math.hypot(*point.velocity_m_s), rel=0.2)


def test_a_preview_that_is_trapped_says_so(stand: FieldStand) -> None:
    stand.set(preset="paper")
    stand.see(ball("ball", stand.beside(-0.1, 0.0, 0.0)))
    stand.run(PERIOD_S)
    goal = stand.goal(-0.2, 0.0, 0.0)
    found = stand.ask(FieldRequest(action="preview", goal=goal, duration_s=15.0)).preview
    assert found is not None
    assert not found.arrives
    assert math.isnan(found.arrival_s)
    assert found.final_distance_m > 0.1
    assert "ulna field mode ulna" in found.reason


def test_a_preview_of_a_point_that_no_hand_can_follow_does_not_arrive(stand: FieldStand) -> None:
    goal = stand.goal(-0.9, 0.0, 0.0)
    found = stand.ask(FieldRequest(action="preview", goal=goal, duration_s=8.0)).preview
    assert found is not None
    assert (found.arrives, found.state) == (False, "unreachable")
    assert math.isnan(found.arrival_s)
    assert "beyond the reach of right_arm" in found.reason


def test_a_preview_lets_objects_go_on_as_they_move(stand: FieldStand) -> None:
    falling = ball("ball", stand.beside(-0.1, 0.0, 0.3), velocity_m_s=(0.0, 0.0, -0.2))
    stand.see(falling)
    stand.run(PERIOD_S)
    goal = stand.goal(0.0, 0.0, 0.0)
    longer = stand.goal(-0.1, 0.0, 0.0)
    still = stand.ask(FieldRequest(action="preview", goal=goal)).preview
    moved = stand.ask(FieldRequest(action="preview", goal=longer, duration_s=3.0)).preview
    assert still is not None
    assert moved is not None
    assert still.closest_m > 0.2
    assert moved.closest_m < 0.1


def test_a_preview_is_refused_while_the_hand_is_not_known(robot: RobotFile) -> None:
    stand = FieldStand(robot)
    stand.states.clear()
    reply = stand.ask(FieldRequest(action="preview", goal=stand.goal(0.0, 0.0, 0.0)))
    assert not reply.ok
    assert "where the hand is is not known: no joint states of torso" in reply.reason


@pytest.mark.parametrize("duration_s", [-1.0, 61.0, math.nan])
def test_a_preview_lasts_a_minute_at_most(stand: FieldStand, duration_s: float) -> None:
    goal = stand.goal(0.0, 0.0, 0.0)
    reply = stand.ask(FieldRequest(action="preview", goal=goal, duration_s=duration_s))
    assert not reply.ok
    assert "up to 60 s" in reply.reason


def test_more_previews_than_can_wait_are_refused(stand: FieldStand) -> None:
    goal = stand.goal(-0.1, 0.0, 0.0)
    for _ in range(9):
        stand.bench.request(FIELD_CALL, FieldRequest(action="preview", goal=goal))
    stand.run(PERIOD_S)
    ((_, reply),) = stand.bench.replies(FIELD_CALL)
    assert not reply.ok
    assert "8 previews wait already" in reply.reason


def test_info_tells_modes_gains_limbs_and_what_the_sources_sent(stand: FieldStand) -> None:
    item = ball("ball", STILL)
    stand.see(item, source="eyes")
    stand.run(PERIOD_S)
    info = stand.ask(FieldRequest(action="info")).info
    assert info is not None
    assert (info.mode, info.limb, info.limbs) == ("dforc", "right_arm", ("right_arm",))
    assert [mode.name for mode in info.modes] == ["ulna", "dforc", "pmp"]
    stiffness = {mode.name: mode.gains[0] for mode in info.modes}["dforc"]
    assert (stiffness.name, stiffness.unit, stiffness.paper) == ("K", "N/m", 4.0)
    assert [(source.source, source.objects) for source in info.sources] == [("eyes", (item,))]


def test_stop_withdraws_the_goal(stand: FieldStand) -> None:
    stand.send(stand.goal(-0.1, 0.0, 0.0))
    stand.run(0.2)
    assert stand.ask(FieldRequest(action="stop")).ok
    before = len(stand.bench.sent(VIRTUAL_POINT))
    stand.run(0.2)
    assert len(stand.bench.sent(VIRTUAL_POINT)) == before
    status = stand.told()
    assert (status.state, status.reason) == ("idle", "goal 1 was withdrawn")
    assert (status.goal, status.last_goal) == (0, 1)
    assert all(math.isnan(value) for value in (*status.goal_position_m, status.goal_distance_m))
    stand.ask(FieldRequest(action="goal", goal=stand.goal(-0.1, 0.0, 0.0)))
    status = stand.told()
    assert (status.goal, status.last_goal, status.reason) == (2, 2, "")


def test_forgotten_objects_are_in_the_way_no_more(stand: FieldStand) -> None:
    stand.see(ball("ball", stand.beside(-0.1, 0.0, 0.0)), source="eyes")
    stand.run(PERIOD_S)
    assert stand.ask(FieldRequest(action="forget", source="eyes")).forgotten == 1
    stand.run(0.05)
    assert [field.name for field in stand.told().fields] == []


def test_every_action_is_documented() -> None:
    assert FieldRequest.__doc__ is not None
    assert [action for action in ACTIONS if f"\n    {action} " not in FieldRequest.__doc__] == []


def test_a_target_is_followed_with_its_velocity(stand: FieldStand) -> None:
    def at(place: float) -> WorldObject:
        x, y, z = stand.beside(-0.05, 0.0, place)
        return ball("target", (x, y, z), velocity_m_s=(0.0, 0.0, 0.05), role="target")

    stand.see(at(0.0))
    stand.run(PERIOD_S)
    goal = stand.goal(0.0, 0.0, 0.0, follow="target")
    assert stand.ask(FieldRequest(action="goal", goal=goal)).ok
    for i in range(200):
        stand.see(at(0.0005 * i))
        stand.run(PERIOD_S)
    status = stand.told()
    assert status.state == "reaching"
    (field,) = status.fields
    assert (field.name, field.kind, field.note) == ("target", "target", "followed")
    # eq. 3 lags by D/K of the target's velocity
    assert field.distance_m == pytest.approx(0.05 * 6.0 / 9.0, rel=0.1)


def test_a_target_that_is_lost_is_waited_for(stand: FieldStand) -> None:
    moving = ball(
        "target", stand.beside(-0.1, 0.0, 0.0), velocity_m_s=(0.0, 0.1, 0.0), role="target"
    )
    stand.see(moving)
    stand.run(PERIOD_S)
    stand.ask(FieldRequest(action="goal", goal=stand.goal(0.0, 0.0, 0.0, follow="target")))
    stand.run(2.0)
    status = stand.told()
    assert status.state == "waiting"
    assert "object 'target' is lost: last seen" in status.reason
    speed = math.hypot(*stand.bench.last(VIRTUAL_POINT).velocity_m_s)
    assert speed < 0.001
    stand.see(msgspec.structs.replace(moving, velocity_m_s=STILL))
    stand.run(0.1)
    assert stand.told().state == "reaching"


def test_what_is_not_there_is_not_followed(stand: FieldStand) -> None:
    stand.see(ball("cube", STILL))
    stand.run(PERIOD_S)
    goal = stand.goal(0.0, 0.0, 0.0, follow="cub")
    reply = stand.ask(FieldRequest(action="goal", goal=goal))
    assert reply.reason == "no object 'cub' to follow; there are: cube"
    stand.send(goal)  # by stream: the object may come later
    stand.run(0.1)
    assert stand.told().reason == reply.reason


def test_an_object_that_holds_the_hand_is_marked_and_pushes_it_out(stand: FieldStand) -> None:
    stand.set(gains=(("G", 1.0),))
    stand.see(ball("ball", stand.beside(0.02, 0.0, 0.0)))
    stand.send(stand.goal(-0.2, 0.0, 0.0))
    fields = {field.name: field for field in stand.told().fields}
    assert fields["ball"].note == "the hand is 28 mm inside"
    # G exp(-q): 22 mm from the centre of a ball of 50 mm with a margin of 20 mm
    assert fields["ball"].force_n == pytest.approx(math.exp(-((22 / 70) ** 2)), abs=0.01)
    stand.run(3.0)
    assert stand.told().state == "arrived"


def test_what_is_off_has_no_effect_and_is_listed(stand: FieldStand) -> None:
    stand.see(ball("ball", stand.beside(-0.1, 0.0, 0.0), on=False))
    stand.send(stand.goal(-0.2, 0.0, 0.0))
    stand.run(3.0)
    status = stand.told()
    assert status.state == "arrived"
    path = np.array([point.position_m for point in stand.bench.sent(VIRTUAL_POINT)])
    assert np.abs(path[:, 1] - stand.home_m[1]).max() < 1e-9  # straight through
    fields = {field.name: field.on for field in status.fields}
    assert fields == {"goal": True, "ball": False}
