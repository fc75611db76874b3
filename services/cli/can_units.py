"""Physical values of the raw numbers in motor and sensor frames (can-protocol 9.1 and 9.2)."""

from typing import NamedTuple

from hal.wire import analog, inertial, motor
from hal.wire.catalogue import Form
from hal.wire.layout import Field
from services.robotfile.robot_tables import RobotFile

HALF_RANGE = 0x8000  # torque units per TorqueMax

# In ticks, but of no joint angle: encoder offsets, limits of a motor, differences.
_NO_ANGLE = {
    motor.SET_MAX_MOTOR_POS.name,
    motor.SET_MIN_MOTOR_POS.name,
    motor.SET_OFFSET_ABS_ENCODER.name,
    motor.GET_OFFSET_ABS_ENCODER.name,
}


class AxisScale(NamedTuple):
    """Factors of one axis. Shifts of the 4DC are 0: it sends speeds that are not shifted."""

    ticks_per_deg: float
    zero_deg: float
    velocity_shift: int
    speed_shift: int
    torque_max_nm: float | None

    @classmethod
    def of(cls, robot: RobotFile, joint: str) -> "AxisScale":
        """The factors of a joint of a robot file."""
        table = robot.joints[joint]
        board = robot.boards[table.board]
        torque_max_nm = None
        for virtual in robot.virtual_sensors.values():
            if virtual.bus == board.bus and joint in virtual.channels:
                torque_max_nm = virtual.full_scale_nm
        return cls(
            table.ticks_per_deg,
            table.zero_deg,
            robot.host.velocity_shift,
            0 if board.type == "dc4" else robot.host.speed_estimate_shift,
            torque_max_nm,
        )

    def deg(self, ticks: float) -> float:
        """Joint angle of an encoder reading."""
        return ticks / self.ticks_per_deg - self.zero_deg


def physical_text(form: Form, field: Field, value: int, scale: AxisScale | None) -> str:
    """The physical value of a field, empty where nothing tells it."""
    if field.unit == "mA":
        return f"{value / 1000:.4g} A"
    if field.unit == "8.75 mdeg/s":
        return f"{value / inertial.MTB_COUNTS_PER_DEG_S:.4g} deg/s"
    if field.unit == "g/16000":
        return f"{value / inertial.MTB_COUNTS_PER_G:.4g} g"
    if field.unit == "1/16384":
        return f"{value / inertial.IMU_COUNTS_PER_UNIT:.4g}"
    if form.row is analog.THERMOMETER and field.unit == "0.1 degC":
        return f"{value / 10:.1f} degC"
    if scale is None:
        return ""
    if field.unit == "tick":
        return _angle_text(form, field, value, scale)
    return _rate_text(field.unit, value, scale) or _torque_text(field.unit, value, scale)


def _angle_text(form: Form, field: Field, value: int, scale: AxisScale) -> str:
    if form.name in _NO_ANGLE:
        return ""
    if "error" in field.name:
        return f"{value / scale.ticks_per_deg:.2f} deg"
    return f"{scale.deg(value):.2f} deg"


def _rate_text(unit: str, value: int, scale: AxisScale) -> str:
    if unit == "10 tick/s":
        return f"{10 * value / abs(scale.ticks_per_deg):.4g} deg/s"
    if unit == "tick/ms / 2^shift":
        return f"{1000 * value / 2**scale.speed_shift / scale.ticks_per_deg + 0.0:.4g} deg/s"
    if unit == "tick/ms / 2^velocity_shift":
        return f"{1000 * value / 2**scale.velocity_shift / scale.ticks_per_deg + 0.0:.4g} deg/s"
    if unit == "tick/ms^2 / 2^velocity_shift":
        return f"{1e6 * value / 2**scale.velocity_shift / scale.ticks_per_deg:.4g} deg/s^2"
    return ""


def _torque_text(unit: str, value: int, scale: AxisScale) -> str:
    if scale.torque_max_nm is None or not unit.startswith("TorqueMax/0x8000"):
        return ""
    torque = value * scale.torque_max_nm / HALF_RANGE
    if unit.endswith("*ms/tick"):  # the board counts damping in thousandths of a second
        return f"{torque * scale.ticks_per_deg / 1000:.4g} Nm s/deg"
    if unit.endswith("/tick"):
        return f"{torque * scale.ticks_per_deg:.4g} Nm/deg"
    return f"{torque:.4g} Nm"
