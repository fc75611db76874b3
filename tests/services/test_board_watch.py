"""What is said of an emulated board: a line for each change and none besides."""

from types import SimpleNamespace

from hal.wire import analog, motor
from hal.wire.motor_periodic import POSITION, STATUS
from services.board_watch import QUIET_TICKS, Watch

EXTERNAL = 0x04  # emergency button
TORQUE, IDLE, FAULT = 0x03, 0x00, 0xA0
PARAMETERS = (4, 2, 0x50, 87, 1, 6)  # BLL, firmware 2.50 build 87, protocol 1.6


def axis() -> SimpleNamespace:
    return SimpleNamespace(mode=IDLE, calibrated=False)


def watched(*axes: SimpleNamespace) -> Watch:
    return Watch((1,), axes, {0: "pitch"})


def test_a_board_that_does_nothing_is_not_spoken_of() -> None:
    watch = watched(axis(), axis())
    assert [line for _ in range(2 * QUIET_TICKS) for line in watch.look([])] == []


def test_the_answer_to_a_handshake_says_whether_the_host_was_accepted() -> None:
    watch = watched()
    accepted = motor.GET_FIRMWARE_VERSION.reply(1, 0, *PARAMETERS, 1)
    refused = motor.GET_FIRMWARE_VERSION.reply(1, 0, *PARAMETERS, 0)
    assert watch.look([accepted]) == ["handshake accepted, protocol 1.6"]
    assert watch.look([accepted]) == []  # asked again
    assert watch.look([refused]) == ["handshake refused, protocol 1.6"]


def test_a_sensor_board_answers_in_class_2() -> None:
    accepted = analog.GET_FW_VERSION.reply(13, 6, 3, 0, 1, 1, 0, 1)
    assert Watch((13,), (), {}).look([accepted]) == ["handshake accepted, protocol 1.0"]


def test_a_mode_and_a_calibration_are_said_once() -> None:
    pitch, other = axis(), axis()
    watch = watched(pitch, other)
    pitch.mode, other.calibrated = TORQUE, True
    assert watch.look([]) == ["pitch: idle -> torque", "axis 1: calibrated"]
    assert watch.look([]) == []
    pitch.mode = FAULT
    assert watch.look([]) == ["pitch: torque -> hw fault"]


def test_faults_are_told_from_status_and_so_is_their_end() -> None:
    watch = watched(axis(), axis())
    pressed = STATUS.frame(1, EXTERNAL, IDLE, 0, IDLE, 0, 0, 0, 0)
    assert watch.look([pressed]) == ["pitch: emergency button pressed"]
    assert watch.look([pressed]) == []
    assert watch.look([STATUS.frame(1, 0, IDLE, 0, IDLE, 0, 0, 0, 0)]) == ["pitch: fault gone"]


def test_streams_start_and_stop() -> None:
    watch = watched()
    assert watch.look([POSITION.frame(1, 2048, 0)]) == ["streams started"]
    quiet = [watch.look([]) for _ in range(QUIET_TICKS)]
    assert quiet[-1] == ["streams stopped"]
    assert not any(quiet[:-1])


def test_state_has_modes_and_positions() -> None:
    pitch = axis()
    watch = watched(pitch, axis())
    watch.look([POSITION.frame(1, 2048, -7)])
    assert watch.state() == "streaming, pitch idle at 2048 ticks, axis 1 idle at -7 ticks"
