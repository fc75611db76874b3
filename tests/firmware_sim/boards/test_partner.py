"""The two boards of a shoulder (can-protocol 9.4): frames, extrapolation, watchdog."""

import pytest

from firmware_sim.boards.hardware import PartnerSpec
from firmware_sim.boards.partner import PartnerLink
from hal.wire import motor
from hal.wire.modes import ControlMode
from hal.wire.motor_periodic import PID_VAL, POSITION
from tests.firmware_sim.boards.bench import coupled

PERIOD_MS = 4


def heard(link: PartnerLink, *positions: tuple[int, int]) -> list[tuple[int, int]]:
    """What the link knows each millisecond while frames come every 4 ms."""
    known = []
    for pair in positions:
        link.on_frame(*POSITION.frame(1, *pair))
        link.on_frame(*PID_VAL.frame(1, 0, 0, 0, 0))
        for _ in range(PERIOD_MS):
            link.advance()
            known.append(link.positions)
    return known


@pytest.fixture
def link() -> PartnerLink:
    return PartnerLink(PartnerSpec(1, needs_position=True, axes=(0,)))


def test_values_go_on_between_frames_as_between_the_last_two(link: PartnerLink) -> None:
    known = heard(link, (100, 0), (108, -6))
    assert known[4:] == [(108, -6), (110, -7), (112, -9), (114, -10)]


def test_extrapolation_ends_after_as_long_as_the_frames_were_apart(link: PartnerLink) -> None:
    heard(link, (100, 0), (108, 0))
    for _ in range(20):
        link.advance()
    assert link.positions == (116, 0)


def test_duties_are_the_bytes_four_to_seven(link: PartnerLink) -> None:
    link.on_frame(0x112, bytes.fromhex("7800d3ff7600d4ff"))
    link.advance()
    assert link.duties == (118, -44)


def test_one_frame_of_a_kind_that_is_missing_for_100_ms_makes_a_silence(link: PartnerLink) -> None:
    heard(link, (0, 0))
    for _ in range(100 - PERIOD_MS):
        link.on_frame(*PID_VAL.frame(1, 0, 0, 0, 0))
        assert not link.silent
        link.advance()
    assert link.silent
    link.on_frame(*POSITION.frame(1, 0, 0))
    link.advance()
    assert not link.silent


def test_a_frame_of_wrong_length_is_refused(link: PartnerLink) -> None:
    assert not link.on_frame(0x111, bytes(7))
    assert not link.on_frame(0x112, bytes(4))


@pytest.mark.parametrize(
    ("minor", "taken", "left"),
    [
        (0x50, (0x122,), (0x121, 0x112, 0x123)),
        (0x57, (0x111, 0x112), (0x122, 0x113)),
        (0x51, (), (0x111, 0x112, 0x122)),
    ],
)
def test_the_hardware_filter_lets_the_partner_in(
    minor: int, taken: tuple[int, ...], left: tuple[int, ...]
) -> None:
    board = coupled("bll", 2, minor).board
    assert all(board.accepts(can_id) for can_id in taken)
    assert not any(board.accepts(can_id) for can_id in left)


@pytest.mark.parametrize(("minor", "faulted"), [(0x50, [0, 1]), (0x57, [0])])
def test_a_silent_partner_faults_the_moving_coupled_axes(minor: int, faulted: list[int]) -> None:
    bench = coupled("bll_ie", 2, minor)
    bench.hear_partner()
    for axis in (0, 1):
        bench.do(motor.CALIBRATE_ENCODER, 3, 2000, 10, 0, axis=axis)
    bench.hear_partner()
    bench.tick(99)
    assert [axis.mode for axis in bench.board.axes] == [ControlMode.POSITION] * 2
    bench.tick(2)
    modes = [axis.mode for axis in bench.board.axes]
    assert [number for number in (0, 1) if modes[number] == ControlMode.HW_FAULT] == faulted


def test_a_silent_partner_does_not_matter_to_an_idle_board() -> None:
    bench = coupled("bll_ie", 2, 0x50)
    bench.tick(300)
    assert {axis.mode for axis in bench.board.axes} == {ControlMode.IDLE}
