"""Settings that a SET command stores as they come and the matching GET command returns.

Each row names the two commands, the part of the axis that keeps the values, the values in wire
order, and the PID-received flags that the SET raises (can-protocol 2.2 and 2.3).
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from operator import attrgetter

from firmware_sim.boards.axis_state import Axis
from hal.wire import motor
from hal.wire.message import AxisCommand

Values = tuple[int, ...]
Handler = Callable[[Axis, Values], Values | None]
"""Acts on a request for an axis; returns the values of the reply, None when there is none."""

MAX_SHIFT = 31


@dataclass(frozen=True, slots=True)
class Setting:
    """One row."""

    store: AxisCommand
    read: AxisCommand
    part: str  # dotted attribute of Axis, "" for the axis itself
    names: tuple[str, ...]
    flags: int = 0


SETTINGS = (
    Setting(motor.SET_P_GAIN, motor.GET_P_GAIN, "position_pid", ("kp",), 0x01),
    Setting(motor.SET_D_GAIN, motor.GET_D_GAIN, "position_pid", ("kd",), 0x02),
    Setting(motor.SET_I_GAIN, motor.GET_I_GAIN, "position_pid", ("ki",), 0x04),
    Setting(motor.SET_SCALE, motor.GET_SCALE, "position_pid", ("shift",), 0x08),
    Setting(motor.SET_OFFSET, motor.GET_OFFSET, "position_pid", ("offset",), 0x10),
    Setting(motor.SET_ILIM_GAIN, motor.GET_ILIM_GAIN, "position_pid", ("integral_limit",), 0x20),
    Setting(motor.SET_TLIM, motor.GET_TLIM, "position_pid", ("output_limit",), 0x40),
    Setting(
        motor.SET_POS_PID, motor.GET_POS_PID, "position_pid", ("kp", "ki", "kd", "shift"), 0x4F
    ),
    Setting(
        motor.SET_POS_PIDLIMITS,
        motor.GET_POS_PIDLIMITS,
        "position_pid",
        ("offset", "output_limit", "integral_limit"),
        0x30,
    ),
    Setting(
        motor.SET_POS_STICTION_PARAMS,
        motor.GET_POS_STICTION_PARAMS,
        "",
        ("stiction_up", "stiction_down"),
    ),
    Setting(
        motor.SET_TORQUE_PID, motor.GET_TORQUE_PID, "torque_loop.pid", ("kp", "ki", "kd", "shift")
    ),
    Setting(
        motor.SET_TORQUE_PIDLIMITS,
        motor.GET_TORQUE_PIDLIMITS,
        "torque_loop.pid",
        ("offset", "output_limit", "integral_limit"),
    ),
    Setting(
        motor.SET_TORQUE_STICTION_PARAMS,
        motor.GET_TORQUE_STICTION_PARAMS,
        "torque_loop",
        ("stiction_up", "stiction_down"),
    ),
    Setting(
        motor.SET_MOTOR_PARAMS,
        motor.GET_MOTOR_PARAMS,
        "torque_loop",
        ("bemf", "bemf_shift", "ktau", "ktau_shift"),
    ),
    Setting(motor.SET_MODEL_PARAMS, motor.GET_MODEL_PARAMS, "torque_loop", ("kff", "kff_shift")),
    Setting(motor.SET_TCFILTER_TYPE, motor.GET_TCFILTER_TYPE, "torque_loop", ("filter",)),
    Setting(motor.SET_IMPEDANCE_OFFSET, motor.GET_IMPEDANCE_OFFSET, "impedance", ("offset",)),
    Setting(motor.SET_MIN_POSITION, motor.GET_MIN_POSITION, "reference", ("low",)),
    Setting(motor.SET_MAX_POSITION, motor.GET_MAX_POSITION, "reference", ("high",)),
    Setting(motor.SET_MAX_VELOCITY, motor.GET_MAX_VELOCITY, "", ("max_velocity",)),
    Setting(motor.SET_PWM_LIMIT, motor.GET_PWM_LIMIT, "", ("pwm_limit",)),
    Setting(motor.SET_DESIRED_TORQUE, motor.GET_DESIRED_TORQUE, "", ("desired_torque",)),
    Setting(motor.SET_DESIRED_VELOCITY, motor.GET_DESIRED_VELOCITY, "", ("velocity_setting",)),
    Setting(motor.SET_DESIRED_ACCELER, motor.GET_DESIRED_ACCELER, "", ("acceleration_setting",)),
)


def handlers() -> Iterator[tuple[int, Handler]]:
    """Code and handler of both commands of every row."""
    for setting in SETTINGS:
        yield setting.store.code, _storing(setting)
        yield setting.read.code, _reading(setting)


def _storing(setting: Setting) -> Handler:
    part_of = _part_of(setting)

    def store(axis: Axis, values: Values) -> None:
        part = part_of(axis)
        for name, value in zip(setting.names, values, strict=True):
            # DELIBERATE: a shift outside 0..31 has no meaning on the boards either; it is stored as
            # the nearest one that has.
            held = min(max(value, 0), MAX_SHIFT) if name == "shift" else value
            setattr(part, name, held)
        axis.pid_flags |= setting.flags
        if "kp" in setting.names:
            axis.node.unit.gain_changed(axis)
        if setting.store is motor.SET_I_GAIN:
            axis.position_pid.integral = 0

    return store


def _reading(setting: Setting) -> Handler:
    part_of = _part_of(setting)

    def read(axis: Axis, _values: Values) -> Values:
        part = part_of(axis)
        return tuple(getattr(part, name) for name in setting.names)

    return read


def _part_of(setting: Setting) -> Callable[[Axis], object]:
    return attrgetter(setting.part) if setting.part else lambda axis: axis
