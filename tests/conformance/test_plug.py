"""Boards pulled and plugged back while the robot holds: the short forms of the figure."""

import pytest

from benchmarks.can_plug import plug_rows
from services.experiments.rows import Row


def examine(rows: list[Row], types: set[str]) -> None:
    assert [f"{row.name}: {row.value}" for row in rows if row.holds is False] == []
    reported = [row.name for row in rows if row.name.endswith("silence when it was reported")]
    assert {name.split()[0] for name in reported} == types


@pytest.mark.parametrize(
    ("part", "types"),
    [
        ("head", {"bll_dc", "dc4", "imu"}),
        ("right_leg", {"bll_ie", "strain"}),
        ("right_hand", {"dc4", "mais"}),
        ("right_arm_skin", {"mtb"}),
    ],
)
def test_a_board_of_each_type_goes_and_comes_back(part: str, types: set[str]) -> None:
    examine(plug_rows(short=True, reference=f"icub:{part}"), types)


@pytest.mark.slow
def test_a_board_of_each_type_of_the_whole_robot_goes_and_comes_back() -> None:
    types = {"bll_dc", "bll_ie", "dc4", "imu", "mais", "mtb", "strain"}
    examine(plug_rows(short=True), types)
