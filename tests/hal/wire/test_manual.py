from pathlib import Path

from hal.wire.manual import manual_text

PAGE = Path(__file__).resolve().parents[3] / "docs" / "protocol.md"


def test_committed_page_is_what_the_tables_give() -> None:
    assert PAGE.read_text(encoding="utf-8") == manual_text(), (
        "write it again: ulna can docs --out docs/protocol.md"
    )


def test_page_says_code_bytes_units_and_names() -> None:
    lines = manual_text().splitlines()
    for line in (
        "| 27 0x1B | `POSITION_MOVE` | 7 | 1:target i32 [tick], 5:speed i16 [10 tick/s] "
        "| no reply |  |",
        "| 23 0x17 | `SET_FULL_SCALES` | any | 1:channel u8, 2:full_scale u16 BE [N or Nm] "
        "| no reply |  |",
        "| 0x1 | `POSITION` | 8 | 0:position0 i32 [tick], 4:position1 i32 [tick] "
        "| mask bit 0x001 |",
        "| byte 0 = 0x40 | `TRIANGLE_HEAD` | 8 | 1:taxel0 u8, 2:taxel1 u8, 3:taxel2 u8, "
        "4:taxel3 u8, 5:taxel4 u8, 6:taxel5 u8, 7:taxel6 u8 | skin board |",
        "| 255 0xFF | `DISCOVER` | 4 |  | 1:board_type u8 BoardType, 2:firmware_major u8, "
        "3:firmware_minor u8 | answer only |",
        "| `InteractionMode` | 0x00 STIFF, 0x01 COMPLIANT, 0xFF UNKNOWN |",
    ):
        assert line in lines
