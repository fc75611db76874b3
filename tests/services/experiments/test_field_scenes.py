"""Whole-arm scenes: who judges them, how they are drawn, how a run is counted."""

from dataclasses import replace

import numpy as np
import pytest

from dforc.collision.obstacles import Obstacle, box, cylinder, ellipsoid, sphere
from services.experiments.whole_arm.draw import (
    CLEAR_M,
    FAMILIES,
    LONGEST_M,
    SELF_CLEAR_M,
    SHORTEST_M,
    ArmScene,
    family_scene,
    random_scene,
)
from services.experiments.whole_arm.jobs import Job, do, jobs_of, setting_for
from services.experiments.whole_arm.laws import Answer, Seen, ellipsoids
from services.experiments.whole_arm.lineup import make_law
from services.experiments.whole_arm.referee import Array, Capsule, Referee, Standing, Verdict
from services.experiments.whole_arm.rows import answer_rows, rate_rows
from services.experiments.whole_arm.run import Moment, Outcome, run
from services.experiments.whole_arm.setting import ArmSetting
from services.robotfile.model_file import urdf_path

URDF = str(urdf_path("iCubLisboa01"))
HAND = "r_hand_dh_frame"


@pytest.fixture(scope="module")
def setting() -> ArmSetting:
    return setting_for("1")


@pytest.fixture(scope="module")
def balls(setting: ArmSetting) -> ArmScene:
    return random_scene(setting, 5, 0, 0)


def one_ball_on_the_hand() -> Referee:
    """A judge whose only capsule is a ball of 4 cm at the hand."""
    capsule = Capsule("hand", HAND, (0.0, 0.0, 0.0), (0.0, 0.0, 0.0), 0.04)
    return Referee(URDF, ["torso_yaw"], [capsule], [], ["torso_yaw"])


def away_from_hand(referee: Referee, d: Array) -> tuple[float, float, float]:
    x, y, z = (referee.frame_pose(np.zeros(1), HAND)[1] + d).tolist()
    return x, y, z


@pytest.mark.parametrize(
    ("make", "reach_m"),
    [
        (lambda at: sphere("a", at, 0.05), 0.05),
        (lambda at: ellipsoid("a", at, (0.07, 0.02, 0.03)), 0.07),
        (lambda at: box("a", at, (0.06, 0.02, 0.03)), 0.06),
        (lambda at: cylinder("a", at, 0.04, 0.02), 0.04),
    ],
)
def test_the_referee_measures_every_shape_along_its_first_axis(
    make: "object", reach_m: float
) -> None:
    referee = one_ball_on_the_hand()
    assert callable(make)
    obstacle = make(away_from_hand(referee, np.array([0.2, 0.0, 0.0])))
    assert isinstance(obstacle, Obstacle)
    referee.face([obstacle])
    near = referee.obstacle(np.zeros(1))
    assert near.distance_m == pytest.approx(0.2 - reach_m - 0.04, abs=1e-4)
    assert near.pair == ("hand", "a")


def test_the_referee_counts_how_deep_a_ball_is_entered() -> None:
    referee = one_ball_on_the_hand()
    referee.face([sphere("a", away_from_hand(referee, np.array([0.05, 0.0, 0.0])), 0.03)])
    assert referee.obstacle(np.zeros(1)).distance_m == pytest.approx(-0.02, abs=1e-9)


def test_the_referee_leaves_out_what_the_limb_does_not_move() -> None:
    pelvis = Capsule("pelvis", "root_link", (0.0, 0.0, 0.0), (0.0, 0.0, 0.1), 0.05)
    referee = Referee(URDF, ["torso_yaw"], [pelvis], [], ["torso_yaw"])
    referee.face([sphere("a", (0.0, 0.0, 0.0), 0.05)])
    assert referee.obstacle(np.zeros(1)).distance_m == np.inf


