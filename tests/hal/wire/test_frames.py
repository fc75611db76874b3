import pytest

from hal.wire.frames import describe
from hal.wire.management import is_addressed_to, is_discovery
from hal.wire.motor_periodic import axis_fault_text, board_status_text, can_status_text


@pytest.mark.parametrize(
    ("can_id", "payload", "text"),
    [
        (
            0x001,
            "1B 38 08 00 00 0B 00",
            "host to board 1: POSITION_MOVE axis 0 target=2104 tick, speed=11 x 10 tick/s",
        ),
        (0x002, "89 01", "host to board 2: SET_CONTROL_MODE axis 1 mode=POSITION"),
        (0x001, "1B 38", "host to board 1: POSITION_MOVE axis 0 of wrong length: 1b 38"),
        (0x001, "6D 00", "host to board 1: motor command unknown: 6d 00"),
        (0x010, "88 01 00", "board 1 to host: MOTION_DONE axis 1 done=1"),
        (
            0x113,
            "08 A0 00 00 00 00 00 00",
            "board 1: STATUS fault0=OVERCURRENT, mode0=HW_FAULT, fault1=0x00, mode1=IDLE, "
            "can_status=0x00, board_status=0x00, tx_errors=0, rx_errors=0",
        ),
        (0x12C, "10", "board 2: ADDITIONAL_STATUS interaction0=STIFF, interaction1=COMPLIANT"),
        (0x115, "", "board 1: OVERFLOW"),
        (0x11E, "00", "board 1: class 1 type 14: 00"),
        (0x20D, "07 09", "host to board 13: SET_TXMODE mode=0x09"),
        (0x2D0, "", "board 13 to host: acknowledged"),
        (0x2D0, "99 42 55 47", "board 13 to host: command 0x99 unknown to the sensor"),
        (
            0x2D0,
            "00 00 00 01 00 00",
            "board 13 to host: sensor restarted, por=0, bor=0, idle=0, lvd_latch=1, "
            "lvd_enable=0, wdto=0",
        ),
        (0x3DA, "00 80 3A 7F 41 83", "board 13: FORCE fx=32768, fy=32570, fz=33601"),
        (
            0x3DA,
            "00 80 3A 7F 41 83 05",
            "board 13: FORCE fx=32768, fy=32570, fz=33601, saturation=5",
        ),
        (0x3DA, "00 80", "board 13: FORCE of wrong length: 00 80"),
        (0x70F, "FF", "host to everybody: DISCOVER"),
        (
            0x7E0,
            "FF 06 02 03",
            "board 14 to host: DISCOVER board_type=STRAIN, firmware_major=2, firmware_minor=3",
        ),
        (0x5E1, "00 00", "board 14: class 5 type 1: 00 00"),
    ],
)
def test_frame_is_described_by_name(can_id: int, payload: str, text: str) -> None:
    assert describe(can_id, bytes.fromhex(payload)) == text


def test_fault_bits_are_told_in_words() -> None:
    assert axis_fault_text(0) == ""
    assert axis_fault_text(0x04) == "emergency button pressed"
    assert axis_fault_text(0x90) == "Hall sensor error"
    assert axis_fault_text(0x28) == "over-current or I2T trip, absolute encoder read error"
    assert can_status_text(0x02) == "CAN bus-off"
    assert board_status_text(0x05) == "control loop longer than 1 ms, over-temperature axis 1"


def test_discovery_is_recognised_to_any_address() -> None:
    assert is_discovery(0x70F, b"\xff")
    assert is_discovery(0x703, b"\xff")
    assert not is_discovery(0x730, b"\xff\x03\x01\x11\x17")
    assert not is_discovery(0x703, b"\x0c")
    assert is_addressed_to(0x70F, 3)
    assert is_addressed_to(0x703, 3)
    assert not is_addressed_to(0x703, 4)
