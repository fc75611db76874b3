"""State, load and counters of buses, and what never happens on them."""

import can
import pytest
from msgspec.structs import replace

from hal.line import BUDGET
from hal.readings import BusReport
from hal.wire.modes import ControlMode
from tests.hal.arm import BUS, PITCH, ROLL
from tests.hal.emulated import EMULATED, Bench
from tests.hal.scripted import Script, ScriptedBus


@pytest.fixture
def script() -> Script:
    script = Script()
    script.ready()
    return script


def bus_report(script: Script) -> BusReport:
    (report,) = script.robot.status().buses
    return report


def test_measures_the_load_without_stuff_bits(script: Script) -> None:
    script.tick(2010)

    # Each 4 ms 3 frames of 8 bytes, 111 bits each; each ms 2 of 6 bytes, 95 bits each.
    expected_percent = (250 * 3 * 111 + 1000 * 2 * 95) / 1e6 * 100
    assert bus_report(script).load_percent == pytest.approx(expected_percent, rel=0.02)


def test_counts_frames_and_errors_per_bus(script: Script) -> None:
    before = bus_report(script)
    script.say("191 00")  # nobody sends that
    script.status(0x113, 1, 1)
    script.say("113 0001000101000000")  # CAN transmit buffer overrun
    script.tick(4)
    after = bus_report(script)

    assert after.number == BUS
    assert after.errors - before.errors == 2
    assert after.frames_received - before.frames_received == 3 + 3 + 2 * 4


def test_says_once_that_nobody_is_left_on_a_bus_and_stops_talking(script: Script) -> None:
    script.bus.positions.clear()
    script.bus.wrench.clear()
    script.bus.answers.clear()
    script.tick(300)

    assert bus_report(script).state == "nobody acknowledges"
    texts = [text for text in script.robot.status().faults if text.startswith("bus 1")]
    assert texts == [
        "bus 1 is deserted: nobody acknowledges, check its cable, power and termination"
    ]
    script.torques()
    assert script.tick() == []
    assert {sent[4:6] for sent in script.tick(3000)} == {"5B", "1C"}  # handshakes


def test_goes_on_when_the_bus_is_plugged_back(script: Script) -> None:
    positions, wrench = dict(script.bus.positions), list(script.bus.wrench)
    script.bus.positions.clear()
    script.bus.wrench.clear()
    script.tick(200)
    script.bus.positions, script.bus.wrench = positions, wrench
    script.tick(50)

    assert bus_report(script).state == "active"
    assert "bus 1 is back" in script.robot.status().faults


def test_reports_a_bus_that_is_error_passive_once(script: Script) -> None:
    script.bus.bus_state = can.BusState.PASSIVE
    script.tick(500)

    assert bus_report(script).state == "passive"
    assert script.robot.status().faults == ("bus 1 is error-passive: frames are often repeated",)


def test_configures_every_board_again_after_the_bus_was_off(ready: Bench) -> None:
    ready.memory.faults("arm").bus_off = True
    ready.tick(300)
    assert ready.robot.status().buses[0].state == "off"
    ready.memory.faults("arm").bus_off = False
    ready.tick(1500)

    faults = ready.robot.status().faults
    for name in ("r_shoulder (bus 1, address 1)", "r_forearm (bus 1, address 3)"):
        assert (
            f"board {name} is configured again after its bus was off, its axes are idle" in faults
        )
    assert [axis.mode for axis in ready.axes] == [ControlMode.IDLE] * 4
    assert ready.robot.status().buses[0].state == "active"
    task = ready.robot.request("calibrate")
    ready.finish(task)
    assert task.ok, task.reason


def test_stops_commands_at_once_when_the_bus_goes_off(script: Script) -> None:
    script.robot.request("mode", ["pitch"], "direct")
    script.bus.bus_state = can.BusState.ERROR
    script.tick(10)

    assert script.tick(200) == []


def test_never_overruns_a_board_whatever_the_caller_does(ready: Bench) -> None:
    """Two axes of one 4DC, both addresses, and a caller without manners."""
    listener = ready.buses[2]
    ready.finish(ready.robot.request("mode", value="direct"))
    listener.receive_frames()
    worst = 0
    for ms in range(400):
        for _ in range(5):
            ready.robot.set_positions([0, 1, 2, 3], list(ready.robot.joints.q_rad))
            ready.robot.set_impedance_offsets([PITCH, ROLL], [0.1 * (ms % 7), 0.0])
            for name in ("prosup", "wrist"):
                ready.robot.request("interaction", [name], "compliant")
            ready.robot.request("idle", ["prosup"])
        ready.tick()
        heard = [can_id for can_id, _, _ in listener.receive_frames()]
        worst = max(worst, sum(can_id in (3, 4) for can_id in heard))

    assert 1 <= worst <= BUDGET <= 20  # of the 30 that a board's queue holds
    assert ready.robot.status().frames_lost == 0


def test_sends_one_set_point_per_axis_and_cycle(ready: Bench) -> None:
    listener = ready.buses[2]
    ready.finish(ready.robot.request("mode", ["prosup", "wrist"], "direct"))
    start = list(ready.robot.joints.q_rad)
    listener.receive_frames()
    for ms in range(1000):
        ready.robot.set_positions([2, 3], [start[2] + 1e-4 * ms, start[3]])
        ready.tick()

    heard = [(can_id, data[0]) for can_id, data, _ in listener.receive_frames()]
    assert 98 <= heard.count((3, 62)) <= 101
    assert 9 <= heard.count((4, 62)) <= 11  # unchanged: repeated each 100 ms


def test_a_group_of_frames_beyond_the_budget_leaves_one_millisecond_later(script: Script) -> None:
    line = script.robot._machine.lines[BUS]
    for value in range(BUDGET + 5):
        line.send(3, (3, bytes((0x2C, value, 0, 0, 0))))
    first, second = script.tick(), script.tick()

    assert (len(first), len(second)) == (BUDGET, 5)


def test_counts_both_addresses_of_a_4dc_as_one_board(script: Script) -> None:
    line = script.robot._machine.lines[BUS]
    for value in range(BUDGET):
        line.send(3, (3, bytes((0x2C, value, 0, 0, 0))))
        line.send(4, (4, bytes((0x2C, value, 0, 0, 0))))

    assert len(script.tick()) == BUDGET


def test_a_bus_that_is_off_leaves_the_others_alone() -> None:
    boards = [replace(b, bus=2) if b.name == "r_strain" else b for b in EMULATED.boards]
    sensors = [replace(s, bus=2) for s in EMULATED.sensors]
    two = replace(EMULATED, boards=tuple(boards), sensors=tuple(sensors))
    hand = ScriptedBus()
    script = Script(two, {2: hand})
    script.ready()
    hand.bus_state = can.BusState.ERROR
    hand.wrench.clear()
    script.tick(500)

    assert [bus.state for bus in script.robot.status().buses] == ["active", "off"]
    assert script.robot.is_fresh(PITCH, script.now_ns)
    assert script.robot.status().faults[0] == "bus 2 is off: no frame gets through"
    assert len(script.robot.status().faults) == 2  # and its one board silent
