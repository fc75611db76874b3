"""The torso and right arm of the first slice, wired as on the robot."""

from dataclasses import replace

import icub_models
import pytest

from firmware_sim.description import (
    AxisSpec,
    BoardSpec,
    MotorSpec,
    PlantSpec,
    RigSpec,
    SensorSpec,
)


def drive(
    nm_per_a: float, ohm: float, volt: float, rotor_kg_m2: float, coulomb: float, viscous: float
) -> MotorSpec:
    """A row of the fact sheet's table: all values at the joint, gear 100."""
    return MotorSpec(
        supply_v=volt,
        torque_constant_nm_a=nm_per_a / 100.0,
        resistance_ohm=ohm,
        gear=100.0,
        rotor_inertia_kg_m2=rotor_kg_m2 / 100.0**2,
        coulomb_nm=coulomb,
        viscous_nms_rad=viscous,
    )


TORSO = drive(4.7, 1.0, 36.0, 0.15, 1.5, 1.5)
TORSO_YAW = drive(3.6, 1.0, 36.0, 0.10, 1.0, 1.0)
SHOULDER = drive(4.7, 1.0, 36.0, 0.10, 1.0, 1.0)
SHOULDER_YAW = drive(3.0, 1.2, 36.0, 0.05, 0.6, 0.6)
ELBOW = drive(3.0, 1.2, 36.0, 0.05, 0.5, 0.5)
PROSUP = drive(4.0, 24.0, 12.0, 0.004, 0.08, 0.05)
WRIST = drive(4.0, 24.0, 12.0, 0.004, 0.06, 0.05)


def axis(
    wired: tuple[int, int, int],
    joint: str,
    motor: MotorSpec,
    encoder: tuple[float, float, int | None],
    limit_deg: tuple[float, float],
    start_deg: float = 0.0,
) -> AxisSpec:
    return AxisSpec(
        bus=wired[0],
        address=wired[1],
        axis=wired[2],
        joint=joint,
        motor=motor,
        ticks_per_deg=encoder[0],
        zero_deg=encoder[1],
        absolute_offset=encoder[2],
        hard_stop_deg=(limit_deg[0] - 5.0, limit_deg[1] + 5.0),
        limit_deg=limit_deg,
        start_deg=start_deg,
    )


AXES = (
    axis((0, 6, 1), "torso_pitch", TORSO, (11.375, 180.0, 836), (-22.0, 70.0)),
    axis((0, 6, 0), "torso_roll", TORSO, (11.375, 180.0, 364), (-30.0, 30.0)),
    axis((0, 5, 0), "torso_yaw", TORSO_YAW, (11.375, 180.0, 2613), (-50.0, 50.0)),
    axis((2, 1, 0), "r_shoulder_pitch", SHOULDER, (11.375, 177.0, 348), (-95.0, 5.0), -30.0),
    axis((2, 1, 1), "r_shoulder_roll", SHOULDER, (11.375, 37.0, 2), (0.0, 160.0), 30.0),
    axis((2, 2, 0), "r_shoulder_yaw", SHOULDER_YAW, (-11.375, -198.0, 448), (-37.0, 75.0)),
    axis((2, 2, 1), "r_elbow", ELBOW, (11.375, 180.0, 1371), (15.0, 106.0), 45.0),
    axis((2, 3, 0), "r_wrist_prosup", PROSUP, (-706.67, -74.0, None), (-50.0, 50.0)),
    axis((2, 3, 1), "r_wrist_pitch", WRIST, (11.375, 180.0, 3202), (-65.0, 10.0)),
    axis((2, 4, 0), "r_wrist_yaw", WRIST, (-11.375, -180.0, 1058), (-25.0, 25.0)),
)

BOARDS = (
    BoardSpec(bus=0, address=5, type="bll_ie", firmware=(2, 0x54)),
    BoardSpec(bus=0, address=6, type="bll_ie", firmware=(2, 0x52)),
    BoardSpec(bus=2, address=1, type="bll_ie", firmware=(2, 0x50)),
    BoardSpec(bus=2, address=2, type="bll_ie", firmware=(2, 0x57)),
    BoardSpec(bus=2, address=3, type="dc4", firmware=(2, 0x19)),
    BoardSpec(bus=2, address=13, type="strain", firmware=(3, 0)),
)

SENSOR = SensorSpec(
    name="right_arm",
    frame="r_arm_ft_sensor",
    bus=2,
    address=13,
    full_scale=(1500.0, 1500.0, 1500.0, 35.0, 35.0, 35.0),
)


@pytest.fixture(scope="session")
def spec() -> RigSpec:
    """Boards, axes and sensor of torso and right arm, seed 1."""
    urdf = str(icub_models.get_model_file("iCubLisboa01"))
    plant = PlantSpec(urdf=urdf, tip_frame="r_hand_dh_frame", seed=1)
    return RigSpec(boards=BOARDS, axes=AXES, sensors=(SENSOR,), plant=plant)


@pytest.fixture(scope="session")
def exact_spec(spec: RigSpec) -> RigSpec:
    """The same with the masses of the URDF and a sensor without offset and noise."""
    sensor = replace(SENSOR, noise=(0.0, 0.0), offset=(0.0, 0.0))
    plant = replace(spec.plant, mass_error=0.0, com_error_m=0.0)
    return replace(spec, sensors=(sensor,), plant=plant)
