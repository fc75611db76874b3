"""`ulna field`: what it prints, and one sentence for what cannot be done."""

import math
from pathlib import Path

import msgspec
import pytest
from rich.console import Console
from rich.table import Table

from dforc.collision.obstacles import Obstacle, box, cylinder, ellipsoid, sphere
from services.cli.field_plot import draw_previews, outline
from services.cli.field_preview import preview_json
from services.cli.field_tables import (
    field_remarks,
    fields_table,
    gains_table,
    objects_table,
    preview_remarks,
    preview_table,
    progress_line,
    status_lines,
)
from services.cli.main import main
from services.fields.gains import as_infos, initial_gains
from services.fields.messages import (
    FieldInfo,
    FieldState,
    FieldStatus,
    ModeInfo,
    PathPoint,
    Preview,
    SourceInfo,
)
from services.messages import WorldObject

REACHING = FieldStatus(
    stamp_ns=0,
    mode="ulna",
    gains=(("K", 16.0), ("T", 0.0)),
    limb="left_arm",
    state="reaching",
    goal=3,
    goal_distance_m=0.1234,
    goal_angle_rad=math.radians(4.0),
    clearance_m=0.0301,
    nearest=("l_forearm", "ball"),
    lag_m=0.002,
    iterations=12,
    budget=122,
    nodes=40,
    held=2,
    refused=1,
    refusal="object 'x': size_m",
    assumed=("head",),
)
WAITING = FieldStatus(
    stamp_ns=0, mode="dforc", gains=(), limb="right_arm", state="waiting", reason="no joint states"
)
BALL = WorldObject(name="ball", shape="sphere", size_m=(0.05,), position_m=(-0.3, 0.1, 0.05))
INFO = FieldInfo(
    version="1",
    mode="dforc",
    modes=(ModeInfo(name="dforc", promises="", gains=as_infos("dforc", initial_gains("dforc"))),),
    limbs=("right_arm",),
    limb="right_arm",
    sources=(SourceInfo(source="user", objects=(BALL,), age_s=2.5),),
    period_s=0.01,
)
ARRIVES = Preview(
    mode="dforc",
    limb="right_arm",
    arrives=True,
    arrival_s=2.04,
    state="arrived",
    reason="",
    closest_m=0.0123,
    closest_to="hand - ball",
    closest_s=0.9,
    final_distance_m=0.004,
    path=(
        PathPoint(t_s=0.05, position_m=(0.0, 0.0, 0.0), clearance_m=0.1, goal_distance_m=0.2),
        PathPoint(t_s=0.1, position_m=(0.1, 0.0, 0.0), clearance_m=math.inf, goal_distance_m=0.1),
    ),
)

QUARTER = ((0.0, -1.0, 0.0), (1.0, 0.0, 0.0), (0.0, 0.0, 1.0))  # about z


def printed(table: Table) -> str:
    console = Console(width=200)
    with console.capture() as capture:
        console.print(table)
    return capture.get()


def test_a_status_tells_state_distance_clearance_and_what_is_odd() -> None:
    assert list(status_lines(REACHING)) == [
        "mode ulna: K 16, T 0",
        "goal 3 of left_arm: reaching, 123.4 mm and 4.0 deg away",
        "clearance 30.1 mm: l_forearm - ball",
        "hand behind the point 2.0 mm",
        "search 12 of 122 iterations, 40 nodes; speed held in 2 periods",
        "not heard, taken to be where they were: head",
        "refused 1, the newest: object 'x': size_m",
    ]


def test_a_status_that_waits_tells_why() -> None:
    assert list(status_lines(WAITING))[1:] == ["no goal, right_arm: waiting", "no joint states"]
    assert progress_line(WAITING) == "waiting: no joint states"
    assert progress_line(REACHING) == "reaching, 123.4 mm to go, clearance 30.1 mm"


def test_late_periods_are_shown_while_they_are_and_counted_then() -> None:
    late = msgspec.structs.replace(WAITING, late_ms=83.4, late_count=2)
    (line,) = list(status_lines(late))[3:]
    assert line.startswith("periods began up to 83 ms late")
    (line,) = list(status_lines(msgspec.structs.replace(late, late_ms=12.0)))[3:]
    assert line == "periods began over 50 ms late; times so far: 2"
    assert len(list(status_lines(msgspec.structs.replace(WAITING, late_ms=12.0)))) == 3


def test_a_goal_that_was_withdrawn_is_shown_as_such_and_as_none() -> None:
    stopped = msgspec.structs.replace(
        WAITING, state="idle", reason="goal 3 was withdrawn", last_goal=3
    )
    assert list(status_lines(stopped))[1:] == ["no goal, right_arm: idle", "goal 3 was withdrawn"]


def test_every_field_has_a_row() -> None:
    fields = (
        FieldState(name="goal", kind="target", on=True, distance_m=0.05, force_n=0.45),
        FieldState(
            name="ball", kind="obstacle", on=False, distance_m=-0.001, force_n=math.nan,
            source="eyes", age_s=1.26, note="lost",
        ),
    )  # fmt: skip
    rows = printed(fields_table(fields)).splitlines()
    assert " ".join(rows[2].split()) == "goal target on 50.0 mm 0.45 0.000 0.0 mm 0.0"
    assert " ".join(rows[3].split()) == "eyes/ball obstacle off -1.0 mm - 0.000 0.0 mm 1.3"
    assert list(field_remarks(fields)) == ["eyes/ball: lost"]


