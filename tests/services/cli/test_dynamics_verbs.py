"""`ulna dynamics`: its tables, its postures, and one sentence for what cannot be done."""

import tomllib
from pathlib import Path

import msgspec
import numpy as np
import pytest

from services.cli.dynamics import known_load
from services.cli.dynamics_sweep import posture
from services.cli.dynamics_tables import (
    contact_table,
    gain_table,
    known_lines,
    model_table,
    sensor_table,
    silent_lines,
)
from services.cli.main import main
from services.config import load_robot
from services.robotfile.wiring import joint_limits_deg
from services.wholebody.dynamics_messages import (
    ContactEstimate,
    Contacts,
    DynamicsHealth,
    DynamicsModels,
    KnownLoad,
    SensorHealth,
    SubModelStatus,
)

SIX = (1.0, -2.0, 3.5, 0.1, 0.2, -0.3)


def test_a_sensor_is_shown_with_its_flags_offset_and_task() -> None:
    sensor = SensorHealth(
        name="r_arm_ft",
        ok=False,
        flags=("saturated", "uncalibrated"),
        offset=SIX,
        mean=(),
        std=(),
        task="calibrating",
        samples=20,
        wanted=200,
    )
    silent = (("right_arm", "r_arm_ft cannot be used"),)
    health = DynamicsHealth(stamp_ns=0, sensors=(sensor,), silent=silent, imu="lost")
    row = [next(iter(column.cells)) for column in sensor_table(health).columns]
    assert row == [
        "r_arm_ft",
        "saturated, uncalibrated",
        "1.00 -2.00 3.50 | 0.100 0.200 -0.300",
        "",
        "",
        "calibrating, 20 of 200 samples",
    ]
    assert silent_lines(health) == [
        "no torques for right_arm: r_arm_ft cannot be used",
        "IMU: lost",
    ]


def test_a_sensor_that_lacks_only_its_offset_is_told_with_the_verb_that_finds_it() -> None:
    def sensor(name: str, *flags: str) -> SensorHealth:
        return SensorHealth(name=name, ok=False, flags=flags, offset=(), mean=(), std=())

    sensors = (sensor("l_arm_ft", "frozen", "uncalibrated"), sensor("r_arm_ft", "uncalibrated"))
    assert silent_lines(DynamicsHealth(stamp_ns=0, sensors=sensors)) == [
        "no offset is known of r_arm_ft: `ulna dynamics calibrate` finds it"
    ]


def test_a_contact_is_shown_with_the_size_of_its_force() -> None:
    contact = ContactEstimate(
        limb="left_arm",
        link="l_hand",
        point_m=(0.1, 0.2, 0.3),
        force_n=(3.0, 4.0, 0.0),
        moment_nm=(0.0, 0.0, 0.0),
        touching=True,
        location="shape",
    )
    table = contact_table(Contacts(stamp_ns=0, contacts=(contact,)))
    row = [next(iter(column.cells)) for column in table.columns]
    assert row == [
        "left_arm",
        "l_hand",
        "shape",
        "0.100 0.200 0.300",
        "3.0 4.0 0.0",
        "5.0",
        "yes",
    ]


def test_a_sub_model_is_shown_with_unknowns_rank_and_residual() -> None:
    sub = SubModelStatus(
        sensors=("a", "b"), links=("x", "y", "z"), unknowns=12, rank=6, residual_n=0.5
    )
    models = DynamicsModels(
        stamp_ns=0, assumption="custom", source="base", mainstay=False, sub_models=(sub,)
    )
    load = KnownLoad(frame="r_hand", wrench=(0, 0, -3, 0, 0.1, 0), point_m=(0, 0, 0.05))
    known = msgspec.structs.replace(models, known=(load,))
    assert known_lines(known) == [
        "known: 0.00 0.00 -3.00 N | 0.000 0.100 0.000 Nm at r_hand 0.000 0.000 0.050 m"
    ]
    assert known_lines(models) == []
    table = model_table(models)
    row = [next(iter(column.cells)) for column in table.columns]
    assert row == ["a, b", "x ... z", "12", "6", "0.50"]
    assert "custom, not held" in str(table.title)


def test_a_load_is_read_as_force_and_moment_at_a_point() -> None:
    assert known_load("r_hand=0,0,-3") == KnownLoad(frame="r_hand", wrench=(0, 0, -3, 0, 0, 0))
    assert known_load("r_hand@0.1,0,-.02=1,2,3,4,5,6") == KnownLoad(
        frame="r_hand", wrench=(1, 2, 3, 4, 5, 6), point_m=(0.1, 0, -0.02)
    )


@pytest.mark.parametrize("text", ["r_hand", "r_hand=1,2", "r_hand=1,2,3,4", "r_hand@1=0,0,1", "=a"])
def test_a_load_that_is_none_is_refused_with_how_to_write_one(
    text: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["dynamics", "assume", "default", "--known", text]) == 2
    assert f"{text!r} is no load: frame=fx,fy,fz" in capsys.readouterr().err


def test_a_gain_is_printed_as_a_site_file_takes_it(tmp_path: Path) -> None:
    gain = np.eye(6)
    gain[0, 0], gain[2, 5] = 1.25, -0.0375
    table = gain_table("r_arm_ft", gain.ravel().tolist())
    assert tomllib.loads(table) == {"sensors": {"r_arm_ft": {"gain": gain.ravel().tolist()}}}
    (tmp_path / "sites").mkdir()
    (tmp_path / "sites" / "lab.toml").write_text(table, encoding="utf-8")
    text = load_robot("icub").path.read_text(encoding="utf-8")
    (tmp_path / "robot.toml").write_text(text, encoding="utf-8")
    robot = load_robot(f"{tmp_path / 'robot.toml'}:arms@lab")
    assert robot.sensors["r_arm_ft"].gain == tuple(gain.ravel().tolist())
    assert robot.sensors["l_arm_ft"].gain == ()


def test_postures_of_a_sweep_differ_and_stay_inside_the_limits() -> None:
    robot = load_robot("icub")
    about = {joint: robot.joints[joint].park_deg for joint in robot.parts["left_arm"]}
    postures = [posture(robot, about, 25.0, number) for number in range(1, 17)]
    angles = np.array([list(each.values()) for each in postures])
    limits = np.array([joint_limits_deg(robot, joint) for joint in about])
    assert (angles > limits[:, 0]).all()
    assert (angles < limits[:, 1]).all()
    assert np.linalg.matrix_rank(angles - angles.mean(axis=0)) == len(about)
    assert (np.abs(angles[:, 0] - about["l_shoulder_pitch"]) <= 25.0).all()


@pytest.mark.parametrize(
    "arguments",
    [
        ["status"],
        ["calibrate", "r_arm_ft"],
        ["reset"],
        ["assume", "standing"],
        ["source", "base"],
        ["identify", "r_arm_ft"],
    ],
)
def test_without_a_stack_every_verb_says_how_to_start_one(
    arguments: list[str], capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["dynamics", *arguments, "--stack", "nobody"]) == 2
    error = capsys.readouterr().err
    assert "nobody" in error
    assert "ulna up" in error
