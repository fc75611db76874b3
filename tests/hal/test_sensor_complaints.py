"""What users of the real robot complained about, as far as sensors are concerned (can-protocol 13).

Each test is named after what it looked like to them.
"""

from collections.abc import Iterator

import msgspec
import pytest

from firmware_sim.boards.mtb import Mtb
from firmware_sim.boards.strain import Strain
from hal.boards.strain import Strain as HostStrain
from hal.readings import ForceTorqueSample, HallSample, InertialSample, SkinSample
from hal.wire.can import source_of
from tests.hal.sensor_bench import ADDRESSES, BOARDS, BUS, SensorBench, described

STRAIN = "strain_ft"


@pytest.fixture
def bench() -> Iterator[SensorBench]:
    bench = SensorBench().open()
    bench.tick(20)
    yield bench
    bench.close()


def strain(bench: SensorBench) -> Strain:
    board = bench.emulated("strain")
    assert isinstance(board, Strain)
    return board


def samples(bench: SensorBench, milliseconds: int) -> list[ForceTorqueSample]:
    bench.tick()  # what is under way arrives
    bench.take(STRAIN, ForceTorqueSample)
    bench.tick(milliseconds)
    return bench.take(STRAIN, ForceTorqueSample)


def optional(*names: str) -> SensorBench:
    return SensorBench(
        described(
            {
                name: msgspec.structs.replace(board, required=name not in names)
                for name, board in BOARDS.items()
            }
        )
    )


# One constant value after an internal error; unchanged data taken for a time-out.


def test_constant_ft_values_are_frozen_and_not_a_time_out(bench: SensorBench) -> None:
    strain(bench).frozen = True
    found = samples(bench, 250)
    assert len(found) == 250  # frames come as before
    assert not found[0].frozen
    assert found[-1].frozen
    assert not found[-1].is_fresh
    faults = bench.faults
    assert faults == (
        "strain_ft is frozen: one constant sample for 0.100 s, "
        "internal error of the sensor, switch it off and on",
    )


def test_a_frozen_ft_is_noticed_after_100_ms_and_not_before(bench: SensorBench) -> None:
    strain(bench).frozen = True
    first = next(i for i, sample in enumerate(samples(bench, 200)) if sample.frozen)
    assert 98 <= first <= 101


def test_a_thawed_ft_is_fresh_at_once(bench: SensorBench) -> None:
    strain(bench).frozen = True
    bench.tick(150)
    strain(bench).frozen = False
    assert [sample.is_fresh for sample in samples(bench, 3)] == [True] * 3
    assert bench.faults[-1] == "strain_ft is no longer frozen"


def test_an_ft_whose_words_repeat_now_and_then_is_not_frozen(bench: SensorBench) -> None:
    bench.noise = lambda ms: ms // 90 & 1  # one count, each 90 ms
    assert not any(sample.frozen for sample in samples(bench, 500))
    assert bench.faults == ()


def test_one_channel_that_moves_is_enough_to_be_alive(bench: SensorBench) -> None:
    strain(bench).stuck_words = dict.fromkeys(range(5), 0x8000)
    assert not any(sample.frozen for sample in samples(bench, 300))


def test_a_silent_ft_is_a_time_out_and_neither_frozen_nor_saturated(bench: SensorBench) -> None:
    strain(bench).silent = True
    assert samples(bench, 200) == []
    (fault,) = bench.faults
    assert fault.startswith("board strain (bus 1, address 13) silent for 0.")


def test_a_silent_ft_is_reported_within_100_ms(bench: SensorBench) -> None:
    strain(bench).silent = True
    bench.tick(101)
    assert len(bench.faults) == 1


# Readings of 2000 Nm from a saturated sensor, and an error flood.


