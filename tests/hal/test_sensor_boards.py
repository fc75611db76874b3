"""Hall, skin, inertial and IMU samples in physical units, from emulated boards and from bytes."""

import math
from collections.abc import Iterator

import msgspec
import pytest

from firmware_sim.boards.imu import Imu as EmulatedImu
from firmware_sim.boards.mais import Mais as EmulatedMais
from firmware_sim.boards.mtb import Mtb as EmulatedMtb
from firmware_sim.boards.strain2 import Strain2 as EmulatedStrain2
from hal.boards.mtb import Mtb
from hal.boards.strain2 import Strain2
from hal.readings import ForceTorqueSample, HallSample, ImuSample, InertialSample, SkinSample
from tests.hal.sensor_bench import BOARDS, SensorBench, described


@pytest.fixture
def bench() -> Iterator[SensorBench]:
    bench = SensorBench().open()
    yield bench
    bench.close()


def emulated_mtb(bench: SensorBench) -> EmulatedMtb:
    board = bench.emulated("mtb")
    assert isinstance(board, EmulatedMtb)
    return board


def fresh_skin(bench: SensorBench) -> SkinSample:
    bench.tick(80)
    return bench.take("mtb", SkinSample)[-1]


def quiet(bench: SensorBench, name: str) -> None:
    """Let a board send nothing, so that the test can speak for it."""
    bench.emulated(name).silent = True
    bench.tick(2)
    bench.take(name, object)


def test_every_board_is_found_and_streams_without_a_fault(bench: SensorBench) -> None:
    assert bench.robot.phase == "idle"
    bench.take("strain_ft", object), bench.take("mais", object), bench.take("mtb", object)
    bench.tick(400)
    assert len(bench.take("strain_ft", ForceTorqueSample)) == 256  # the last ones
    assert len(bench.take("mais", HallSample)) == 40
    samples = bench.take("mtb", object)
    assert [type(s) for s in samples].count(SkinSample) == 10
    assert [type(s) for s in samples].count(InertialSample) == 40
    assert len(bench.take("imu", ImuSample)) >= 40
    assert (bench.faults, bench.drops) == ((), {})


def test_mais_is_read_in_the_order_of_the_sensors(bench: SensorBench) -> None:
    board = bench.emulated("mais")
    assert isinstance(board, EmulatedMais)
    board.hall[:] = range(10, 25)
    bench.tick(20)
    sample = bench.take("mais", HallSample)[-1]
    assert sample.hall_counts == tuple(range(10, 25))


def test_mais_frames_of_the_worked_example(bench: SensorBench) -> None:
    quiet(bench, "mais")
    bench.say("3EC 10FFFFF0FFFFF8", "3ED 0102030405060708")
    bench.tick()
    (sample,) = bench.take("mais", HallSample)
    assert sample.hall_counts == (16, 255, 255, 240, 255, 255, 248, 1, 2, 3, 4, 5, 6, 7, 8)
    assert sample.arrival_ns == bench.watch.ns


def test_mais_halves_of_different_periods_are_no_sample(bench: SensorBench) -> None:
    quiet(bench, "mais")
    bench.say("3EC 10FFFFF0FFFFF8")
    bench.tick(12)
    bench.say("3ED 0102030405060708")
    bench.tick()
    bench.say("3ED 0102030405060708", "3EC 10FFFFF0FFFFF8", "3EC 10FF", "3ED 01")
    bench.tick()
    assert bench.take("mais", HallSample) == []
    assert bench.drops == {
        "second Hall frame without the first": 2,
        "first Hall frame without the second": 1,
        "HALL_0_6 of wrong length": 1,
        "HALL_7_14 of wrong length": 1,
    }


def test_skin_has_twelve_taxels_per_triangle(bench: SensorBench) -> None:
    emulated_mtb(bench).taxels[3 * 12 + 2] = 200
    emulated_mtb(bench).taxels[15 * 12 + 11] = 17
    sample = fresh_skin(bench)
    expected = bytearray([240] * 192)
    expected[38], expected[191] = 200, 17
    assert sample.taxels == bytes(expected)
    assert (sample.errors, sample.heard, sample.no_load) == (bytes(16), 0xFFFF, 240)


