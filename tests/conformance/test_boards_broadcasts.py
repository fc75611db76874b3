"""What every motor board sends by itself (can-protocol 3)."""

from hal.wire import motor, motor_periodic
from hal.wire.can import source_of
from hal.wire.modes import ControlMode
from tests.firmware_sim.boards.bench import PRINT_MASK, STATUS_MASK, Bench


def test_the_mask_belongs_to_the_address(bench: Bench) -> None:
    bench.do(motor.SET_BCAST_POLICY, motor_periodic.POSITION.mask_bit, axis=0)
    bench.do(motor.SET_BCAST_POLICY, motor_periodic.PID_VAL.mask_bit, axis=1)  # the last one wins
    frames = bench.tick(20)
    assert bench.heard(frames, motor_periodic.POSITION) == []
    assert {source_of(can_id) for can_id, _ in frames} == {bench.address}


def test_each_message_has_its_slot_and_period(bench: Bench) -> None:
    bench.configure(mask=0xFF)
    slots = bench.axis().hardware.slots
    bench.tick(100)
    seen: dict[int, set[int]] = {}
    now_ms = bench.axis().node.ms
    for _ in range(10 * slots):
        now_ms += 1
        for can_id, _data in bench.board.tick():
            seen.setdefault(can_id & 0xF, set()).add(now_ms % slots)
    assert seen == {1: {0}, 2: {1}, 4: {3}, 7: {3}, 8: {3}}


def test_status_is_sent_on_a_mode_change_and_every_five_seconds(bench: Bench) -> None:
    bench.configure(mask=STATUS_MASK)
    while bench.axis().node.ms < 1000:
        bench.tick()
    bench.calibrate()
    (changed,) = bench.statuses(8)
    assert changed[:4] == (0, ControlMode.IDLE, 0, ControlMode.POSITION)
    assert bench.statuses(3900) == []
    assert bench.statuses(200) == [changed]
    assert bench.statuses(4800) == []
    assert bench.statuses(200) == [changed]


def test_additional_status_tells_a_change_of_interaction(bench: Bench) -> None:
    bench.ready(mask=STATUS_MASK)
    bench.tick(10)
    bench.hear_torque()
    bench.send(motor.SET_INTERACTION_MODE, 1)
    (frame,) = bench.heard(bench.tick(10), motor_periodic.ADDITIONAL_STATUS)
    assert frame == (0x10C | bench.address << 4, b"\x10")


def test_additional_status_goes_with_the_status_of_every_five_seconds(bench: Bench) -> None:
    bench.configure(mask=STATUS_MASK)
    frames = bench.heard(bench.tick(5100), motor_periodic.ADDITIONAL_STATUS)
    assert [source_of(can_id) for can_id, _ in frames] == list(bench.board.addresses)


def test_rest_slot_carries_currents_speeds_and_errors(bench: Bench) -> None:
    bench.ready(mask=0xC8)
    bench.board.ports[0].current_ma = 350
    bench.board.ports[1].current_ma = -120
    bench.place(1993)
    frames = [frame for frame in bench.tick(8) if source_of(frame[0]) == bench.address]
    current = bench.heard(frames, motor_periodic.CURRENT)[-1]
    assert current[1] == bytes.fromhex("5e0188ff00000000")
    error = motor_periodic.PID_ERROR.parse(bench.heard(frames, motor_periodic.PID_ERROR)[-1][1])
    assert error == (0, 7, 0, 0)
    assert len(bench.heard(frames, motor_periodic.VELOCITY)) >= 1


def test_strange_sensors_on_the_bus_are_complained_about(bench: Bench) -> None:
    bench.configure(mask=PRINT_MASK)
    bench.give((0x3DA, bytes(6)))  # a sensor that nobody listens to is no stranger
    assert bench.texts(10) == ""
    bench.give((0x3DE, bytes(5)))  # a thermometer; the boards of head and hand do not mind
    minor = bench.axis().node.version[1]
    silent = minor in (0x11, 0x15, 0x28, 0x30, 0x62)
    assert bench.texts(10) == ("" if silent else "unknown strain msg")


def test_prints_wait_four_at_most(bench: Bench) -> None:
    bench.configure(mask=PRINT_MASK)
    for _ in range(5):
        bench.send(motor.SET_CURRENT_LIMIT, 0)
    pieces = bench.heard(bench.tick(40), motor_periodic.PRINT)
    assert len(pieces) == 4 * 5  # 29 characters in pieces of 6
    assert pieces[0][1] == b"\x06\x00curren"
    assert pieces[4][1] == b"\x86\x04xis 1"
    assert pieces[5][1][:2] == b"\x06\x10"
    assert bench.axis().node.printer.lost == 1
