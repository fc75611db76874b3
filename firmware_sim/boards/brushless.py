"""The firmwares of the brushless boards (2BLL, BLL_IE, 2BLLDC): one code base, two axes each."""

from collections.abc import Iterable

from firmware_sim.boards import couplings
from firmware_sim.boards.board import BoardError
from firmware_sim.boards.hardware import AxisWiring, Coupling, Firmware, PartnerSpec
from firmware_sim.description import BoardSpec

Source = tuple[int, int] | None

# Virtual sensor and channel of both axes (can-protocol 6). x.51 chooses by the board's address.
_SOURCES: dict[int, tuple[Source, Source]] = {
    0x50: ((12, 0), (12, 1)),
    0x52: ((12, 1), (12, 2)),
    0x54: ((12, 0), None),
    0x57: ((12, 2), (12, 3)),
    0x62: (None, None),
    0x63: (None, None),
}
_LEG = 0x51
_LEG_SOURCES: dict[int, tuple[Source, Source]] = {
    5: ((12, 2), (12, 3)),
    6: ((12, 0), (12, 1)),
    7: ((12, 4), (12, 5)),
    8: ((11, 2), (11, 3)),
    9: ((11, 0), (11, 1)),
    10: ((11, 4), (11, 5)),
}
_COUPLINGS: dict[tuple[int, int], Coupling] = {
    (1, 0x50): couplings.shoulder_upper(),
    (2, 0x50): couplings.shoulder_upper(),
    (1, 0x52): couplings.WAIST,
    (2, 0x52): couplings.WAIST,
    (1, 0x57): couplings.shoulder_lower(motor_encoder=True),
    (2, 0x57): couplings.shoulder_lower(),
    (1, 0x62): couplings.NECK,
    (1, 0x63): couplings.NECK,
}
_PARTNERS = {
    0x50: PartnerSpec(address=2, needs_position=False, axes=(0, 1)),
    0x57: PartnerSpec(address=1, needs_position=True, axes=(0,)),
}
_NEEDS_ENCODERS = frozenset({0x51, 0x54})
_HEAD = frozenset({0x62, 0x63})

BODY_VERSIONS = tuple(
    (major, minor) for major in (1, 2) for minor in (0x50, 0x51, 0x52, 0x54, 0x57)
)
NECK_VERSIONS = tuple((1, minor) for minor in (0x62, 0x63))


def brushless_firmware(
    spec: BoardSpec, board: str, versions: Iterable[tuple[int, int]]
) -> Firmware:
    """The firmware that `spec` asks for, one of `versions`.

    Raises:
        BoardError: it is none of them, or a leg's at an address that is no leg's.
    """
    major, minor = spec.firmware
    sources = _LEG_SOURCES.get(spec.address) if minor == _LEG else _SOURCES.get(minor)
    if spec.firmware not in versions or sources is None:
        raise unknown_firmware(spec, board, versions)
    coupled = spec.coupled
    return Firmware(
        version=spec.firmware,
        axes=tuple(AxisWiring(torque_source=source) for source in sources),
        coupling=_COUPLINGS.get((major, minor), couplings.identity(2))
        if coupled
        else couplings.identity(2),
        partner=_PARTNERS.get(minor) if coupled else None,
        complains=minor not in _HEAD,
        position_needs_encoders=minor in _NEEDS_ENCODERS,
        faithful=spec.faithful,
    )


def unknown_firmware(
    spec: BoardSpec, board: str, versions: Iterable[tuple[int, int]]
) -> BoardError:
    """Says what was asked for and what there is."""
    known = list(versions)
    names = ", ".join(f"{major:X}.{minor:02X}" for major, minor in sorted(known))
    legs = "; x.51 at addresses 5 to 10 only" if any(minor == _LEG for _, minor in known) else ""
    major, minor = spec.firmware
    return BoardError(
        f"{board} firmware {major:X}.{minor:02X} at address {spec.address} is not emulated; "
        f"known: {names}{legs}"
    )
