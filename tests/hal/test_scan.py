"""Who answers on a bus of emulated boards, and what is said where the robot file says otherwise."""

from msgspec.structs import replace

from hal.description import RobotDescription
from hal.scan import Found, Scanner, run
from hal.stocktaking import differences
from hal.wire.can import CLASS_MANAGEMENT, class_of
from hal.wire.modes import ControlMode
from hal.wire.motor import GET_FIRMWARE_VERSION
from tests.hal.arm import BUS
from tests.hal.emulated import EMULATED, Bench


def scan(bench: Bench, **options: bool) -> dict[int, Found]:
    bench.running = False
    scanner = Scanner(bench.buses[2], lambda: bench.now_ns)
    return {one.address: one for one in run(scanner.scan(**options), bench.tick)}


def changed(**boards: dict[str, object]) -> RobotDescription:
    """The emulated robot's description with other boards in it."""
    return replace(
        EMULATED, boards=tuple(replace(b, **boards.get(b.name, {})) for b in EMULATED.boards)
    )


def texts(found: dict[int, Found], description: RobotDescription) -> list[tuple[str, str]]:
    return [(d.kind, d.text) for d in differences({BUS: tuple(found.values())}, description)]


def test_finds_every_board_with_its_type_firmware_and_protocol(bench: Bench) -> None:
    found = scan(bench)

    assert {a: (f.type, f.firmware, f.accepted) for a, f in found.items()} == {
        1: (4, (2, 0x50), True),
        3: (3, (2, 0x19), True),
        4: (3, (2, 0x19), True),  # the second address of the 4DC
        13: (6, (3, 0), True),
    }
    assert found[1].protocol == (1, 6)
    assert not any(one.collides for one in found.values())


def test_fits_the_robot_file(bench: Bench) -> None:
    assert texts(scan(bench), EMULATED) == []


def test_reads_the_label_of_a_motor_board(bench: Bench) -> None:
    listener = bench.buses[1]
    listener.send_frames(
        [
            (0x001, bytes((13, index)) + b"r_sh"[: 4 if index == 0 else 0].ljust(4, b"\0"))
            for index in range(8)
        ]
    )
    bench.running = False
    bench.tick(3)

    assert scan(bench)[1].label == "r_sh"


def test_neither_moves_nor_stops_a_running_robot(ready: Bench) -> None:
    scanner = Scanner(ready.buses[2], lambda: ready.now_ns)
    run(scanner.scan(), ready.tick)
    ready.tick(100)

    assert [axis.mode for axis in ready.axes] == [ControlMode.POSITION] * 4
    assert all(ready.robot.is_fresh(joint, ready.now_ns) for joint in range(4))


def test_sends_no_discovery_and_no_other_protocol_than_the_hals(bench: Bench) -> None:
    bench.running = False
    listener = bench.buses[1]
    run(Scanner(bench.buses[2], lambda: bench.now_ns).scan(), bench.tick)

    sent = [(can_id, data) for can_id, data, _ in listener.receive_frames() if can_id & 0xF0 == 0]
    assert not [frame for frame in sent if class_of(frame[0]) == CLASS_MANAGEMENT]
    versions = {data for can_id, data in sent if data[0] == GET_FIRMWARE_VERSION.code}
    assert versions == {bytes((0x5B, 1, 6))}
    assert {can_id for can_id, data in sent if data[0] == 0x5B} == set(range(1, 15))


def test_refuses_the_discovery_while_an_axis_has_power(ready: Bench) -> None:
    ready.running = False
    scanner = Scanner(ready.buses[2], lambda: ready.now_ns)
    run(scanner.scan(discover=True), ready.tick)

    assert scanner.refused == "no discovery: axes of board 1, 3, 4 move or have power"
    assert all(axis.enabled for axis in ready.axes)


