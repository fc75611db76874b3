"""Oddities of the real firmware, and the strict boards that leave some of them out."""

from dataclasses import replace

import pytest

from hal.wire import motor, motor_periodic
from hal.wire.can import source_of
from hal.wire.modes import ControlMode
from hal.wire.motor_periodic import AxisFault
from tests.firmware_sim.boards.bench import SPECS, STATUS_MASK, Bench

MODE = motor.GET_CONTROL_MODE.code


def strict(name: str) -> Bench:
    return Bench("", replace(SPECS[name], faithful=False))


def test_a_new_address_counts_at_once_and_survives_power_up() -> None:
    bench = Bench("bll_ie 2.50")
    bench.do(motor.SET_BOARD_ID, 9)
    bench.board.power_cycle()
    assert bench.board.addresses == (9,)
    assert bench.board.accepts(0x009)
    assert not bench.board.accepts(0x001)
    bench.board.on_frame(0x009, bytes((motor.GET_BOARD_ID.code,)))
    assert bench.tick() == [(0x090, b"\x33\x09")]
    bench.board.on_frame(0x70F, b"\xff")
    assert bench.tick()[0][0] == 0x790


def test_a_4dc_moves_with_both_addresses() -> None:
    bench = Bench("dc4 2.19")
    bench.do(motor.SET_BOARD_ID, 7)
    assert bench.board.addresses == (7, 8)
    bench.board.on_frame(0x008, bytes((MODE,)))
    assert bench.tick() == [(0x080, b"\x07\x00\x00")]


@pytest.mark.parametrize("refused", [0, 15, 200])
def test_a_refused_address_is_not_taken_but_the_flash_is_written(refused: int) -> None:
    bench = Bench("bll_ie 2.50")
    bench.do(motor.SET_BOARD_ID, refused)
    assert bench.board.addresses == (1,)
    assert bench.unit.flash_writes == 1
    assert bench.board.dropped["value"] == 1


def test_the_flash_is_written_when_it_is_asked_to_and_with_each_piece_of_a_label() -> None:
    bench = Bench("bll_ie 2.50")
    bench.do(motor.WRITE_FLASH_MEM)
    bench.do(motor.SET_ADDITIONAL_INFO, 7, *b"left")
    bench.give((0x701, b"\x0d\x00knee"))
    bench.tick()
    bench.do(motor.READ_FLASH_MEM)
    assert bench.unit.flash_writes == 3
    bench.board.power_cycle()
    labels = {data[1]: data[2:] for _, data in bench.do(motor.GET_ADDITIONAL_INFO)}
    assert (labels[7], labels[0]) == (b"left", b"knee")


def test_debug_parameters_are_scratch_and_twenty_holds_three_words() -> None:
    bench = Bench("dc4 2.15")
    bench.do(motor.SET_DEBUG_PARAM, 3, -77)
    bench.give((0x003, bytes.fromhex("92140100feff2c01")))
    assert bench.ask(motor.GET_DEBUG_PARAM, 3) == (-77,)
    assert bench.unit.micro_saccade == (1, -2, 300)
    assert bench.ask(motor.GET_DEBUG_PARAM, 20) == (1,)


def test_debug_parameter_seven_damps_the_torque_loop() -> None:
    bench = Bench("bll_ie 2.50").ready()
    bench.do(motor.SET_TORQUE_PID, 0, 0, 0, 6)
    bench.do(motor.SET_DEBUG_PARAM, 7, 20)
    bench.hear_torque()
    bench.enter(ControlMode.TORQUE)
    for ticks in range(2001, 2060):
        bench.place(ticks)
        bench.hear_torque()
        bench.tick()
    assert bench.axis().speed() == 32  # one tick a millisecond, shift 5
    assert bench.axis().pwm == -10  # 20 * 32 >> 6


def rest(name: str, mask: int, milliseconds: int = 20) -> list[tuple[int, bytes]]:
    """What a board with this mask broadcasts while the encoders run by 3, 5, 7, 9 ticks a ms."""
    bench = Bench(name).configure(mask)
    frames = []
    for _ in range(milliseconds):
        for number, port in enumerate(bench.board.ports):
            port.raw_encoder += 3 + 2 * number
        frames += bench.tick()
    return frames


def test_motor_positions_at_the_second_address_repeat_those_of_the_first() -> None:
    frames = rest("dc4 1.11", motor_periodic.MOTOR_POSITION.mask_bit)
    told = {source_of(can_id): data for can_id, data in frames}
    assert set(told) == {3, 4}
    assert told[3] == told[4]
    first, second = motor_periodic.MOTOR_POSITION.parse(told[3]) or ()
    assert (first - 2000) * 5 == (second - 2000) * 3


