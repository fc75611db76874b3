"""Hand boards and the MAIS on their bus (can-protocol 5.4)."""

import pytest

from hal.wire import motor
from hal.wire.can import Frame
from hal.wire.mais import HALL_0_6, HALL_7_14
from hal.wire.modes import ControlMode
from hal.wire.motor_periodic import PRINT, STATUS
from tests.firmware_sim.boards.bench import Bench, spec_of

MAIS = 14


class Hand(Bench):
    """A hand board whose MAIS speaks only when it is told to."""

    def __init__(self, minor: int) -> None:
        super().__init__("", spec_of("dc4", 2, minor))

    def tick(self, milliseconds: int = 1) -> list[Frame]:
        return [frame for _ in range(milliseconds) for frame in self.board.tick()]

    def hear_fingers(self, *hall: int) -> None:
        self.give(HALL_0_6.frame(MAIS, *hall[:7]))
        self.give(HALL_7_14.frame(MAIS, *hall[7:]))


HALL = tuple(range(10, 160, 10))  # HES0 = 10 ... HES14 = 150


def test_positions_of_thumb_and_index_are_sums_of_hall_bytes() -> None:
    hand = Hand(0x28)
    hand.hear_fingers(*HALL)
    hand.tick()
    assert [axis.position for axis in hand.board.axes] == [2000, 10, 20 + 30, 40]


def test_positions_of_the_fingers_are_sums_of_hall_bytes() -> None:
    hand = Hand(0x30)
    hand.hear_fingers(*HALL)
    hand.tick()
    expected = [50 + 60, 70, 80 + 90, 130 + 140 + 150]
    assert [axis.position for axis in hand.board.axes] == expected
    assert hand.ask(motor.GET_ENCODER_POSITION, axis=3)[0] == 420


def test_frames_of_wrong_length_are_dropped() -> None:
    hand = Hand(0x28)
    hand.give((0x3EC, bytes(6)))
    hand.give((0x3ED, bytes(7)))
    hand.tick()
    assert hand.board.dropped["length"] == 2


def test_a_sensor_at_another_address_is_not_heard() -> None:
    hand = Hand(0x28)
    hand.give(HALL_0_6.frame(13, *HALL[:7]))
    hand.tick()
    assert hand.axis(1).position == 2000


@pytest.mark.parametrize("minor", [0x28, 0x30])
def test_a_silent_mais_faults_enabled_axes_and_is_printed(minor: int) -> None:
    hand = Hand(minor)
    hand.configure(mask=PRINT.mask_bit | STATUS.mask_bit)
    hand.hear_fingers(*HALL)
    hand.enter(ControlMode.POSITION, axis=0)
    hand.enter(ControlMode.POSITION, axis=2)
    hand.hear_fingers(*HALL)
    hand.tick(99)
    modes = [axis.mode for axis in hand.board.axes]
    assert modes == [ControlMode.POSITION, 0, ControlMode.POSITION, 0]
    text = hand.texts(10)
    modes = [axis.mode for axis in hand.board.axes]
    assert modes == [ControlMode.HW_FAULT, 0, ControlMode.HW_FAULT, 0]
    assert text == "MAIS error 100"


def test_one_of_the_two_frames_is_a_sign_of_life() -> None:
    hand = Hand(0x28)
    hand.configure()
    hand.hear_fingers(*HALL)
    hand.enter(ControlMode.POSITION, axis=2)
    for _ in range(5):
        hand.give(HALL_7_14.frame(MAIS, *HALL[7:]))
        hand.tick(90)
    assert hand.axis(2).mode == ControlMode.POSITION


def test_an_idle_hand_does_not_mind_the_silence() -> None:
    hand = Hand(0x30)
    hand.configure(mask=PRINT.mask_bit)
    assert hand.texts(500) == ""
    assert not any(axis.fault_entries for axis in hand.board.axes)
