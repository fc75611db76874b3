"""What each type of board sends and is asked, for the DBC file."""

from typing import NamedTuple

from hal.wire import analog, battery, inertial, mais, motor_periodic, skin
from hal.wire.can import (
    CLASS_ANALOG_PERIODIC,
    CLASS_ANALOG_POLLING,
    CLASS_BATTERY_PERIODIC,
    CLASS_INERTIAL_PERIODIC,
    CLASS_MANAGEMENT,
    CLASS_MOTOR_PERIODIC,
    CLASS_MOTOR_POLLING,
    CLASS_SKIN_PERIODIC,
)

_FOC_TYPES = {motor_periodic.FOC.type, motor_periodic.EMSTO2FOC_DESIRED_CURRENT.type}
_MOTOR_TYPES = set(motor_periodic.MESSAGES) - _FOC_TYPES
_STRAIN_TYPES = {m.type for m in analog.MESSAGES.values() if isinstance(m, analog.TripleMessage)}
_IMU_TYPES = {
    message.type for message in (inertial.IMU_TRIPLE, inertial.IMU_QUATERNION, inertial.IMU_STATUS)
}
_TRIANGLES = set(range(skin.TRIANGLES))


class Sends(NamedTuple):
    """What one type of board speaks: its polled class and its broadcasts, types by class."""

    polled: int | None
    broadcasts: dict[int, set[int]]
    family: str = ""
    is_managed: bool = True


_MOTOR = Sends(CLASS_MOTOR_POLLING, {CLASS_MOTOR_PERIODIC: _MOTOR_TYPES})
_OVERFLOW = {CLASS_MOTOR_PERIODIC: {analog.RECEIVE_OVERFLOW.type}}
_STRAIN = {CLASS_ANALOG_PERIODIC: _STRAIN_TYPES, **_OVERFLOW}
_IMU = {CLASS_INERTIAL_PERIODIC: _IMU_TYPES}
_MTB = {
    CLASS_INERTIAL_PERIODIC: set(inertial.MESSAGES) - _IMU_TYPES,
    CLASS_MANAGEMENT: {skin.RECEIVE_OVERFLOW.type},
}

BOARDS: dict[str, Sends] = {
    **dict.fromkeys(("bll", "bll_ie", "bll_dc", "dc4"), _MOTOR),
    "dc4 second": _MOTOR._replace(is_managed=False),  # the address of axes 2 and 3
    "foc": Sends(CLASS_MOTOR_POLLING, {CLASS_MOTOR_PERIODIC: {*_MOTOR_TYPES, 0}}, "foc"),
    "strain": Sends(CLASS_ANALOG_POLLING, _STRAIN, "strain"),
    "strain2": Sends(
        CLASS_ANALOG_POLLING,
        {CLASS_ANALOG_PERIODIC: set(analog.MESSAGES), **_IMU},
    ),
    "mais": Sends(
        CLASS_ANALOG_POLLING, {CLASS_ANALOG_PERIODIC: set(mais.MESSAGES), **_OVERFLOW}, "mais"
    ),
    "mais of 16 bits": Sends(
        CLASS_ANALOG_POLLING, {CLASS_ANALOG_PERIODIC: set(mais.WORD_MESSAGES)}, "mais of 16 bits"
    ),
    "mtb": Sends(CLASS_ANALOG_POLLING, {CLASS_SKIN_PERIODIC: _TRIANGLES, **_MTB}, "skin"),
    "mtb of old style": Sends(
        CLASS_ANALOG_POLLING, {CLASS_ANALOG_PERIODIC: _TRIANGLES, **_MTB}, "skin"
    ),
    "imu": Sends(CLASS_ANALOG_POLLING, _IMU),
    "battery": Sends(None, {CLASS_BATTERY_PERIODIC: set(battery.MESSAGES)}),
    "virtual": Sends(  # the host that poses as a torque sensor
        None, {CLASS_ANALOG_PERIODIC: {analog.FORCE.type, analog.TORQUE.type}}, is_managed=False
    ),
}
"""What is written for each type of board; the names are those of a robot file."""
