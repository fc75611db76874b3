from pathlib import Path

import pytest
from rich.console import Console
from rich.table import Table

from services.cli.can_stats import count_frames, load_percent, report
from tests.services.cli.can_bench import MakeWires

SECOND_MS = 1000


def test_load_is_the_one_of_the_sheet(make_wires: MakeWires) -> None:
    # can-protocol 11.3: 111 bits for 8 bytes, 95 for 6; 3600 frames/s of an arm are some 36 %.
    wires = make_wires("right_arm")
    wires.sends("right_arm", "111#0000000000000000", "3DA#008000800080", "115#")
    (count,) = count_frames(wires.taps, wires.clock, wires.after(SECOND_MS))
    assert (count.all.frames, count.all.bits) == (3, 111 + 95 + 47)
    assert load_percent(111 * 1500 + 95 * 2200, 1.0) == pytest.approx(37.55)
    assert load_percent(500_000, 2.0) == pytest.approx(25.0)


def test_frames_are_counted_by_board_message_and_identifier(make_wires: MakeWires) -> None:
    wires = make_wires("right_arm")
    wires.sends("right_arm", *["111#0000000000000000"] * 4, "121#0000000000000000", "121#00")
    (count,) = count_frames(wires.taps, wires.clock, wires.after(SECOND_MS))
    assert {board: one.frames for board, one in count.by["board"].items()} == {
        "r_shoulder": 4,
        "r_elbow": 2,
    }
    assert {message: one.frames for message, one in count.by["message"].items()} == {"POSITION": 6}
    assert count.by["id"]["111 r_shoulder POSITION"].frames == 4
    assert dict(count.causes) == {"length": 1}


def test_only_losses_since_the_beginning_are_told(make_wires: MakeWires) -> None:
    wires = make_wires("right_arm")
    faults = wires.network.faults("right_arm")
    faults.drop_next = 3
    wires.sends("right_arm", *["111#0000000000000000"] * 3)
    counts = count_frames(wires.taps, wires.clock, wires.after(10))
    assert counts[0].lost == 0
    faults.drop_next = 2
    wires.sends("right_arm", *["111#0000000000000000"] * 3)
    assert counts[0].lost == 2


def test_tables_show_rate_load_and_a_bus_that_is_off(make_wires: MakeWires, tmp_path: Path) -> None:
    wires = make_wires("right_arm", "left_arm")
    wires.sends("right_arm", *["111#0000000000000000"] * 50, "3DA#008000800080")
    counts = count_frames(wires.taps, wires.clock, wires.after(SECOND_MS))
    wires.network.faults("left_arm").bus_off = True
    tables: list[Table] = []
    report(counts, 0.5, "board", tables.append)

    text = rendered(tables, tmp_path)

    assert ["right_arm", "51", "102", "1.1", "0", "0", "0", "0", "on"] in text
    assert ["left_arm", "0", "0", "0.0", "0", "0", "0", "0", "off"] in text
    assert ["right_arm", "r_shoulder", "50", "100.0", "1.11"] in text
    assert ["right_arm", "r_arm_strain", "1", "2.0", "0.02"] in text


def rendered(tables: list[Table], folder: Path) -> list[list[str]]:
    path = folder / "tables"
    with path.open("w") as file:
        console = Console(file=file, width=200)
        for table in tables:
            console.print(table)
    lines = path.read_text().splitlines()
    return [line.split() for line in lines]