def test_a_saturated_ft_never_passes_as_fresh_nor_as_late(bench: SensorBench) -> None:
    strain(bench).stuck_words = {3: 64500}
    found = samples(bench, 250)
    assert len(found) == 250
    assert not any(sample.is_fresh or sample.frozen for sample in found)
    assert found[-1].channels == (0, 0, 0, 2, 0, 0)
    assert all(abs(sample.torque_nm[0]) < 0.01 for sample in found)  # the last good value
    assert not any("silent" in fault for fault in bench.faults)


def test_a_saturated_ft_is_reported_once_a_second_and_counted_per_channel(
    bench: SensorBench,
) -> None:
    strain(bench).stuck_words = {0: 500, 3: 64500}
    bench.tick(2500)
    assert bench.faults == ("strain_ft saturated: Fx low, Tx high",) * 3
    host = bench.host("strain")
    assert isinstance(host, HostStrain)
    watch = host.supervision
    assert watch.saturated_channels == [
        watch.saturated_samples,
        0,
        0,
        watch.saturated_samples,
        0,
        0,
    ]
    assert watch.saturated_samples in (2499, 2500)


def test_an_ft_that_is_no_longer_saturated_is_fresh_at_once(bench: SensorBench) -> None:
    strain(bench).stuck_words = {0: 500}
    bench.tick(300)
    strain(bench).stuck_words = {}
    assert samples(bench, 3)[-1].is_fresh


# Zero before the first frame looks like data; FT status always OK.


def test_there_is_no_ft_sample_before_the_first_frame() -> None:
    bench = SensorBench()
    while bench.robot.phase != "configuring":
        bench.tick()
        assert bench.take(STRAIN, ForceTorqueSample) == []
    bench.close()


# Frames lost on the way, one half of a sample missing.


def test_half_a_pair_is_lost_counted_and_reported(bench: SensorBench) -> None:
    strain(bench).silent = True
    bench.tick(2)
    bench.say("3DB 008000800080", "3DA 008000800080", "3DA 008000800080")
    assert samples(bench, 1) == []
    assert bench.drops == {
        "torque frame without its force frame": 1,
        "force frame without its torque frame": 1,
    }
    assert bench.faults == (
        "strain_ft: torque frame without its force frame, frames are lost on its bus",
    )


def test_a_restarted_ft_is_named_and_streams_again(bench: SensorBench) -> None:
    strain(bench).reboot_ms = 30
    bench.tick(40)
    assert bench.faults == ("board strain (bus 1, address 13) has restarted",)
    bench.tick(400)
    assert len(samples(bench, 50)) == 50
    assert "configured again" in bench.faults[-1]


# Cannot be started again after Ctrl-C: an FT keeps streaming.


def test_boards_that_stream_already_do_not_disturb_the_start() -> None:
    bench = SensorBench()
    bench.say("20D 0700", "20A 0700", "20E 0700", "20C 0700", "20C 4F0C05", "20B 3417800000000000")
    bench.say("20B 3505")
    bench.run_boards(50)  # the host that did this is gone, ours is not yet there
    bench.hear_nothing_of_it()
    bench.open()
    assert (bench.robot.phase, bench.faults) == ("idle", ())
    for name in (STRAIN, "strain2_ft", "mais", "mtb", "imu"):
        bench.take(name, object)
    bench.tick(100)
    assert len(bench.take(STRAIN, ForceTorqueSample)) == 100
    assert (bench.faults, bench.drops) == ((), {})
    bench.close()


# Skin without power: the robot does not start.


def test_skin_without_power_does_not_keep_the_robot_from_starting() -> None:
    bench = optional("mtb")
    bench.emulated("mtb").powered = False
    bench.open()
    assert bench.robot.phase == "idle"
    assert any("board mtb (bus 1, address 12)" in fault for fault in bench.faults)
    bench.tick(50)
    assert len(bench.take("mais", HallSample)) >= 5
    bench.close()


def test_skin_that_gets_power_later_is_taken_up() -> None:
    bench = optional("mtb")
    bench.emulated("mtb").powered = False
    bench.open()
    bench.emulated("mtb").power_cycle()
    bench.tick(1500)
    assert bench.take("mtb", SkinSample)
    bench.close()


