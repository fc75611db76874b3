"""What sensor boards feel of the plant."""

from dataclasses import replace

import numpy as np
import pytest

from firmware_sim.boards.imu import Imu
from firmware_sim.boards.mais import Mais
from firmware_sim.boards.mtb import Mtb
from firmware_sim.boards.strain2 import Strain2
from firmware_sim.description import AxisSpec, BoardSpec, FingerSpec, MotorSpec, RigSpec
from firmware_sim.network import RigError
from firmware_sim.rig import Rig

SKIN_BUS, HAND_BUS = 8, 6
MTB = BoardSpec(bus=SKIN_BUS, address=14, type="mtb", firmware=(2, 0x11), frame="r_hand")
IMU = BoardSpec(bus=0, address=14, type="imu", firmware=(1, 0), frame="chest")
HAND = (
    BoardSpec(bus=HAND_BUS, address=7, type="dc4", firmware=(2, 0x30)),
    BoardSpec(bus=HAND_BUS, address=14, type="mais", firmware=(3, 1)),
)
FINGER_MOTOR = MotorSpec(
    supply_v=12.0,
    torque_constant_nm_a=0.005,
    resistance_ohm=30.0,
    gear=256.0,
    rotor_inertia_kg_m2=5e-8,
    coulomb_nm=0.03,
    viscous_nms_rad=0.01,
)
INDEX = AxisSpec(
    bus=HAND_BUS,
    address=7,
    axis=0,
    joint="r_index_distal",
    motor=FINGER_MOTOR,
    ticks_per_deg=-2.5,
    zero_deg=-200.0,
    limit_deg=(0.0, 170.0),
    start_deg=20.0,
    mechanism="tendon",
    fingers=(
        FingerSpec(name="index_middle", range_deg=(0.0, 85.0), hall=(4,)),
        FingerSpec(name="index_tip", range_deg=(0.0, 85.0), hall=(5,)),
    ),
)


@pytest.fixture
def rig(exact_spec: RigSpec) -> Rig:
    """Torso and right arm without drives under way, with skin, an IMU and one finger."""
    boards = (*exact_spec.boards, MTB, IMU, *HAND)
    return Rig(replace(exact_spec, boards=boards, axes=(*exact_spec.axes, INDEX)))


def run(rig: Rig, ticks: int) -> None:
    for _ in range(ticks):
        rig.step({})


def drive(rig: Rig, pwm: int, ticks: int) -> None:
    """Put duty on the finger's motor behind its board's back."""
    x = rig.joints.index("r_index_distal")
    plant = rig.plant
    duty, on = np.zeros(len(rig.joints)), np.zeros(len(rig.joints), dtype=np.bool_)
    duty[x], on[x] = pwm, True
    for _ in range(ticks):
        plant.step(duty, on)
    rig._senses.feel()


def mtb(rig: Rig) -> Mtb:
    board: object = rig.board(SKIN_BUS, 14)
    assert isinstance(board, Mtb)
    return board


def mais(rig: Rig) -> Mais:
    board: object = rig.board(HAND_BUS, 14)
    assert isinstance(board, Mais)
    return board


def test_skin_board_in_a_hand_at_rest_feels_one_g(rig: Rig) -> None:
    rig.step({})
    assert np.linalg.norm(mtb(rig).acceleration_g) == pytest.approx(9.81 / 9.80665)
    assert mtb(rig).gyro_deg_s == [0.0, 0.0, 0.0]


def test_gyroscope_feels_the_arm_fall(rig: Rig) -> None:
    run(rig, 101)
    assert np.linalg.norm(mtb(rig).gyro_deg_s) > 5.0


def test_imu_in_the_chest_stands_upright(rig: Rig) -> None:
    rig.step({})
    board: object = rig.board(0, 14)
    assert isinstance(board, Imu)
    w, x, y, z = board.quaternion
    gravity = np.array(board.acceleration_m_s2)
    # turned into the base's axes by the board's own quaternion, gravity is vertical again
    u = np.array([x, y, z])
    upright = gravity + 2.0 * np.cross(u, np.cross(u, gravity) + w * gravity)
    assert upright == pytest.approx([0.0, 0.0, 9.81], abs=1e-6)
    assert np.linalg.norm(board.magnetic_ut) == pytest.approx(np.hypot(22.0, 42.0))


