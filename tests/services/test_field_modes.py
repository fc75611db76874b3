"""Modes and gains of the field, changed while a point is in motion."""

import msgspec
import numpy as np
import pytest

from dforc import rotation
from services.config import load_robot
from services.core.errors import ConfigError
from services.fields.gains import TABLES, changed_gains, initial_gains
from services.fields.messages import FieldRequest
from services.messages import VirtualPoint
from services.reaching.limb import limb_model
from services.robotfile.robot_tables import RobotFile
from services.streams import VIRTUAL_POINT
from tests.services.field_stand import FieldStand, ball


@pytest.fixture
def stand(robot: RobotFile) -> FieldStand:
    stand = FieldStand(robot)
    stand.run(0.05)
    return stand


def steps_m(points: list[VirtualPoint]) -> float:
    """Largest distance from one point to the next."""
    path = np.array([point.position_m for point in points])
    return float(np.linalg.norm(np.diff(path, axis=0), axis=1).max())


def test_the_mode_in_use_at_first_is_ulna(robot: RobotFile) -> None:
    assert FieldStand(robot, "ulna").told().mode == "ulna"


@pytest.mark.parametrize("modes", [("dforc", "pmp"), ("pmp", "dforc"), ("dforc", "ulna")])
def test_a_change_of_mode_does_not_make_the_point_jump(
    robot: RobotFile, modes: tuple[str, str]
) -> None:
    stand = FieldStand(robot, modes[0])
    stand.run(0.05)
    stand.send(stand.goal(-0.08, 0.0, 0.0))
    stand.run(0.4)
    assert stand.set(modes[1]).mode == modes[1]
    stand.run(0.2)
    points = stand.bench.sent(VIRTUAL_POINT)
    assert {point.mode for point in points} == set(modes)
    assert steps_m(points) < 0.002  # 0.2 m/s


def test_a_change_of_gains_does_not_make_the_point_jump(stand: FieldStand) -> None:
    stand.send(stand.goal(-0.1, 0.0, 0.0))
    stand.run(0.4)
    reply = stand.set(gains=(("K", 40.0), ("D", 12.0)))
    assert dict(reply.gains)["K"] == 40.0
    stand.run(0.2)
    points = stand.bench.sent(VIRTUAL_POINT)
    assert steps_m(points) < 0.003
    speeds = np.array([point.velocity_m_s for point in points])
    assert np.abs(np.diff(speeds, axis=0)).max() < 0.04  # 4 N on 1 kg for 10 ms, not more


def test_the_papers_gains_are_taken_in_one_go(stand: FieldStand) -> None:
    gains = dict(stand.set(preset="paper").gains)
    assert (gains["K"], gains["D"], gains["G"], gains["T"], gains["margin"]) == (4, 8, 10, 0.6, 0)
    assert dict(stand.set(preset="default").gains)["K"] == 9.0


def test_what_the_papers_do_not_have_is_at_its_default_among_theirs() -> None:
    before = initial_gains("ulna") | {"speed": 0.1, "margin": 0.05, "K": 30.0}
    gains = changed_gains("ulna", before, (), "paper")
    assert (gains["K"], gains["D"], gains["T"]) == (4.0, 8.0, 0.6)
    assert (gains["speed"], gains["margin"], gains["self_margin"]) == (0.3, 0.02, 0.005)


def test_the_point_carries_mode_and_trajectory_time(stand: FieldStand) -> None:
    stand.set(gains=(("T", 0.6),))
    stand.send(stand.goal(-0.1, 0.0, 0.0))
    stand.run(0.02)
    point = stand.bench.last(VIRTUAL_POINT)
    assert (point.mode, point.trajectory_time_s, point.q_rad) == ("dforc", 0.6, ())


@pytest.mark.parametrize("mode", ["pmp", "ulna"])
def test_a_mode_that_keeps_a_posture_sends_one_whose_hand_is_the_point(
    robot: RobotFile, mode: str
) -> None:
    stand = FieldStand(robot, mode)
    stand.run(0.05)
    stand.send(stand.goal(-0.05, 0.0, 0.0))
    stand.run(0.3)
    point = stand.bench.last(VIRTUAL_POINT)
    turned, place = limb_model(robot).tip_pose(np.array(point.q_rad))
    assert place == pytest.approx(np.array(point.position_m), abs=1e-9)
    assert rotation.rotation_vector(turned) == pytest.approx(np.array(point.rotation_rad), abs=1e-9)
    assert len(point.dq_rad_s) == 10