# canBusInertialMTB: the period is never copied, an uninitialised value is sent.


def test_the_period_of_the_inertial_sensors_reaches_the_board() -> None:
    bench = SensorBench()
    sent = []
    while bench.robot.phase != "idle":
        bench.tick()
        sent += [data for can_id, data, _ in bench.heard if can_id == 0x20C]
    assert [data.hex() for data in sent if data[0] == 0x4F] == ["4f000a", "4f0c0a"]
    bench.close()


# canBusSkin: matched by source address only; errors by message and not by triangle.


def test_an_inertial_frame_that_looks_like_skin_is_none(bench: SensorBench) -> None:
    board = bench.emulated("mtb")
    assert isinstance(board, Mtb)
    board.gyro_deg_s = [0.56, 0.0, 0.0]  # 64 counts: the frame begins with 0x40
    bench.tick(200)
    taken = bench.take("mtb", object)
    gyros = [sample.gyro_rad_s[0] for sample in taken if isinstance(sample, InertialSample)]
    skins = [sample.taxels for sample in taken if isinstance(sample, SkinSample)]
    assert gyros[-1] == pytest.approx(0.00977, abs=1e-4)
    assert set(skins) == {bytes([240] * 192)}
    assert bench.drops == {}


def test_a_skin_frame_of_another_board_is_not_taken(bench: SensorBench) -> None:
    bench.say("493 40F0F0F0F0F0F0F0")
    bench.tick()
    assert bench.drops == {f"unexpected identifier 0x493 on bus {BUS}": 1}


def test_triangle_errors_stand_by_triangle() -> None:
    bench = SensorBench()
    board = bench.emulated("mtb")
    assert isinstance(board, Mtb)
    board.triangle_errors[9] = 2
    board.triangle_errors[2] = 2
    board.taxels[9 * 12] = 100
    bench.open().tick(100)
    sample = bench.take("mtb", SkinSample)[-1]
    expected = bytearray(16)
    expected[2] = expected[9] = 2
    assert sample.errors == bytes(expected)
    assert sample.taxels[9 * 12] == 240  # nothing was read
    name = f"board mtb (bus {BUS}, address {ADDRESSES['mtb']})"
    assert bench.faults == (f"{name}: not connected: triangle 2, 9",)
    bench.close()


def test_a_loose_triangle_is_reported_once_a_second(bench: SensorBench) -> None:
    board = bench.emulated("mtb")
    assert isinstance(board, Mtb)
    for i in range(60):
        board.triangle_errors[5] = 2 * (i & 1)
        bench.tick(40)
    assert 2 <= len(bench.faults) <= 3
    board.triangle_errors[5] = 0
    bench.tick(1100)
    assert bench.faults[-1].endswith(("every triangle answers again", "triangle 5"))


# Errors of a neighbour are taken for one's own.


def test_a_fault_of_one_sensor_leaves_the_streams_of_the_others_alone(bench: SensorBench) -> None:
    strain(bench).frozen = True
    bench.emulated("mais").powered = False
    bench.emulated("imu").silent = True
    for name in ("strain2_ft", "mtb"):
        bench.take(name, object)
    bench.tick(200)
    assert len(bench.take("strain2_ft", ForceTorqueSample)) == 200
    assert [type(s) for s in bench.take("mtb", object)].count(SkinSample) == 5
    assert bench.drops == {}


def test_every_sensor_sends_at_identifiers_of_its_own(bench: SensorBench) -> None:
    senders: dict[int, int] = {}
    for _ in range(100):
        bench.tick()
        for can_id, _, _ in bench.heard:
            if can_id >> 8 in (3, 4, 5):
                senders.setdefault(can_id, source_of(can_id))
    assert set(senders.values()) == set(ADDRESSES.values())