def test_the_referee_sees_a_contact_between_two_ticks() -> None:
    # a ball of 1 cm crosses the hand's line: far on one side, then far on the other
    referee = one_ball_on_the_hand()
    aside = np.array([0.0, 0.0, 0.1])
    hand = referee.frame_pose(np.zeros(1), HAND)[1]
    referee.face([sphere("a", away_from_hand(referee, aside), 0.01)])
    before = Standing(np.zeros(1), (hand + aside)[None])
    after = Standing(np.zeros(1), (hand - aside)[None])
    verdict = Verdict()
    referee.judge(verdict, before, after, 1.0, 0.01)
    assert verdict.obstacle.distance_m == pytest.approx(0.02 - 0.05, abs=1e-9)  # 2 cm off the line
    assert 1.0 < verdict.obstacle_s < 1.01
    assert not verdict.is_clean


def test_the_hand_of_the_referee_is_the_solvers(setting: ArmSetting) -> None:
    R, p = setting.problem.tips[0].pose(setting.home_rad)
    found = setting.hands(setting.home_rad)[0]
    assert found[0] == pytest.approx(R, abs=1e-12)
    assert found[1] == pytest.approx(p, abs=1e-12)


def test_start_and_goal_of_a_scene_are_clear(setting: ArmSetting, balls: ArmScene) -> None:
    setting.referee.face(balls.obstacles)
    for q in (balls.start_rad, balls.goal_rad):
        body = setting.whole(q)
        assert setting.referee.obstacle(body).distance_m >= CLEAR_M - 1e-9
        assert setting.referee.itself(body).distance_m >= SELF_CLEAR_M
        assert setting.limits.violation(q) <= 0.0


def test_the_goal_is_the_hand_of_a_posture_at_the_distance_asked_for(
    setting: ArmSetting, balls: ArmScene
) -> None:
    start, goal = (setting.hands(q)[0][1] for q in (balls.start_rad, balls.goal_rad))
    assert goal == pytest.approx(balls.goals[0].position_m, abs=1e-12)
    assert SHORTEST_M <= np.linalg.norm(goal - start) <= LONGEST_M


def test_a_scene_is_drawn_again_the_same(setting: ArmSetting, balls: ArmScene) -> None:
    again, other = random_scene(setting, 5, 0, 0), random_scene(setting, 5, 1, 0)
    assert again.obstacles == balls.obstacles
    assert np.array_equal(again.goal_rad, balls.goal_rad)
    assert other.obstacles != balls.obstacles


def test_the_ball_head_on_is_on_the_hands_line(setting: ArmSetting) -> None:
    scene = family_scene(setting, "head-on", 0, 0)
    start = setting.hands(scene.start_rad)[0][1]
    middle = 0.5 * (start + scene.goals[0].position_m)
    assert scene.obstacles[0].position_m == pytest.approx(middle, abs=1e-12)


def test_the_wall_has_25_balls_across_the_line(setting: ArmSetting) -> None:
    scene = family_scene(setting, "wall", 0, 0)
    start = setting.hands(scene.start_rad)[0][1]
    along = scene.goals[0].position_m - start
    centres = np.array([one.position_m for one in scene.obstacles])
    assert len(centres) == 25
    assert (centres - start) @ along == pytest.approx(0.5 * along @ along, abs=1e-9)


def test_every_family_has_balls() -> None:
    counts = {name: len(found) for name, found in FAMILIES.items()}
    assert counts == {"head-on": 1, "cusp": 2, "wall": 25, "ring": 16, "cup": 27}


class Straight:
    """Goes straight in the joints, through everything, in a second."""

    name = "straight"

    def __init__(self, goal_rad: Array) -> None:
        self._goal = goal_rad

    def begin(self, q_rad: Array) -> None:
        self._start, self._tick = q_rad, 0

    def step(self, seen: Seen) -> Answer:  # noqa: ARG002
        self._tick += 1
        share = min(1.0, self._tick / 100)
        return Answer(self._start + share * (self._goal - self._start), "reaching")


