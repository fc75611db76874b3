"""The arm that the scripted and the emulated boards belong to.

Factors, zeros and limits are those of a real arm, so that the worked examples of the CAN protocol's
fact sheet (section 12) can be checked against what the HAL sends.
"""

from typing import Any

from hal.description import (
    Board,
    Calibration,
    ForceTorqueSensor,
    Impedance,
    Joint,
    PositionPid,
    RobotDescription,
    TorquePid,
    TorqueSource,
)

BUS = 1

PITCH, ROLL, PROSUP, WRIST = range(4)  # indices of the joints

SHOULDER_PID = PositionPid(
    kp=32000, ki=60, kd=50, shift=13, integral_limit=800, output_limit=800, stiction_up=3
)
TORQUE_PID = TorquePid(
    kp=-76,
    ki=0,
    kd=0,
    shift=14,
    integral_limit=0,
    output_limit=800,
    kff=19,
    bemf=18460,
    bemf_shift=7,
    filter=3,
)
STIFF_SPRING = Impedance(stiffness_nm_deg=0.4, damping_nms_deg=0.03)


def joint(name: str, address: int, axis: int, **changes: Any) -> Joint:
    """A joint like the right shoulder pitch, but for what `changes` says."""
    values: dict[str, Any] = {
        "name": name,
        "part": "right_arm",
        "bus": BUS,
        "address": address,
        "axis": axis,
        "ticks_per_deg": 11.375,
        "zero_deg": 177.0,
        "min_deg": -95.5,
        "max_deg": 10.0,
        "max_velocity_deg_s": 60.0,
        "position_pid": SHOULDER_PID,
        "current_limit_ma": 7000,
        "pwm_limit": 800,
        "calibration": Calibration(type=3, p1=2388.75, p2=10, p3=3081.4875, startup_pwm=120),
        **changes,
    }
    return Joint(**values)


def compliant_joint(name: str, address: int, axis: int, channel: int, **changes: Any) -> Joint:
    """A joint that can be compliant."""
    source = TorqueSource(address=12, channel=channel, full_scale_nm=8.0)
    extra: dict[str, Any] = {
        "torque_pid": TORQUE_PID,
        "impedance": STIFF_SPRING,
        "torque_source": source,
        **changes,
    }
    return joint(name, address, axis, **extra)


DESCRIPTION = RobotDescription(
    name="scripted",
    boards=(
        Board(
            name="r_shoulder",
            bus=BUS,
            address=1,
            type="bll_ie",
            firmware=(2, 0x50),
            broadcast=(0x77,),
        ),
        Board(
            name="r_forearm",
            bus=BUS,
            address=3,
            type="dc4",
            firmware=(2, 0x19),
            broadcast=(0x75, 0x75),
        ),
        Board(name="r_strain", bus=BUS, address=13, type="strain", firmware=(3, 0), broadcast=()),
    ),
    joints=(
        compliant_joint("pitch", 1, 0, 0),
        compliant_joint("roll", 1, 1, 1, zero_deg=37.0, min_deg=0.0, max_deg=161.0),
        joint(
            "prosup",
            3,
            0,
            ticks_per_deg=-706.67,
            zero_deg=-74.0,
            min_deg=-50.0,
            max_deg=85.0,
            current_limit_ma=1000,
            calibration=Calibration(type=0, p1=900, p2=-20, p3=0, startup_pwm=1333, order=2),
        ),
        joint(
            "wrist",
            4,
            0,
            ticks_per_deg=-11.375,
            zero_deg=-180.0,
            min_deg=-20.0,
            max_deg=25.0,
            current_limit_ma=800,
        ),
    ),
    sensors=(
        ForceTorqueSensor(
            name="r_arm_ft",
            frame="r_arm_ft_sensor",
            bus=BUS,
            address=13,
            full_scale=(1521.0, 1658.0, 1966.0, 34.0, 35.0, 22.0),
        ),
    ),
)
