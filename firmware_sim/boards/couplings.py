"""The couplings of can-protocol 9.4, by the firmware that contains them.

Column j of a motor row is what axis j wants, column j of an encoder row what encoder j shows. The
matrices of eyes, waist and neck are theirs in motor space; nobody corrects for backlash.
"""

from dataclasses import replace

from firmware_sim.boards.hardware import Coupling, Row

SHOULDER_RATIO = 1.6455
SHOULDER_ENCODER_RATIO = 40 / 65
_NOTHING = (0.0, 0.0)


def identity(axes: int) -> Coupling:
    """Each motor turns its own joint, each encoder sees its own joint."""
    rows = _unit_rows(axes)
    return Coupling(rows, rows, (_NOTHING,) * axes, (_NOTHING,) * axes, ())


def _unit_rows(axes: int) -> tuple[Row, ...]:
    return tuple(tuple(float(row == column) for column in range(axes)) for row in range(axes))


def _coupled(
    axes: int,
    *,
    motors: dict[int, Row] | None = None,
    encoders: dict[int, Row] | None = None,
    groups: tuple[tuple[int, ...], ...] = (),
) -> Coupling:
    """The identity with some rows replaced."""
    plain = _unit_rows(axes)
    return replace(
        identity(axes),
        motors=tuple((motors or {}).get(axis, row) for axis, row in enumerate(plain)),
        encoders=tuple((encoders or {}).get(axis, row) for axis, row in enumerate(plain)),
        groups=groups,
    )


def shoulder_upper(a10: float = -SHOULDER_RATIO, a11: float = SHOULDER_RATIO) -> Coupling:
    """x.50, board 1: the second motor follows both joints."""
    return _coupled(2, motors={1: (a10, a11)})


def shoulder_lower(
    a20: float = -SHOULDER_RATIO,
    a21: float = SHOULDER_RATIO,
    a22: float = SHOULDER_RATIO,
    *,
    motor_encoder: bool = False,
) -> Coupling:
    """x.57, board 2: axis 0 is the third motor of the shoulder, axis 1 the elbow.

    `motor_encoder`: 1.57 reads an encoder on the motor, 2.57 one on the joint.
    """
    coupling = replace(_coupled(2, motors={0: (a22, 0.0)}), partner_motors=((a20, a21), _NOTHING))
    if not motor_encoder:
        return coupling
    return replace(
        coupling,
        encoders=((SHOULDER_ENCODER_RATIO, 0.0), (0.0, 1.0)),
        partner_positions=((1.0, -1.0), _NOTHING),
    )


WAIST = _coupled(2, motors={0: (0.5, -0.5), 1: (0.5, 0.5)}, groups=((0, 1),))
"""x.52: roll and pitch of the torso."""

NECK = _coupled(2, motors={0: (-0.5, 0.5), 1: (0.5, 0.5)}, groups=((0, 1),))
"""x.62 and x.63: pitch and roll of the neck."""

EYES_V1 = _coupled(
    4,
    motors={0: (0.5, 0.5, 0.0, 0.0), 1: (0.5, -0.5, 0.0, 0.0)},
    encoders={0: (1.0, 1.0, 0.0, 0.0), 1: (1.0, -1.0, 0.0, 0.0)},
    groups=((2, 3),),
)
"""1.15: version and vergence on axes 0 and 1, yet axes 2 and 3 are the ones enabled together."""

EYES_V2 = _coupled(
    4,
    motors={2: (0.0, 0.0, 0.5, 0.5), 3: (0.0, 0.0, 0.5, -0.5)},
    encoders={2: (0.0, 0.0, 1.0, 1.0), 3: (0.0, 0.0, 1.0, -1.0)},
    groups=((2, 3),),
)
"""2.15: version and vergence on axes 2 and 3."""

WRIST_V2 = _coupled(4, motors={2: (0.0, -1.0, 1.0, 0.0)}, groups=((1, 2),))
"""2.19: pitch and yaw, encoders on the joints."""

WRIST_V1 = replace(WRIST_V2, encoders=_coupled(4, encoders={2: (0.0, 1.0, 1.0, 0.0)}).encoders)
"""1.19: encoders on the motors."""

THUMB_LEFT = _coupled(4, motors={1: (-1.0, 1.0, 0.0, 0.0)})
THUMB_RIGHT = _coupled(4, motors={1: (1.0, 1.0, 0.0, 0.0)})
"""2.28: the opposition pulls the proximal joint along; the sign of its kp tells the hand."""
