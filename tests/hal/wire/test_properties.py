"""Round trips and random bytes: whatever the rows are, decoding gives back what was encoded."""

from hypothesis import given, settings
from hypothesis import strategies as st

from hal.wire import analog, battery, management, motor, motor_foc, motor_periodic
from hal.wire.can import class_of, low_of, source_of
from hal.wire.frames import describe
from hal.wire.layout import Field, Layout, OpenLayout
from hal.wire.message import AxisCommand, Command, PeriodicMessage

RANGES = {
    "u4": (0, 15),
    "u8": (0, 255),
    "u16": (0, 65535),
    "i16": (-32768, 32767),
    "u32": (0, 2**32 - 1),
    "i32": (-(2**31), 2**31 - 1),
}
ADDRESSES = st.integers(0, 15)
AXES = st.integers(0, 1)
PLAIN_BROADCASTS = [
    *motor_periodic.MESSAGES.values(),
    *battery.MESSAGES.values(),
    analog.THERMOMETER,
]
TRIPLES = [m for m in analog.MESSAGES.values() if isinstance(m, analog.TripleMessage)]
MOTOR_COMMANDS = [*motor.COMMANDS.values(), *motor_foc.COMMANDS.values()]
COMMANDS = [*analog.COMMANDS.values(), *management.ROWS]


def _value(field: Field) -> st.SearchStrategy[int]:
    return st.integers(*RANGES[field.kind])


def _values(layout: Layout) -> st.SearchStrategy[tuple[int, ...]]:
    if isinstance(layout, OpenLayout):
        least, most = layout.least, len(layout.fields)
        return st.lists(st.integers(0, 255), min_size=least, max_size=most).map(tuple)
    return st.tuples(*(_value(field) for field in layout.fields))


@given(st.data(), st.sampled_from(MOTOR_COMMANDS), ADDRESSES, AXES)
def test_motor_command_round_trip(
    data: st.DataObject, command: AxisCommand, address: int, axis: int
) -> None:
    values = data.draw(_values(command.request_layout))
    can_id, payload = command.request(address, axis, *values)
    assert (class_of(can_id), source_of(can_id), low_of(can_id)) == (0, 0, address)
    assert motor.command_of(payload) in (command, motor.COMMANDS.get(command.code))
    assert motor.axis_of(payload) == axis
    assert command.parse_request(payload) == values
    if command.reply_layout is not None:
        answers = data.draw(_values(command.reply_layout))
        can_id, payload = command.reply(address, axis, *answers)
        assert (class_of(can_id), source_of(can_id), low_of(can_id)) == (0, address, 0)
        assert (payload[0] & 0x7F, motor.axis_of(payload)) == (command.code, axis)
        assert command.parse_reply(payload) == answers


@given(st.data(), st.sampled_from(COMMANDS), ADDRESSES)
def test_sensor_and_management_command_round_trip(
    data: st.DataObject, command: Command, address: int
) -> None:
    values = data.draw(_values(command.request_layout))
    can_id, payload = command.request(address, *values)
    assert (source_of(can_id), low_of(can_id), payload[0]) == (0, address, command.code)
    assert command.parse_request(payload) == values
    if command.reply_layout is not None:
        answers = data.draw(_values(command.reply_layout))
        can_id, payload = command.reply(address, *answers)
        assert (source_of(can_id), low_of(can_id), payload[0]) == (address, 0, command.code)
        assert command.parse_reply(payload) == answers


@given(st.data(), st.sampled_from(PLAIN_BROADCASTS), ADDRESSES)
def test_broadcast_round_trip(data: st.DataObject, message: PeriodicMessage, source: int) -> None:
    values = data.draw(_values(message.layout))
    can_id, payload = message.frame(source, *values)
    assert (source_of(can_id), low_of(can_id)) == (source, message.type)
    assert message.parse(payload) == values


@given(
    st.sampled_from(TRIPLES),
    ADDRESSES,
    st.tuples(*(st.integers(0, 65535),) * 3),
    st.none() | st.integers(0, 255),
)
def test_force_torque_round_trip(
    message: analog.TripleMessage,
    source: int,
    words: tuple[int, int, int],
    saturation: int | None,
) -> None:
    can_id, payload = message.frame(source, *words, saturation=saturation)
    assert can_id == 0x300 | source << 4 | message.type
    assert len(payload) == (6 if saturation is None else 7)
    assert message.parse(payload) == (*words, saturation or 0)


@given(st.integers(0, 65535), st.floats(0.1, 4000.0))
def test_word_survives_the_physical_value(word: int, full_scale: float) -> None:
    assert analog.to_word(analog.to_physical(word, full_scale), full_scale) == word


@given(st.lists(st.floats(-100.0, 100.0), min_size=6, max_size=6), st.floats(0.5, 30.0))
def test_virtual_torques_lose_at_most_one_step(torques_nm: list[float], scale_nm: float) -> None:
    first, second, clamped = analog.virtual_torque_frames(12, torques_nm, [scale_nm] * 6)
    low, high = analog.FORCE.parse(first[1]), analog.TORQUE.parse(second[1])
    assert low is not None
    assert high is not None
    assert clamped == sum(abs(torque_nm) > scale_nm for torque_nm in torques_nm)
    step_nm = scale_nm / 0x7FFF
    for word, torque_nm in zip((*low[:3], *high[:3]), torques_nm, strict=True):
        sent_nm = (word - 0x8000) * step_nm
        wanted_nm = min(max(torque_nm, -scale_nm), scale_nm)
        assert abs(sent_nm) <= abs(wanted_nm) + 1e-9 * scale_nm
        assert abs(wanted_nm - sent_nm) < step_nm * (1 + 1e-9)


@given(st.tuples(*(st.integers(0, 2),) * 3))
def test_saturation_byte_round_trip(states: tuple[int, int, int]) -> None:
    byte = analog.saturation_byte(*states)
    assert byte & 3 == 1
    assert analog.saturation_states(byte) == states


@settings(max_examples=500, deadline=None)
@given(st.integers(-1, 0x1000), st.binary(max_size=9))
def test_random_frames_never_raise(can_id: int, payload: bytes) -> None:
    assert describe(can_id, payload)
    for command in (*MOTOR_COMMANDS, *COMMANDS):
        command.parse_request(payload)
        command.parse_reply(payload)
    for message in (*motor_periodic.MESSAGES.values(), *analog.MESSAGES.values()):
        message.parse(payload)
    analog.parse_reset_cause(payload)
    analog.is_unknown_command(payload)
    management.is_discovery(can_id, payload)


def test_no_code_and_no_length_raises() -> None:
    for can_class in range(8):
        for low in (0, 5):
            can_id = can_class << 8 | (5 - low) << 4 | low
            for code in range(256):
                payload = bytes((code, *range(1, 8)))
                assert all(describe(can_id, payload[:length]) for length in range(9))