def test_a_run_that_arrives_counts_from_when_it_stays(setting: ArmSetting) -> None:
    scene = replace(random_scene(setting, 1, 0, 0), obstacles=())
    outcome, trace = run(setting, Straight(scene.goal_rad), scene)
    assert outcome.reached
    assert outcome.turned
    assert outcome.reached_s is not None
    assert 0.9 < outcome.reached_s <= 1.0
    assert outcome.error_m == pytest.approx(0.0, abs=1e-12)
    assert len(trace.q_rad) == 1 + round((outcome.reached_s + 0.5) / 0.01)
    assert outcome.moved_s == pytest.approx(0.01)
    assert outcome.states == ("reaching",)


def test_a_run_through_a_ball_is_no_clean_one(setting: ArmSetting) -> None:
    scene = random_scene(setting, 1, 0, 0)
    x, y, z = setting.hands(0.5 * (scene.start_rad + scene.goal_rad))[0][1].tolist()
    scene = replace(scene, obstacles=(sphere("ball", (x, y, z), 0.03),))
    outcome, _ = run(setting, Straight(scene.goal_rad), scene)
    assert outcome.reached
    assert not outcome.is_clean
    assert outcome.verdict.obstacle.pair[1] == "ball"
    assert "in ball" in outcome.cause()


def test_a_goal_that_comes_later_is_answered_from_then(setting: ArmSetting) -> None:
    scene = replace(random_scene(setting, 1, 0, 0), obstacles=())
    seen = Seen(scene.goals, ())
    outcome, _ = run(
        setting,
        Straight(scene.goal_rad),
        scene,
        course=lambda tick: Moment(seen, is_waiting=tick < 50),
    )
    assert outcome.goal_s == pytest.approx(0.5)
    assert outcome.moved_s == pytest.approx(0.01)


def test_the_papers_field_takes_balls_and_ellipsoids_only() -> None:
    found = ellipsoids([sphere("a", (0.0, 0.0, 0.0), 0.05)])
    assert found[0].semi_axes_m == (0.05, 0.05, 0.05)
    with pytest.raises(ValueError, match="no box"):
        ellipsoids([box("b", (0.0, 0.0, 0.0), (0.1, 0.1, 0.1))])


def test_the_papers_law_brings_the_hand_to_a_free_goal(setting: ArmSetting) -> None:
    # eq. 3 with K = 4, D = 8 is within 5 mm of a goal 30 cm away after 7.8 s
    scene = replace(random_scene(setting, 1, 0, 0), obstacles=())
    outcome, _ = run(setting, make_law("dforc", setting), scene)
    assert outcome.reached_s is not None
    assert 6.0 < outcome.reached_s < 9.5


def test_portions_take_every_scene_once() -> None:
    jobs = jobs_of(("1", "wall"), ("ulna",), range(12), 3)
    assert sorted(n for job in jobs if job.kind == "wall" for n in job.numbers) == list(range(12))
    assert {job.seed for job in jobs} == {3}


def test_our_contact_breaks_a_bar_and_the_papers_does_not() -> None:
    ours = Outcome("ulna", "random 1", 0)
    ours.verdict.obstacle = replace(ours.verdict.obstacle, distance_m=-0.001)
    theirs = replace(ours, law="dforc")
    rows = rate_rows({("1", "ulna"): [ours], ("1", "dforc"): [theirs]})
    held = {row.name: row.holds for row in rows if "touched an obstacle" in row.name}
    assert list(held.values()) == [None, False]


def test_an_answer_after_100_ms_breaks_the_bar() -> None:
    outcome = Outcome("ulna", "random 1", 0, said_s=0.11, moved_s=0.2)
    row = answer_rows({("1", "ulna"): [outcome]})[0]
    assert row.value == pytest.approx(110.0)
    assert row.holds is False


@pytest.mark.slow
def test_the_whole_arm_reaches_among_five_balls_and_touches_nothing() -> None:
    outcomes = do(Job("5", ("ulna",), (0, 1, 2), 0))
    assert all(outcome.reached and outcome.is_clean for outcome in outcomes)