def test_discovers_all_the_same_when_it_is_forced(ready: Bench) -> None:
    ready.running = False
    scanner = Scanner(ready.buses[2], lambda: ready.now_ns)
    run(scanner.scan(discover=True, force=True), ready.tick)

    assert scanner.refused == ""
    assert not any(axis.enabled for axis in ready.axes)


def test_discovers_boards_that_rest(bench: Bench) -> None:
    assert CLASS_MANAGEMENT in scan(bench, discover=True)[13].classes


def test_names_a_missing_board_with_what_to_do(bench: Bench) -> None:
    bench.boards.board(BUS, 3).powered = False

    assert texts(scan(bench), EMULATED) == [
        (
            "missing",
            "board r_forearm (bus 1, address 3) does not answer: check its power and its cable",
        )
    ]


def test_says_that_a_whole_bus_is_quiet(bench: Bench) -> None:
    for address in (1, 3, 13):
        bench.boards.board(BUS, address).powered = False

    found = [text for _, text in texts(scan(bench), EMULATED)]

    assert len(found) == 3
    assert all(text.endswith("nor does any other on bus 1: check the bus") for text in found)


def test_names_a_wrong_firmware(bench: Bench) -> None:
    found = scan(bench)

    assert texts(found, changed(r_shoulder={"firmware": (1, 0x57)})) == [
        (
            "wrong firmware",
            "board r_shoulder (bus 1, address 1) has firmware 2.50, not 1.57: "
            "load 1.57, or correct the robot file",
        )
    ]


def test_names_a_wrong_board(bench: Bench) -> None:
    found = scan(bench)

    assert texts(found, changed(r_strain={"type": "mais", "firmware": (1, 0)})) == [
        (
            "wrong type",
            "board r_strain (bus 1, address 13) is of type STRAIN, not a mais: "
            "a wrong board is plugged in here",
        )
    ]


def test_sees_that_two_boards_are_exchanged(bench: Bench) -> None:
    found = scan(bench)
    swapped = changed(
        r_shoulder={"type": "strain", "firmware": (3, 0)},
        r_strain={"type": "bll_ie", "firmware": (2, 0x50)},
    )

    assert texts(found, swapped) == [
        (
            "swapped",
            "board r_shoulder (bus 1, address 1) and board r_strain (bus 1, address 13) "
            "are exchanged: swap their plugs, or their addresses",
        )
    ]


def test_finds_a_board_at_another_address(bench: Bench) -> None:
    found = scan(bench)

    assert texts(found, changed(r_strain={"address": 12})) == [
        (
            "moved",
            "board r_strain (bus 1, address 12) does not answer; one like it is at bus 1, "
            "address 13: plug it back, or set its address",
        )
    ]


def test_names_a_board_that_the_robot_file_does_not_know(bench: Bench) -> None:
    found = scan(bench)
    few = replace(EMULATED, boards=EMULATED.boards[::2])

    assert texts(found, few) == [
        (
            "unexpected",
            "board of type DC4 at bus 1, address 3 is not in the robot file: "
            "unplug it, or add it to the file",
        )
    ]


def test_finds_two_boards_at_one_address(bench: Bench) -> None:
    """A second sensor with another firmware answers on the identifier of the first."""
    twin = bench.buses[1]
    bench.running = False
    scanner = Scanner(bench.buses[2], lambda: bench.now_ns)
    steps = scanner.scan()

    def tick() -> None:
        bench.tick()
        asked = [frame for frame in twin.receive_frames() if frame[0] == 0x20D]
        if any(data[0] == 0x1C for _, data, _ in asked):
            twin.send_frames([(0x2D0, bytes.fromhex("1C09010004010001"))])

    found = {one.address: one for one in run(steps, tick)}

    assert found[13].collides
    assert texts(found, EMULATED) == [
        (
            "collision",
            "board r_strain (bus 1, address 13) shares its address with another "
            "(SG6 1.00 and STRAIN 3.00): give one of them a new one",
        )
    ]
