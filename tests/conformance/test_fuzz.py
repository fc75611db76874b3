"""The short form of the random-frame figures, and that their oracle can find something."""

import pytest

from benchmarks.can_fuzz import Tally, fuzz_motor_board, fuzz_rows
from benchmarks.can_oracle import GateOracle
from firmware_sim.boards import enabling, parser

HANDSHAKE = bytes.fromhex("5B0106")
GAINS = (bytes.fromhex("527D0000003C000D"), bytes.fromhex("5400002003000300"))
POSITION = bytes.fromhex("0901")
OTHER_AXIS = 0x80


def test_random_frames_raise_nothing_move_nothing_and_are_counted() -> None:
    rows = fuzz_rows(4000)
    assert [f"{row.name}: {row.value}" for row in rows if row.holds is False] == []
    barred = [row.name for row in rows if row.holds]
    assert len([name for name in barred if name.endswith("ran illegally")]) == 4
    assert len([name for name in barred if name.endswith("exceptions")]) == 9
    assert "HAL: axis-ms that noise moved an axis" in barred


def heard(*payloads: bytes) -> GateOracle:
    oracle = GateOracle(2, minor=0x50)
    for data in payloads:
        oracle.hear((3,), 0x003, data)
    return oracle


def test_the_gate_needs_handshake_every_gain_and_a_mode() -> None:
    passed = (HANDSHAKE, *GAINS, POSITION)
    assert heard(*passed).may_start(0)
    assert not heard(*passed).may_start(1)
    for missing in passed:
        assert not heard(*(data for data in passed if data != missing)).may_start(0)


def test_a_refused_handshake_or_a_wrong_length_passes_no_gate() -> None:
    assert not heard(bytes.fromhex("5B0107"), *GAINS, POSITION).may_start(0)
    assert not heard(bytes.fromhex("5B0206"), *GAINS, POSITION).may_start(0)
    assert not heard(HANDSHAKE, GAINS[0], GAINS[1][:7], POSITION).may_start(0)


def test_a_mode_command_opens_the_gate_for_a_moment_and_the_boot_loader_shuts_it() -> None:
    oracle = heard(HANDSHAKE, *GAINS, POSITION)
    oracle.ms += 40
    assert oracle.may_run(0)
    assert not oracle.may_start(0)
    oracle.hear((3,), 0x70F, b"\x00")
    assert not oracle.may_run(0)


def test_coupled_axes_start_together_each_with_its_own_gains() -> None:
    oracle = GateOracle(4, minor=0x19)  # axes 1 and 2, at two addresses
    for can_id, data in ((0x003, HANDSHAKE), (0x003, POSITION)):
        oracle.hear((3, 4), can_id, data)
    for can_id, bit in ((0x003, OTHER_AXIS), (0x004, 0)):
        for data in GAINS:
            oracle.hear((3, 4), can_id, bytes((data[0] | bit,)) + data[1:])
    assert not oracle.may_start(1)
    oracle.hear((3, 4), 0x004, POSITION)
    assert oracle.may_start(1)
    assert oracle.may_start(2)


def test_finds_a_board_that_does_not_look_at_its_gate(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(enabling, "may_run", lambda _axis: True)
    tally = Tally()
    fuzz_motor_board("bll", (2, 0x54), 4000, 1, tally)
    assert tally.moved_illegally > 0


def test_finds_a_board_that_does_not_count(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(parser, "command", lambda *_: True)
    tally = Tally()
    fuzz_motor_board("bll", (2, 0x54), 4000, 1, tally)
    assert tally.uncounted > 0


def test_finds_a_board_that_raises(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delattr(parser, "virtual_torque")
    tally = Tally()
    fuzz_motor_board("bll", (2, 0x54), 4000, 1, tally)
    assert tally.raised.total() > 0