def test_skin_says_which_taxels_are_out_of_range(bench: SensorBench) -> None:
    emulated_mtb(bench).taxels[12 * 4 + 11] = 400
    sample = fresh_skin(bench)
    assert sample.out_of_range[4] == 1 << 11
    assert sum(sample.out_of_range) == 1 << 11
    assert sample.taxels[12 * 4 + 11] == 255


def test_skin_sample_without_some_triangles_says_so(bench: SensorBench) -> None:
    emulated_mtb(bench).patch.set_triangles(8, 15, 2, 0, 0)
    fresh_skin(bench)
    assert fresh_skin(bench).heard == 0x00FF


def test_old_style_skin_frames_are_taken_too(bench: SensorBench) -> None:
    quiet(bench, "mtb")
    heads = [f"3C{triangle:X} 4001020304050607" for triangle in range(16)]
    tails = [f"3C{triangle:X} C008090A0B0C0000" for triangle in range(16)]
    bench.say(*heads, *tails)
    bench.tick()
    sample = bench.take("mtb", SkinSample)[-1]
    assert sample.taxels == bytes(range(1, 13)) * 16


def test_half_triangles_are_dropped_and_counted(bench: SensorBench) -> None:
    quiet(bench, "mtb")
    head, tail = "4C3 40F0F0F0F0F0F0F0", "4C3 C0F0F0F0F0F00000"
    bench.say(tail, head, head, "4C3 F0F0F0F0F0F0F0F0", "4C3 40")
    bench.tick(50)
    bench.say(tail)  # the head was of another period
    bench.tick()
    assert bench.take("mtb", SkinSample) == []
    assert {cause: count for cause, count in bench.drops.items() if "triangle" in cause} == {
        "tail of a triangle without its head": 2,
        "head of a triangle without its tail": 1,
    }
    assert bench.drops["skin frame that is neither head nor tail"] == 1
    assert bench.drops["skin frame of wrong length"] == 1


def test_mtb_motion_in_si_units(bench: SensorBench) -> None:
    emulated_mtb(bench).gyro_deg_s = [90.0, -45.0, 0.0]
    emulated_mtb(bench).acceleration_g = [0.0, -1.0, 0.5]
    bench.tick(20)
    sample = bench.take("mtb", InertialSample)[-1]
    assert sample.gyro_rad_s == pytest.approx((math.pi / 2, -math.pi / 4, 0.0), abs=1e-4)
    assert sample.acceleration_m_s2 == pytest.approx((0.0, -9.80665, 4.9033), abs=1e-3)


def test_lone_inertial_frames_are_dropped_and_counted(bench: SensorBench) -> None:
    quiet(bench, "mtb")
    bench.say("5C1 000000000040", "5C0 000000000000", "5C0 000000000000", "5C0 00", "5C1 00")
    bench.tick()
    assert bench.take("mtb", InertialSample) == []
    assert bench.drops == {
        "accelerometer frame without its gyroscope frame": 1,
        "gyroscope frame without its accelerometer frame": 2,
        "GYROSCOPE of wrong length": 1,
        "ACCELEROMETER of wrong length": 1,
    }


def test_an_mtb_whose_frame_is_not_known_sends_skin_only() -> None:
    boards = {**BOARDS, "mtb": msgspec.structs.replace(BOARDS["mtb"], frame="")}
    bench = SensorBench(described(boards)).open()
    bench.tick(100)
    assert {type(sample) for sample in bench.take("mtb", object)} == {SkinSample}
    bench.close()


def test_period_of_the_robot_file_is_set() -> None:
    boards = {
        **BOARDS,
        "mtb": msgspec.structs.replace(BOARDS["mtb"], period_ms=20),
        "mais": msgspec.structs.replace(BOARDS["mais"], period_ms=5),
        "strain": msgspec.structs.replace(BOARDS["strain"], period_ms=2),
    }
    bench = SensorBench(described(boards)).open()
    for name in ("mtb", "mais", "strain_ft"):
        bench.take(name, object)
    bench.tick(200)
    assert len(bench.take("mtb", SkinSample)) == 10
    assert len(bench.take("mais", HallSample)) == 40
    assert len(bench.take("strain_ft", ForceTorqueSample)) == 100
    bench.close()


