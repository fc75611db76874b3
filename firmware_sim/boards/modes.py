"""Control modes as the boards group them (can-protocol 10.1 and 6)."""

from hal.wire.modes import ControlMode, InteractionMode

# Plain integers: the modes are compared each millisecond.
IDLE = int(ControlMode.IDLE)
POSITION = int(ControlMode.POSITION)
VELOCITY = int(ControlMode.VELOCITY)
TORQUE = int(ControlMode.TORQUE)
IMPEDANCE_POSITION = int(ControlMode.IMPEDANCE_POSITION)
IMPEDANCE_VELOCITY = int(ControlMode.IMPEDANCE_VELOCITY)
MIXED = int(ControlMode.MIXED)
DIRECT = int(ControlMode.DIRECT)
OPENLOOP = int(ControlMode.OPENLOOP)
CALIB_HARD_STOP = int(ControlMode.CALIB_HARD_STOP)
CALIB_INCREMENTAL = int(ControlMode.CALIB_ABSOLUTE_INCREMENTAL)
HW_FAULT = int(ControlMode.HW_FAULT)

STIFF = int(InteractionMode.STIFF)
COMPLIANT = int(InteractionMode.COMPLIANT)

RUNNING = frozenset(
    {
        POSITION,
        VELOCITY,
        TORQUE,
        IMPEDANCE_POSITION,
        IMPEDANCE_VELOCITY,
        MIXED,
        DIRECT,
        OPENLOOP,
    }
)
"""Modes that a host may ask for, apart from idle."""

COMPILED = RUNNING | {CALIB_INCREMENTAL}
"""Modes whose law runs in the kernel."""

IMPEDANCE = frozenset({IMPEDANCE_POSITION, IMPEDANCE_VELOCITY})
WITH_MOVES = frozenset({POSITION, IMPEDANCE_POSITION, MIXED})
WITH_VELOCITY = frozenset({VELOCITY, IMPEDANCE_VELOCITY, MIXED})
ALWAYS_TORQUE = frozenset({TORQUE, IMPEDANCE_POSITION, IMPEDANCE_VELOCITY})
TORQUE_WHEN_COMPLIANT = frozenset({POSITION, VELOCITY, MIXED, DIRECT})