def test_dforc_says_where_it_is_trapped_and_what_would_help(stand: FieldStand) -> None:
    stand.set(preset="paper")
    stand.see(ball("wall", stand.beside(-0.1, 0.0, 0.0)))
    stand.send(stand.goal(-0.2, 0.0, 0.0))
    stand.run(15.0)
    status = stand.told()
    assert status.state == "waiting"
    assert "`ulna field mode ulna`" in status.reason


def test_pmp_with_the_papers_time_base_says_that_it_has_run_out(robot: RobotFile) -> None:
    stand = FieldStand(robot, "pmp")
    stand.set(preset="paper")
    stand.send(stand.goal(-0.15, 0.0, 0.1))
    stand.run(3.5)
    status = stand.told()
    assert status.state == "waiting"
    assert "gamma=0" in status.reason


def test_pmp_refuses_a_limb_with_two_hands() -> None:
    stand = FieldStand(load_robot("icub:arms"), "pmp")
    stand.run(0.05)
    reply = stand.ask(FieldRequest(action="goal", goal=stand.goal(0.0, 0.0, 0.0, limb="both_arms")))
    assert not reply.ok
    assert "moves one hand, both_arms has two" in reply.reason


def test_dforc_moves_both_hands_at_once() -> None:
    stand = FieldStand(load_robot("icub:arms"), "dforc")
    stand.run(0.05)
    x, y, z = stand.beside(0.0, 0.0, 0.0)
    goal = msgspec.structs.replace(
        stand.goal(0.0, 0.0, 0.0, limb="both_arms"),
        position_m=(x, -y, z + 0.05),
        second_position_m=(x, y, z + 0.05),
    )
    stand.send(goal)
    stand.run(4.0)
    point = stand.bench.last(VIRTUAL_POINT)
    assert point.limb == "both_arms"
    assert point.position_m == pytest.approx((x, -y, z + 0.05), abs=1e-3)
    assert point.second_position_m == pytest.approx((x, y, z + 0.05), abs=1e-3)
    assert point.second_rotation_rad is None


@pytest.mark.parametrize(
    ("mode", "changes", "preset", "why"),
    [
        ("sliding", (), "", "unknown mode 'sliding'; known: ulna, dforc, pmp"),
        ("dforc", (("Q", 1.0),), "", "mode dforc has no gain 'Q'; it has K, D, G, T, margin"),
        ("dforc", (("K", -1.0),), "", "K of mode dforc is 0 to 400 N/m, not -1"),
        ("dforc", (("K", float("nan")),), "", "K of mode dforc is 0 to 400 N/m, not nan"),
        ("dforc", (("T", 0.05),), "", "T is 0 or at least 0.1 s, not 0.05"),
        ("pmp", (("variant", 0.5),), "", "variant of mode pmp is 0 or 1, not 0.5"),
        ("ulna", (), "best", "unknown preset 'best'; known: default, paper"),
    ],
)
def test_what_is_no_gain_is_refused_by_name(
    mode: str, changes: tuple[tuple[str, float], ...], preset: str, why: str
) -> None:
    with pytest.raises(ConfigError, match=why.replace("(", r"\(")):
        changed_gains(mode, initial_gains(mode) if mode in TABLES else {}, changes, preset)


def test_a_refused_change_leaves_mode_and_gains(stand: FieldStand) -> None:
    reply = stand.set("pmp", gains=(("K", 1e9),))
    assert not reply.ok
    status = stand.told()
    assert status.mode == "dforc"
    assert dict(status.gains)["K"] == 9.0


@pytest.mark.parametrize("mode", sorted(TABLES))
def test_every_default_and_every_value_of_the_papers_is_in_bounds(mode: str) -> None:
    for preset in ("default", "paper"):
        gains = changed_gains(mode, {}, (), preset)
        assert changed_gains(mode, {}, tuple(gains.items())) == gains