def test_imu_in_si_units(bench: SensorBench) -> None:
    board = bench.emulated("imu")
    assert isinstance(board, EmulatedImu)
    board.quaternion = [0.5, 0.5, -0.5, 0.5]
    board.gyro_deg_s = [180.0, 0.0, -90.0]
    board.acceleration_m_s2 = [1.0, -2.0, 9.81]
    board.magnetic_ut = [20.0, 0.0, -40.0]
    bench.tick(20)
    sample = bench.take("imu", ImuSample)[-1]
    assert sample.quaternion == (0.5, 0.5, -0.5, 0.5)
    assert sample.gyro_rad_s == pytest.approx((math.pi, 0.0, -math.pi / 2))
    assert sample.acceleration_m_s2 == pytest.approx((1.0, -2.0, 9.81))
    assert sample.magnetic_t == pytest.approx((20e-6, 0.0, -40e-6))
    assert (sample.calibration, sample.lost) == ((3, 3, 3), 0)


def acquisition(sequence: int) -> list[str]:
    """An acquisition of the IMU at address 11 by hand."""
    number = f"{sequence:02X}"
    return [
        f"5B3 {number}00000000000000",
        f"5B3 {number}01000000000000",
        f"5B3 {number}02000000000000",
        "5B4 0040000000000000",
        f"5B5 {number}03030300000000",
    ]


def test_gaps_in_the_imu_sequence_are_counted_over_the_wrap(bench: SensorBench) -> None:
    quiet(bench, "imu")
    bench.host("imu").configure().send(None)  # it counts anew
    for sequence in (253, 254, 1, 2):
        bench.say(*acquisition(sequence))
        bench.tick()
    assert [(s.sequence, s.lost) for s in bench.take("imu", ImuSample)] == [
        (253, 0),
        (254, 0),
        (1, 2),
        (2, 0),
    ]
    assert bench.faults[-1] == "board imu (bus 1, address 11) lost 2 IMU acquisitions (2 in all)"


def test_an_incomplete_acquisition_is_no_sample(bench: SensorBench) -> None:
    quiet(bench, "imu")
    first, _, *rest = acquisition(7)
    bench.say(first, *rest, *acquisition(8)[:2], *acquisition(9), "5B3 00", "5B4 00", "5B5 00")
    bench.tick()
    assert [sample.sequence for sample in bench.take("imu", ImuSample)] == [9]
    assert bench.drops == {
        "incomplete acquisition of an IMU": 2,
        "IMU_TRIPLE of wrong length": 1,
        "IMU_QUATERNION of wrong length": 1,
        "IMU_STATUS of wrong length": 1,
    }


def test_strain2_tells_its_temperature(bench: SensorBench) -> None:
    host, board = bench.host("strain2"), bench.emulated("strain2")
    assert isinstance(host, Strain2)
    assert isinstance(board, EmulatedStrain2)
    assert host.temperature_degc is None
    board.temperature_degc = 41.3
    bench.tick(5001)
    assert host.temperature_degc == pytest.approx(41.3)


@pytest.mark.parametrize("name", ["strain", "strain2", "mais", "mtb", "imu"])
def test_a_board_that_loses_power_is_named_and_comes_back_by_itself(
    bench: SensorBench, name: str
) -> None:
    bench.tick(50)
    bench.emulated(name).powered = False
    bench.tick(150)
    named = {other for other in BOARDS for fault in bench.faults if f"board {other} " in fault}
    assert named == {name}
    assert any(" silent for " in fault for fault in bench.faults)
    sensor = f"{name}_ft" if "strain" in name else name
    bench.take(sensor, object)
    bench.emulated(name).power_cycle()
    bench.tick(1500)
    assert len(bench.take(sensor, object)) > 5
    assert "configured again" in bench.faults[-1]


def test_a_discovery_by_somebody_else_is_survived(bench: SensorBench) -> None:
    bench.say("70F FF")
    bench.tick(1700)
    for name in ("strain_ft", "strain2_ft", "mais", "mtb", "imu"):
        bench.take(name, object)
    bench.tick(100)
    for name in ("strain_ft", "strain2_ft", "mais", "mtb", "imu"):
        assert bench.take(name, object), name


def test_closing_silences_every_board(bench: SensorBench) -> None:
    bench.robot.close(bench.watch.ns)
    bench.tick(3)
    for _ in range(100):
        bench.tick()
        assert bench.heard == []


def test_velocity_counts_and_bridges_mean_nothing_to_a_sensor() -> None:
    assert (Mtb.velocity_count(5), Mtb.full_pwm, Mtb.max_current_ma) == (1.0, 0, 0)
