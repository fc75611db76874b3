from collections.abc import Callable

import pytest

from hal.buses.memory import MemoryBus
from hal.scan import Found
from hal.wire import analog, motor
from hal.wire.can import Frame
from services.cli.can_scan import Finding, findings, remedies, scan
from services.core.clock import VirtualClock
from tests.services.cli.can_bench import ROBOT, MakeWires

SHOULDER = (4, 2, 0x50, 87, 1, 6, 1)
STRAIN = (6, 3, 0, 5, 1, 0, 1)


def found(address: int, *versions: tuple[int, ...], accepted: bool = True) -> Found:
    kind, major, minor, build = versions[0][:4]
    return Found(
        address=address,
        classes=(0,),
        type=kind,
        firmware=(major, minor),
        build=build,
        accepted=accepted,
        versions=versions,
    )


def notes(*answers: Found) -> dict[int, str]:
    rows = findings(ROBOT, {"right_arm": {one.address: one for one in answers}})
    return {row.address: row.note for row in rows}


ARM = (
    found(1, SHOULDER),
    found(2, (4, 2, 0x57, 87, 1, 6, 1)),
    found(3, (3, 2, 0x19, 87, 1, 6, 1)),
    found(13, STRAIN),
)


def test_a_bus_as_in_the_robot_file_has_no_notes() -> None:
    assert notes(*ARM) == {1: "", 2: "", 3: "", 13: ""}


def test_second_address_of_a_4dc_is_no_board_of_its_own() -> None:
    assert set(notes(*ARM, found(4, (3, 2, 0x19, 87, 1, 6, 1)))) == {1, 2, 3, 13}


@pytest.mark.parametrize(
    ("answer", "note"),
    [
        (found(1, STRAIN), "should be a BLL"),
        (found(1, (4, 2, 0x51, 87, 1, 6, 1)), "firmware should be 2.50"),
        (found(1, SHOULDER, accepted=False), "does not accept the host's protocol"),
        (found(1, SHOULDER, SHOULDER), "two boards share this address"),
        (Found(address=1, classes=(7,), bootloader=True), "in its boot loader"),
    ],
)
def test_what_is_wrong_with_a_board_is_said(answer: Found, note: str) -> None:
    assert notes(answer, *ARM[1:])[1] == note


def test_a_missing_board_and_a_foreign_one_are_told() -> None:
    told = notes(*ARM[1:], found(9, SHOULDER))
    assert (told[1], told[9]) == ("does not answer", "not in the robot file")


class Boards(VirtualClock):
    """A clock on which boards answer while somebody sleeps."""

    def __init__(self, answer: Callable[[], None]) -> None:
        super().__init__()
        self._answer = answer

    def sleep_until(self, deadline_ns: int) -> None:
        super().sleep_until(deadline_ns)
        self._answer()


def answer_handshakes(bus: MemoryBus, question: Frame, answer: Frame) -> None:
    """What one board does with the frames that have arrived."""
    for can_id, data, _ in bus.receive_frames():
        if (can_id, data) == question:
            bus.send_frames((answer,))


def test_buses_are_asked_at_the_same_time(make_wires: MakeWires) -> None:
    wires = make_wires("right_arm", "left_arm")

    def answer() -> None:
        wires.clock.advance_ns(1_000_000)
        answer_handshakes(
            wires.boards["right_arm"],
            motor.GET_FIRMWARE_VERSION.request(1, 0, *motor.HOST_PROTOCOL),
            motor.GET_FIRMWARE_VERSION.reply(1, 0, *SHOULDER),
        )
        answer_handshakes(
            wires.boards["left_arm"],
            analog.GET_FW_VERSION.request(13, *analog.HOST_PROTOCOL),
            analog.GET_FW_VERSION.reply(13, *STRAIN),
        )

    clock = Boards(answer)
    answers, refused = scan(wires.taps, clock)

    assert refused == []
    assert {bus: set(boards) for bus, boards in answers.items()} == {
        "right_arm": {1},
        "left_arm": {13},
    }
    rows = [row for row in findings(ROBOT, answers) if row.found is not None]
    assert [(row.bus, row.board, row.note) for row in sorted(rows, key=by_bus)] == [
        ("left_arm", "l_arm_strain", ""),
        ("right_arm", "r_shoulder", ""),
    ]
    assert clock.now_ns() < 800_000_000  # one bus after the other would take twice as long


def by_bus(row: Finding) -> str:
    return row.bus


def test_two_boards_that_changed_places_are_told_with_the_remedy(make_wires: MakeWires) -> None:
    taps = make_wires("right_arm").taps
    swapped = {
        1: found(1, (4, 2, 0x57, 87, 1, 6, 1)),
        2: found(2, SHOULDER),
        3: found(3, (3, 2, 0x19, 87, 1, 6, 1)),
        13: found(13, STRAIN),
    }
    (text,) = remedies(ROBOT, taps, {"right_arm": swapped})
    assert "r_shoulder" in text
    assert "r_elbow" in text
    assert "swap" in text
