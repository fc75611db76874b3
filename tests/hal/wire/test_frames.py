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
        (0x001, "7F 00", "host to board 1: motor command unknown: 7f 00"),
        (
            0x001,
            "ED FA 00 00 00",
            "host to board 1: SET_DESIRED_CURRENT axis 1 current=250 mA",
        ),
        (0x001, "81 0A FF", "host to board 1: SET_MOTOR_PARAM axis 1 0a ff"),
        (0x010, "88 01 00", "board 1 to host: MOTION_DONE axis 1 done=1"),
        (
            0x113,
            "08 A0 00 00 00 00 00 00",
            "board 1: STATUS fault0=OVERCURRENT, mode0=HW_FAULT, fault1=0x00, mode1=IDLE, "
            "can_status=0x00, board_status=0x00, tx_errors=0, rx_errors=0",
        ),
        (0x12C, "10", "board 2: ADDITIONAL_STATUS interaction0=STIFF, interaction1=COMPLIANT"),
        (0x115, "", "board 1: OVERFLOW"),
        (0x1D0, "", "board 13: RECEIVE_OVERFLOW"),
        (0x7E5, "", "board 14: RECEIVE_OVERFLOW"),
        (0x705, "", "host to board 5: management command unknown: empty"),
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
        (
            0x70F,
            "01 10 00 02 00 00 00",
            "host to everybody: ADDRESS bytes=16, address=512, memory=PROGRAM, upper_address=0",
        ),
        (0x70F, "01 10 00 02 01", "host to everybody: ADDRESS bytes=16, address=512, memory=DATA"),
        (0x70F, "03 CF BB 20 00 80 F0", "host to everybody: DATA cf bb 20 00 80 f0"),
        (0x7D0, "03 01", "board 13 to host: DATA ok=1"),
        (0x705, "05", "host to board 5: ERROR"),
        (0x70D, "32 05", "host to board 13: SET_CAN_ADDRESS address=5"),
        (0x5E1, "00 00", "board 14: ACCELEROMETER of wrong length: 00 00"),
        (
            0x5E1,
            "00 00 00 00 00 40",
            "board 14: ACCELEROMETER x=0 g/16000, y=0 g/16000, z=16384 g/16000",
        ),
        (0x5E9, "00", "board 14: class 5 type 9: 00"),
        (
            0x4E3,
            "40 F0 F1 F2 F3 F4 F5 F6",
            "board 14: TRIANGLE_HEAD taxel0=240, taxel1=241, taxel2=242, taxel3=243, taxel4=244, "
            "taxel5=245, taxel6=246",
        ),
        (0x4E3, "41 F0", "board 14: class 4 type 3: 41 f0"),
        (
            0x3EC,
            "10 FF FF F0 FF FF F8",
            "board 14: HALL_0_6 hes0=16, hes1=255, hes2=255, hes3=240, hes4=255, hes5=255, "
            "hes6=248",
        ),
        (
            0x3E5,
            "40 01 02 03 04 05 06 07",
            "board 14: TRIANGLE_HEAD taxel0=1, taxel1=2, taxel2=3, taxel3=4, taxel4=5, taxel5=6, "
            "taxel6=7",
        ),
        (0x612, "01 02", "board 1: BATTERY_2 01 02"),
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
