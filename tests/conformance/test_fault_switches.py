"""Every fault switch: what the HAL reports, when, that nothing else is disturbed, the way back."""

import re
from collections.abc import Iterator

import pytest

from firmware_sim.switch_table import SWITCHES
from hal.readings import SkinSample
from tests.conformance.fault_rows import (
    ARM_BUS,
    ARM_JOINTS,
    ARM_ROWS,
    ELBOW,
    FOREARM,
    HAND_ROWS,
    SHOULDER,
    SKIN_ROWS,
    Row,
    at,
)
from tests.conformance.switched import Report, Switched


@pytest.fixture(scope="module")
def arm() -> Iterator[Switched]:
    switched = Switched("icub:reach", calibrate=True)
    yield switched
    switched.close()


@pytest.fixture(scope="module")
def hand() -> Iterator[Switched]:
    switched = Switched("icub:right_hand", calibrate=True)
    yield switched
    switched.close()


@pytest.fixture(scope="module")
def skin() -> Iterator[Switched]:
    switched = Switched("icub:right_arm_skin", calibrate=False)
    yield switched
    switched.close()


EXAMINED_APART = {"corrupt", "taxel"}


def assert_told(
    reports: list[Report], patterns: tuple[str, ...], may: tuple[str, ...] = ()
) -> None:
    texts = [report.text for report in reports]
    for text in texts:
        assert any(re.fullmatch(pattern, text) for pattern in (*patterns, *may)), text
    for pattern in patterns:
        assert any(re.fullmatch(pattern, text) for text in texts), (pattern, texts)


def examine(row: Row, robot: Switched) -> None:
    try:
        _examine(row, robot)
    finally:
        robot.robot.rig.switches.clear()


def _examine(row: Row, robot: Switched) -> None:
    boards, joints = set(row.boards), set(row.joints)
    told = robot.on(row.spec, row.ms, boards, joints)
    table = robot.robot.file.boards.get("r_shoulder")
    coupled = table is not None and table.coupled
    assert_told(told, row.told + (row.partners if coupled else ()), row.may)
    assert told[0].ms <= row.within_ms
    assert any(row.evidence in frame for report in told for frame in ("", *report.frames))
    back = robot.off(row.spec, row.after_ms, boards, joints)
    assert_told(back, row.after + (row.partners_after if coupled else ()))
    assert robot.robot.rig.switches.on == ()
    robot.recover(sorted(joints))
    robot.assert_well()
    if row.moves:
        robot.assert_obeys(sorted(joints))


@pytest.mark.parametrize("row", ARM_ROWS, ids=lambda row: row.name)
def test_a_fault_of_an_arm_is_named_disturbs_nobody_else_and_passes(
    row: Row, arm: Switched
) -> None:
    examine(row, arm)


@pytest.mark.parametrize("row", HAND_ROWS, ids=lambda row: row.name)
def test_a_fault_of_a_hand_is_named_disturbs_nobody_else_and_passes(
    row: Row, hand: Switched
) -> None:
    examine(row, hand)


@pytest.mark.parametrize("row", SKIN_ROWS, ids=lambda row: row.name)
def test_a_fault_of_a_skin_is_named_disturbs_nobody_else_and_passes(
    row: Row, skin: Switched
) -> None:
    examine(row, skin)


def test_every_switch_is_examined() -> None:
    rows = (*ARM_ROWS, *HAND_ROWS, *SKIN_ROWS)
    assert {row.spec.kind for row in rows} | EXAMINED_APART == set(SWITCHES)


def test_a_taxel_out_of_range_is_marked_in_the_samples_and_no_other_is(skin: Switched) -> None:
    spec = at("taxel", 8, 14, value=40)  # triangle 3, taxel 4
    assert skin.on(spec, 100, set(), set()) == []
    sample = skin.hal.take_samples("r_hand_skin", SkinSample)[-1]
    assert sample.out_of_range == (0, 0, 0, 1 << 4, *(0,) * 12)
    assert sample.taxels[40] == 255
    skin.off(spec, 100, set(), set())
    after = skin.hal.take_samples("r_hand_skin", SkinSample)[-1]
    assert set(after.out_of_range) == {0}


def test_three_lost_frames_are_no_news(arm: Switched) -> None:
    spec = at("drop", 2, 3, count=3)
    assert arm.on(spec, 100, {"r_forearm"}, set()) == []
    arm.off(spec, 20, set(), set())
    arm.assert_well()


def test_a_corrupted_command_is_missed_and_moves_nothing(arm: Switched) -> None:
    spec = at("corrupt", 2, 1, can_id=0x001, count=1)
    arm.robot.rig.switches.switch_on(spec)
    task = arm.hal.request("mode", ("r_shoulder_pitch",), "velocity")
    arm.robot.until(lambda: task.done)
    assert task.reason.startswith("r_shoulder_pitch did not enter velocity mode")
    arm.off(spec, 20, set(), set())
    arm.assert_well()
    arm.ask("mode", ("r_shoulder_pitch",), "velocity")
    arm.recover(("r_shoulder_pitch",))
    arm.assert_well()


def test_a_bus_that_is_off_is_named_and_its_boards_are_configured_again(arm: Switched) -> None:
    faults = arm.robot.network.faults(arm.robot.hal_buses[2].channel)
    faults.bus_off = True
    told = arm.watch(150, ARM_BUS, ARM_JOINTS)
    faults.bus_off = False
    back = [report.text for report in arm.watch(1000, ARM_BUS, ARM_JOINTS)]

    assert told[0].text == "bus 2 is off: no frame gets through"
    assert told[0].ms <= 12
    for board in (SHOULDER, ELBOW, FOREARM):
        text = f"{board} is configured again after its bus was off, its axes are idle"
        assert text in back
    arm.recover(sorted(ARM_JOINTS))
    arm.assert_well()
