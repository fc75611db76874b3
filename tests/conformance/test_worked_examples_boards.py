"""Worked examples of the fact sheet (can-protocol 12), as frames to and from emulated boards."""

import pytest

from firmware_sim.description import BoardSpec
from hal.wire.can import Frame
from hal.wire.modes import ControlMode
from tests.firmware_sim.boards.bench import Bench, spec_of


def frame(text: str) -> Frame:
    """`ID bytes`, hexadecimal."""
    can_id, _, data = text.partition(" ")
    return int(can_id, 16), bytes.fromhex(data)


def board(kind: str, minor: int, address: int) -> Bench:
    spec = BoardSpec(bus=1, address=address, type=kind, firmware=(2, minor), coupled=False)
    return Bench("", spec)


def tell(bench: Bench, *texts: str) -> list[Frame]:
    """Frames to the board; what it sends in that millisecond."""
    for text in texts:
        bench.give(frame(text))
    return bench.tick()


@pytest.fixture
def shoulder() -> Bench:
    return board("bll_ie", 0x50, 1)


@pytest.fixture
def elbow() -> Bench:
    return board("bll_ie", 0x57, 2)


def test_5_handshake() -> None:
    bench = Bench("", spec_of("bll", 2, 0x50))
    assert tell(bench, "001 5B0106") == [frame("010 5B04025057010601")]


def test_6_and_33_the_mask_of_a_shoulder_brings_positions_pwm_and_status(shoulder: Bench) -> None:
    tell(shoulder, "001 4937000000")
    shoulder.board.axes[0].pwm, shoulder.board.axes[1].pwm = 120, -45
    shoulder.board.axes[0].duty, shoulder.board.axes[1].duty = 118, -44
    frames = shoulder.tick(4)
    assert frame("112 7800D3FF7600D4FF") in frames
    assert {can_id for can_id, _ in frames} == {0x111, 0x112}


def test_7_calibrate_shoulder_pitch(shoulder: Bench) -> None:
    shoulder.configure()
    shoulder.place(3081 + 2000 - 4096, axis=0)
    tell(shoulder, "001 040355090A00090C")
    pitch = shoulder.axis(0)
    assert pitch.calibrated
    assert pitch.encoder_offset == 3081
    assert pitch.position == 2000
    shoulder.tick(100 * 389 // 10 + 1)
    assert pitch.reference.ticks == 2389


def test_8_to_12_settings(shoulder: Bench) -> None:
    tell(shoulder, "001 1E007D", "001 4EB4FF000000000E", "001 40C7070000", "001 42770C0000")
    tell(shoulder, "001 48581B0000", "001 4A0800", "001 566400")
    pitch = shoulder.axis(0)
    assert pitch.position_pid.kp == 32000
    assert (pitch.torque_loop.pid.kp, pitch.torque_loop.pid.shift) == (-76, 14)
    assert (pitch.reference.low, pitch.reference.high) == (1991, 3191)
    assert pitch.current_limit_ma == 7000
    assert (pitch.reference.velocity_shift, pitch.reference.velocity_timeout_ms) == (8, 100)


def test_13_14_and_17_elbow_in_position_and_direct_mode(elbow: Bench) -> None:
    elbow.configure()
    tell(elbow, "002 4904000000")
    elbow.tick(10)
    tell(elbow, "002 8901")
    assert frame("123 0000000100000000") in elbow.tick(4)
    tell(elbow, "002 8908")
    tell(elbow, "002 BE60050000")
    assert elbow.axis(1).reference.ticks == 1376


def test_15_positions(shoulder: Bench) -> None:
    tell(shoulder, "001 4901000000")
    shoulder.place(2104, axis=0)
    shoulder.place(3526, axis=1)
    assert frame("111 38080000C60D0000") in shoulder.tick(4)


def test_16_position_move(shoulder: Bench) -> None:
    shoulder.configure()
    tell(shoulder, "001 0901")
    tell(shoulder, "001 1B380800000B00")
    shoulder.tick(100 * 104 // 11)
    assert shoulder.axis(0).reference.ticks == 2104


def test_18_velocity_move() -> None:
    bench = Bench("", spec_of("bll_ie", 2, 0x51)).configure()
    tell(bench, "006 4A0800", "006 0902", "006 1C1D000100")
    assert bench.axis(0).reference.velocity_target == 29
    assert bench.axis(0).reference.acceleration == 1


def test_19_compliant_elbow(elbow: Bench) -> None:
    tell(elbow, "002 4904000000")
    elbow.tick(10)
    tell(elbow, "002 F401")
    assert frame("12C 10") in elbow.tick(4)


def test_20_to_22_impedance_torque_and_open_loop(shoulder: Bench) -> None:
    shoulder.configure()
    tell(shoulder, "001 579000332A000000", "001 2C00100000")
    pitch = shoulder.axis(0)
    assert (pitch.impedance.stiffness, pitch.impedance.damping) == (144, 10803)
    assert pitch.desired_torque == 4096
    tell(shoulder, "001 0950", "001 725000")
    assert pitch.openloop_pwm == 80


@pytest.mark.parametrize(("axis", "torque"), [(0, 16383), (1, -8191)])
def test_23_virtual_torques(shoulder: Bench, axis: int, torque: int) -> None:
    shoulder.configure()
    tell(shoulder, "3CA FFBF01600080", "3CB FF8700800080")
    shoulder.enter(ControlMode.TORQUE, axis=axis)
    assert shoulder.axis(axis).torque_loop.pid.error == -torque


def test_30_emergency_button(shoulder: Bench) -> None:
    tell(shoulder, "001 4904000000")
    shoulder.tick(10)
    for port in shoulder.board.ports:
        port.external_fault = True
    assert shoulder.tick(8) == [frame("113 0400040000000000")] * 2


def test_31_and_38_over_current_and_the_way_out(shoulder: Bench) -> None:
    shoulder.configure()
    tell(shoulder, "001 4904000000")
    tell(shoulder, "001 0901")
    shoulder.tick(10)
    shoulder.board.ports[0].current_ma = 25_000
    shoulder.tick()
    shoulder.board.ports[0].current_ma = 0
    assert frame("113 08A0000000000000") in shoulder.tick(4)
    tell(shoulder, "001 0901")
    assert shoulder.axis(0).mode == ControlMode.HW_FAULT
    tell(shoulder, "001 0909")
    assert shoulder.axis(0).mode == ControlMode.IDLE


def test_32_currents(shoulder: Bench) -> None:
    tell(shoulder, "001 4908000000")
    shoulder.board.ports[0].current_ma = 350
    shoulder.board.ports[1].current_ma = -120
    assert frame("114 5E0188FF00000000") in shoulder.tick(4)


def test_36_hall_sensors() -> None:
    hand = Bench("", spec_of("dc4", 2, 0x28))
    tell(hand, "3EC 10FFFFF0FFFFF8")
    assert [axis.position for axis in hand.board.axes[1:]] == [0x10, 0xFF + 0xFF, 0xF0]