def test_gains_are_shown_with_unit_default_and_the_paper_s_value() -> None:
    row = next(line for line in printed(gains_table(INFO.modes[0])).splitlines() if " K " in line)
    assert row.split()[:7] == ["K", "9", "N/m", "9", "4", "0", "400"]


def test_a_gain_that_the_papers_do_not_have_is_shown_without_their_value() -> None:
    info = ModeInfo(name="ulna", promises="", gains=as_infos("ulna", initial_gains("ulna")))
    lines = [line.split() for line in printed(gains_table(info)).splitlines() if line.strip()]
    rows = {words[0]: words for words in lines}
    assert rows["K"][:5] == ["K", "16", "N/m", "16", "4"]
    assert rows["T"][:5] == ["T", "0.2", "s", "0.2", "0.6"]
    for name, default in (("speed", "0.3"), ("margin", "0.02"), ("self_margin", "0.005")):
        assert rows[name][3:5] == [default, "-"]
    assert rows["turn"][3:5] == ["1.5", "-"]
    assert rows["least_margin"][3:5] == ["0.004", "-"]


def test_objects_are_shown_as_a_command_line_takes_them() -> None:
    row = printed(objects_table(INFO)).splitlines()[2]
    assert " ".join(row.split()) == "user ball sphere 0.05 -0.3 0.1 0.05 obstacle on 2.5"


def test_a_preview_has_a_row() -> None:
    row = printed(preview_table([ARRIVES])).splitlines()[3]
    assert " ".join(row.split()) == "dforc after 2.04 s 12.3 mm hand - ball 0.90 4.0 mm arrived"


def test_a_preview_that_does_not_arrive_tells_why_below_the_table() -> None:
    stuck = msgspec.structs.replace(ARRIVES, mode="pmp", arrives=False, reason="in balance")
    assert list(preview_remarks([ARRIVES, stuck])) == ["pmp: in balance"]


def test_a_preview_is_written_by_names_with_null_for_what_is_not_finite() -> None:
    (row,) = msgspec.json.decode(preview_json([ARRIVES]))
    assert row["arrival_s"] == 2.04
    assert row["path"][1]["position_m"] == [0.1, 0.0, 0.0]
    assert row["path"][1]["clearance_m"] is None


@pytest.mark.parametrize(
    ("solid", "across_m", "up_m"),
    [
        (sphere("ball", (1.0, 2.0, 3.0), 0.5), (0.5, 1.5), (2.5, 3.5)),
        (ellipsoid("egg", (0.0, 0.0, 0.0), (0.1, 0.2, 0.3)), (-0.1, 0.1), (-0.3, 0.3)),
        (ellipsoid("egg", (0.0, 0.0, 0.0), (0.1, 0.2, 0.3), QUARTER), (-0.2, 0.2), (-0.3, 0.3)),
        (box("table", (0.0, 0.0, 1.0), (0.3, 0.4, 0.02), QUARTER), (-0.4, 0.4), (0.98, 1.02)),
        (cylinder("can", (0.0, 0.0, 0.0), 0.05, 0.2), (-0.05, 0.05), (-0.2, 0.2)),
    ],
)
def test_an_outline_is_as_wide_and_as_high_as_the_solid(
    solid: Obstacle, across_m: tuple[float, float], up_m: tuple[float, float]
) -> None:
    edge = outline(solid, 0, 2)
    assert (edge[:, 0].min(), edge[:, 0].max()) == pytest.approx(across_m, abs=1e-12)
    assert (edge[:, 1].min(), edge[:, 1].max()) == pytest.approx(up_m, abs=1e-12)


def test_a_preview_is_drawn(tmp_path: Path) -> None:
    draw_previews([ARRIVES], INFO, tmp_path / "preview.png")
    assert (tmp_path / "preview.png").stat().st_size > 10_000


@pytest.mark.parametrize(
    "words",
    [
        ("status",),
        ("mode",),
        ("mode", "dforc"),
        ("set", "K=9"),
        ("info",),
        ("goal", "-0.3", "0.2", "0.1"),
        ("stop",),
        ("preview", "-0.3", "0.2", "0.1"),
        ("objects", "list"),
        ("objects", "add", "ball", "sphere", "0.05", "--at", "-0.3", "0.1", "0.05"),
        ("objects", "move", "ball", "--to", "-0.3", "0.1", "0.05"),
        ("objects", "remove", "ball"),
        ("objects", "remove", "--source", "eyes"),
    ],
)
def test_without_a_stack_every_verb_says_how_to_start_one(
    words: tuple[str, ...], capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["field", *words, "--stack", "nobody"]) == 2
    error = capsys.readouterr().err
    assert error.startswith("ulna: no stack named 'nobody' is up here")
    assert "start one with `ulna up`" in error


@pytest.mark.parametrize(
    ("words", "expected"),
    [
        (("goal",), "a goal is a position X Y Z, or --follow an object; one of the two"),
        (("goal", "0", "0", "0", "--follow", "ball"), "one of the two"),
        (("set",), "nothing to set: NAME=VALUE, --paper or --default"),
        (("set", "--paper", "--default"), "give --paper or --default, not both"),
        (("set", "K=stiff"), "'K=stiff' is no gain: NAME=VALUE, such as K=9"),
        (("set", "K"), "'K' is no gain"),
        (("objects", "remove"), "give the name of an object, or --source; one of the two"),
        (("preview", "0", "0", "0", "--plot", "/nowhere/at/all.png"), "there is no folder"),
    ],
)
def test_what_makes_no_sense_is_said_in_a_sentence(
    words: tuple[str, ...], expected: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["field", *words]) == 2
    assert expected in capsys.readouterr().err