@pytest.mark.parametrize(("name", "speeds"), [("dc4 1.11", (3, 5)), ("bll 2.50", (96, 160))])
def test_motor_speeds_are_scaled_as_joint_speeds_are(name: str, speeds: tuple[int, int]) -> None:
    frames = rest(name, motor_periodic.MOTOR_SPEED.mask_bit)
    first = [data for can_id, data in frames if source_of(can_id) == Bench(name).address]
    assert motor_periodic.MOTOR_SPEED.parse(first[-1]) == speeds


def test_debug_broadcasts_carry_scratch_parameters() -> None:
    bench = Bench("bll_ie 2.50").configure(motor_periodic.DEBUG.mask_bit)
    for axis in (0, 1):
        bench.do(motor.SET_DEBUG_PARAM, 0, 10 + axis, axis=axis)
        bench.do(motor.SET_DEBUG_PARAM, 1, -20 - axis, axis=axis)
    assert motor_periodic.DEBUG.parse(bench.tick(4)[0][1]) == (10, -20, 11, -21)


@pytest.mark.parametrize(
    ("code", "bits"),
    [
        (0b001, AxisFault.HALL_A),
        (0b010, AxisFault.HALL_B),  # the bit that optical drift shares
        (0b100, AxisFault.HALL_C),
        (0b111, AxisFault.HALL_A | AxisFault.HALL_B | AxisFault.HALL_C),
    ],
)
def test_hall_codes_have_their_bits(code: int, bits: AxisFault) -> None:
    bench = Bench("bll_ie 2.50").ready(mask=STATUS_MASK)
    bench.tick(10)
    bench.board.ports[1].hall_fault = code
    assert [status[2] for status in bench.statuses(8)] == [bits]


def test_a_strict_4dc_scales_its_speed() -> None:
    for bench, speed in ((Bench("dc4 1.11"), 42), (strict("dc4 1.11"), 42 << 5)):
        bench.tick()
        bench.board.ports[1].raw_encoder += 42
        bench.tick()
        assert bench.axis().speed() == speed


def test_a_strict_integral_stays_at_its_limit() -> None:
    for bench, after in ((Bench("bll_ie 2.50"), 100), (strict("bll_ie 2.50"), 100 << 6)):
        bench.ready().enter(ControlMode.DIRECT)
        bench.do(motor.SET_I_GAIN, 32)
        bench.do(motor.SET_P_GAIN, 0)
        bench.do(motor.SET_ILIM_GAIN, 100)
        bench.do(motor.SET_COMMAND_POSITION, 2100)  # charges by 50 counts a millisecond
        bench.tick(2)
        assert bench.axis().position_pid.integral == after
        assert bench.axis().pwm == 100


@pytest.mark.parametrize(
    ("name", "most"), [("bll 2.50", 1250), ("bll_ie 2.50", 760), ("bll_dc 1.62", 756)]
)
def test_each_type_has_its_largest_duty(name: str, most: int) -> None:
    bench = Bench(name).ready().enter(ControlMode.OPENLOOP)
    bench.do(motor.SET_PWM_LIMIT, 1333)
    bench.do(motor.SET_OPENLOOP_PARAMS, 1333)
    bench.tick(130)
    assert bench.board.ports[1].pwm == most


def test_the_neck_damps_its_speed_and_not_its_error() -> None:
    for name, kick in (("bll_ie 2.50", 10), ("bll_dc 1.62", 0)):
        bench = Bench(name).ready().enter(ControlMode.DIRECT)
        bench.do(motor.SET_P_GAIN, 0)
        bench.do(motor.SET_D_GAIN, 64)
        bench.do(motor.SET_COMMAND_POSITION, 2100)  # an error that jumps by 100 ticks
        assert bench.axis().pwm == kick
        bench.tick(20)
        bench.place(2020)
        bench.tick()
        assert bench.axis().pwm == -2


def test_the_neck_broadcasts_every_five_milliseconds() -> None:
    bench = Bench("bll_dc 1.62").configure(mask=0x1)
    assert len(bench.tick(50)) == 10


@pytest.mark.parametrize("name", ["bll 2.50", "bll_dc 1.62", "bll_ie 2.50"])
def test_brushless_boards_trip_at_25_amperes_at_once(name: str) -> None:
    bench = Bench(name).ready()
    bench.board.ports[1].current_ma = 25_000
    bench.tick()
    assert bench.axis().mode == ControlMode.HW_FAULT


def test_a_4dc_has_no_trip_beside_its_integral() -> None:
    bench = Bench("dc4 1.11").ready()
    bench.board.ports[1].current_ma = 25_000
    bench.tick(3)  # 23400^2 a millisecond of 1.8e9
    assert bench.axis().mode == ControlMode.POSITION
    bench.tick(2)
    assert bench.axis().mode == ControlMode.HW_FAULT
