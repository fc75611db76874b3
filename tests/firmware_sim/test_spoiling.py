"""Frames on their way past spoilers, and the gate of a board."""

from firmware_sim.description import BoardSpec
from firmware_sim.network import Network
from firmware_sim.spoiling import Effect, Path, Spoiler
from firmware_sim.switch_table import FaultSpec
from firmware_sim.switches import Switches
from hal.wire import motor
from hal.wire.can import Frame, Received

A: Frame = (0x111, b"\x01\xf0")
B: Frame = (0x121, b"\x02")
ASK: Received = (*motor.GET_CONTROL_MODE.request(1, 0), 0)
ANSWER: Frame = (0x010, b"\x07\x00\x00")


def path(*spoilers: Spoiler) -> Path:
    made = Path()
    made.spoilers += spoilers
    return made


def test_drops_the_next_frames_and_no_more() -> None:
    way = path(Spoiler(Effect.DROP, count=2))
    assert way.step([A, B, A]) == [A]
    assert way.step([B]) == [B]


def test_drops_one_identifier() -> None:
    assert path(Spoiler(Effect.DROP, can_id=0x111)).step([A, B, A]) == [B]


def test_a_share_is_drawn_from_the_seed() -> None:
    def passed(seed: int) -> int:
        return len(path(Spoiler(Effect.DROP, share=0.25, seed=seed)).step([A] * 1000))

    assert passed(1) == passed(1) != passed(2)
    assert 700 < passed(1) < 800


def test_corruption_inverts_the_data() -> None:
    assert path(Spoiler(Effect.CORRUPT, count=1)).step([A, A]) == [(0x111, b"\xfe\x0f"), A]


def test_duplicates_follow_at_once() -> None:
    assert path(Spoiler(Effect.DUPLICATE, can_id=0x121)).step([A, B]) == [A, B, B]


def test_delayed_frames_arrive_later_in_their_order() -> None:
    way = path(Spoiler(Effect.DELAY, can_id=0x111, delay_ms=2))
    assert way.step([A, B]) == [B]
    assert way.step([B]) == [B]
    assert way.step([B]) == [A, B]
    way.spoilers.clear()
    assert way.is_idle


def test_frames_held_back_still_arrive_after_the_switch_is_off() -> None:
    way = path(Spoiler(Effect.DELAY, delay_ms=2))
    assert way.step([A]) == []
    way.spoilers.clear()
    assert not way.is_idle
    assert way.step([B]) == [B]
    assert way.step([]) == [A]
    assert way.is_idle


def networked() -> tuple[Network, Switches]:
    boards = [
        BoardSpec(bus=3, address=address, type="bll_ie", firmware=(2, 0x54)) for address in (1, 2)
    ]
    network = Network(boards, ())
    return network, Switches(network, (3,))


def asked(network: Network, switches: Switches, frame: Received = ASK) -> list[Frame]:
    received = switches.before({3: [frame]})
    network.deliver(received)
    switches.hold()
    return switches.after(network.tick())[3]


def test_a_gate_stands_only_while_a_switch_is_on() -> None:
    network, switches = networked()
    assert asked(network, switches) == [ANSWER]
    unplug = FaultSpec(kind="unplug", bus=3, address=1)
    switches.switch_on(unplug)
    assert asked(network, switches) == []
    assert asked(network, switches, (*motor.GET_CONTROL_MODE.request(2, 0), 0)) == [
        (0x020, b"\x07\x00\x00")
    ]
    switches.switch_off(unplug)
    assert asked(network, switches) == [ANSWER]
    assert asked(network, switches) == [ANSWER]


def test_a_bus_switch_strikes_commands_and_answers() -> None:
    network, switches = networked()
    switches.switch_on(FaultSpec(kind="duplicate", bus=3, can_id=0x010))
    assert asked(network, switches) == [ANSWER, ANSWER]
    switches.switch_on(FaultSpec(kind="drop", bus=3, can_id=0x001))
    assert asked(network, switches) == []


def test_nothing_has_to_be_called_once_everything_is_off() -> None:
    network, switches = networked()
    assert not switches.active
    switches.switch_on(FaultSpec(kind="delay", bus=3, milliseconds=3))
    assert asked(network, switches) == []
    switches.clear()
    assert [asked(network, switches, ASK) for _ in range(3)][-1]
    assert not switches.active


def test_a_reboot_ends_by_itself() -> None:
    network, switches = networked()
    switches.switch_on(FaultSpec(kind="reboot", bus=3, address=1, milliseconds=2))
    assert asked(network, switches) == []
    board = network.board(3, 1)
    assert not board.powered
    asked(network, switches)
    assert board.powered
    assert switches.on == ()
