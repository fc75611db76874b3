"""What the host writes into a motor board, in the order of the iCub's PC (can-protocol 2.4).

DELIBERATE: the broadcast masks come last instead of in the middle, so that a board talks once it is
configured.
"""

from collections.abc import Iterator

from hal.axis import Axis
from hal.description import Board, RobotDescription
from hal.wire import motor
from hal.wire.can import Frame
from hal.wire.message import AxisCommand

Setting = tuple[AxisCommand, tuple[int, ...]]


def axis_settings(axis: Axis, description: RobotDescription) -> Iterator[Setting]:
    """Every setting of one axis. None of them moves it or changes its mode."""
    joint = axis.joint
    yield from position_settings(axis)
    yield from torque_settings(axis)
    if joint.torque_source is not None:
        yield motor.SET_TORQUE_SOURCE, (joint.torque_source.address, joint.torque_source.channel)
    if axis.can_be_compliant:
        yield impedance_setting(axis)
    yield motor.SET_MIN_POSITION, (axis.units.board_low_ticks,)
    yield motor.SET_MAX_POSITION, (axis.units.board_high_ticks,)
    yield velocity_limit_setting(axis)
    yield current_limit_setting(axis)
    yield motor.SET_VEL_SHIFT, (description.velocity_shift,)
    yield motor.SET_VEL_TIMEOUT, (description.velocity_timeout_ms,)
    yield motor.SET_PWM_LIMIT, (joint.pwm_limit,)
    yield motor.SET_SPEED_ESTIM_SHIFT, (description.speed_estimate_shift,) * 4


def position_settings(axis: Axis) -> Iterator[Setting]:
    """All seven gains, or the axis cannot be enabled (can-protocol 2.3)."""
    pid = axis.joint.position_pid
    yield motor.SET_P_GAIN, (pid.kp,)
    yield motor.SET_D_GAIN, (pid.kd,)
    yield motor.SET_I_GAIN, (pid.ki,)
    yield motor.SET_ILIM_GAIN, (pid.integral_limit,)
    yield motor.SET_OFFSET, (pid.offset,)
    yield motor.SET_SCALE, (pid.shift,)
    yield motor.SET_TLIM, (pid.output_limit,)
    yield motor.SET_POS_STICTION_PARAMS, (pid.stiction_up, pid.stiction_down)


def torque_settings(axis: Axis) -> Iterator[Setting]:
    """The torque loop, where the robot file has one."""
    pid = axis.joint.torque_pid
    if pid is None:
        return
    yield motor.SET_TORQUE_PID, (pid.kp, pid.ki, pid.kd, pid.shift)
    yield motor.SET_TORQUE_PIDLIMITS, (pid.offset, pid.output_limit, pid.integral_limit)
    yield motor.SET_MOTOR_PARAMS, (pid.bemf, pid.bemf_shift, pid.ktau, pid.ktau_shift)
    yield motor.SET_MODEL_PARAMS, (pid.kff, pid.shift)  # the loop uses its own shift: the same one
    yield motor.SET_TORQUE_STICTION_PARAMS, (pid.stiction_up, pid.stiction_down)
    yield motor.SET_TCFILTER_TYPE, (pid.filter,)


def impedance_setting(axis: Axis) -> Setting:
    """Stiffness and damping of an axis that can be compliant."""
    impedance = axis.joint.impedance
    assert impedance is not None  # can_be_compliant
    return motor.SET_IMPEDANCE_PARAMS, (
        axis.units.stiffness_counts(impedance.stiffness_nm_deg),
        axis.units.damping_counts(impedance.damping_nms_deg),
    )


def current_limit_setting(axis: Axis) -> Setting:
    """Current at which the board's I2T watch begins."""
    return motor.SET_CURRENT_LIMIT, (axis.joint.current_limit_ma,)


def velocity_limit_setting(axis: Axis) -> Setting:
    """The firmware stores it and does nothing with it; the host keeps to it all the same."""
    return motor.SET_MAX_VELOCITY, (abs(axis.units.velocity_counts(axis.units.max_velocity_rad_s)),)


def address_settings(board: Board, address: int) -> Iterator[Frame]:
    """Settings that belong to an address and not to an axis: protocol and broadcast mask.

    The protocol again, because a handshake with another version would keep the bridges off.
    """
    mask = board.broadcast[address - board.address]
    axis = 0  # both axes of an address share these; the board takes the commands for either
    yield motor.GET_FIRMWARE_VERSION.request(address, axis, *motor.HOST_PROTOCOL)
    yield motor.SET_BCAST_POLICY.request(address, axis, mask)