def test_strain2_feels_motion_in_the_axes_of_its_imu(exact_spec: RigSpec) -> None:
    def changed(board: BoardSpec) -> BoardSpec:
        return replace(board, type="strain2") if board.type == "strain" else board

    rig = Rig(replace(exact_spec, boards=tuple(changed(board) for board in exact_spec.boards)))
    rig.step({})
    board: object = rig.board(2, 13)
    assert isinstance(board, Strain2)
    force = rig.plant.wrenches[0][:3] / np.linalg.norm(rig.plant.wrenches[0][:3])
    felt = np.array(board.motion.acceleration_m_s2) / 9.81
    # what hangs on the gauges at rest pulls down: x_imu = -y, y_imu = -x, z_imu = -z, and up is up
    assert felt == pytest.approx([force[1], force[0], force[2]], abs=1e-3)


def test_touch_lowers_the_twelve_taxels_of_a_triangle(rig: Rig) -> None:
    rig.touch(SKIN_BUS, 14, 3, 0.25)
    taxels = mtb(rig).taxels
    assert taxels[36:48] == [180] * 12
    assert taxels[:36] == [240] * 36
    assert taxels[48:] == [240] * 144
    rig.touch(SKIN_BUS, 14, 3, 0.0)
    assert mtb(rig).taxels == [240] * 192


@pytest.mark.parametrize(("address", "triangle", "pressure"), [(14, 16, 0.5), (14, 0, 1.5)])
def test_touch_that_makes_no_sense_is_refused(
    rig: Rig, address: int, triangle: int, pressure: float
) -> None:
    with pytest.raises(RigError, match="cannot touch"):
        rig.touch(SKIN_BUS, address, triangle, pressure)


def test_board_without_skin_cannot_be_touched(rig: Rig) -> None:
    with pytest.raises(RigError, match="has no skin"):
        rig.touch(2, 1, 0, 0.5)


def test_hall_sensors_show_where_the_finger_stands_at_power_up(rig: Rig) -> None:
    rig.step({})
    # (20 - 200) x -2.5 = 450 ticks in two bytes
    assert sum(mais(rig).hall[4:6]) == pytest.approx(450, abs=1)
    assert mais(rig).hall[6:] == [0] * 9
    assert np.degrees(rig.q_rad[-1]) == pytest.approx(20.0, abs=0.01)


def test_motor_closes_the_finger_and_runs_on_against_its_stops(rig: Rig) -> None:
    drive(rig, 1333, 3000)
    assert np.degrees(rig.q_rad[-1]) == pytest.approx(170.0, abs=0.1)
    assert np.degrees(rig.plant.x[-1]) > 180.0  # the tendon stretches
    assert mais(rig).hall[4:6] == [38, 38]  # 250 - 85 x 2.5 = 37.5
    drive(rig, -1333, 6000)
    assert rig.q_rad[-1] == 0.0
    assert rig.plant.x[-1] < -1.0  # slack


def test_finger_stops_at_what_it_grasps_and_the_other_closes(rig: Rig) -> None:
    rig.grasp("index_middle", 40.0)
    drive(rig, 1333, 3000)
    assert mais(rig).hall[4:6] == [150, 38]  # 250 - 40 x 2.5, and closed
    rig.grasp("index_middle", None)
    drive(rig, 1333, 1000)
    assert mais(rig).hall[4:6] == [38, 38]


def test_unknown_finger_is_refused_with_what_there_is(rig: Rig) -> None:
    with pytest.raises(
        RigError, match="no finger joint 'thumb'; there are index_middle, index_tip"
    ):
        rig.grasp("thumb", 10.0)


def test_motors_encoder_counts_what_it_winds(rig: Rig) -> None:
    rig.step({})
    port = rig.board(HAND_BUS, 7).ports[0]
    assert port.raw_encoder == 0
    before = rig.plant.x[-1]
    drive(rig, 1333, 500)
    rig.step({})
    wound_deg = np.degrees(rig.plant.x[-1] - before)
    assert wound_deg > 10.0
    assert port.raw_encoder == pytest.approx(3.0 * wound_deg, abs=30.0)  # one step older
