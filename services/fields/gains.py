"""Constants of every mode: the papers' letters and units, defaults, the papers' values, bounds.

What the papers have no value for keeps its default among theirs.
Beyond the bounds the point would run away at 10 ms, or never move.
"""

import math
from collections.abc import Iterable, Mapping
from types import MappingProxyType

import msgspec

from services.core.errors import ConfigError
from services.fields.messages import MODES, GainInfo, NamedFloats

SHORTEST_T_S = 0.1  # of the Cartesian controller
DEFAULT, PAPER = "default", "paper"
PRESETS = (DEFAULT, PAPER)


def _gain(
    name: str,
    unit: str,
    meaning: str,
    default: float,
    paper: float,
    between: tuple[float, float],
) -> GainInfo:
    lowest, highest = between
    return GainInfo(
        name=name,
        value=float(default),
        unit=unit,
        meaning=meaning,
        default=float(default),
        paper=float(paper),
        lowest=float(lowest),
        highest=float(highest),
    )


SWITCH = (0.0, 1.0)  # values of a gain that is off or on
SWITCHES = ("truncated", "targets", "variant", "limits", "gamma")
NONE = math.nan  # the papers have no such constant
T_MEANS = "trajectory time of the controller; 0 = the robot file's"
TIME = _gain("T", "s", T_MEANS, 0, 0.6, (0, 10))

TABLES: Mapping[str, tuple[GainInfo, ...]] = MappingProxyType(
    {
        # DELIBERATE: the papers' K = 4 N/m, D = 8 Ns/m take 7.8 s to come within 5 mm of a target
        # 0.3 m away, and lag by 2 s behind a moving one. K = 9, D = 6 is critically damped: 2 s
        # and 0.7 s. With G = 25 N the boundary (G/e = 9.2 N) holds against goals within 1 m.
        "dforc": (
            _gain("K", "N/m", "stiffness of the goal (eq. 3)", 9, 4, (0, 400)),
            _gain("D", "Ns/m", "damping (eq. 3)", 6, 8, (0.1, 100)),
            _gain("G", "N", "gain of obstacles (eq. 4)", 25, 10, (0, 1000)),
            TIME,
            _gain("margin", "m", "added to every semi-axis", 0.02, 0, (0, 0.2)),
            _gain("truncated", "", "1: eq. 5; 0: eq. 4 with its tails", 1, 1, SWITCH),
            _gain("targets", "", "1: every object that is a target attracts", 0, 0, SWITCH),
        ),
        "pmp": (
            _gain("K", "N/m", "stiffness of the goal, Nm/rad for its turn", 4, 4, (0, 40)),
            _gain("alpha", "Nm", "gain of the limit fields (eq. 8)", 0.05, 0.05, (0, 1)),
            _gain("A", "rad/Nms", "admittance of the joints", 1, 1, (1e-3, 5)),
            _gain("tau", "s", "time base (eq. 10)", 3, 3, (0.1, 60)),
            _gain("epsilon", "", "of the time base (eq. 10)", 1e-3, 1e-3, (1e-6, 1)),
            _gain("G", "N", "gain of obstacles (eq. 4)", 10, 8, (0, 1000)),
            TIME,
            _gain("margin", "m", "added to every semi-axis", 0.02, 0, (0, 0.2)),
            _gain("variant", "", "0: A, integrates the hand; 1: B, by kinematics", 1, 1, SWITCH),
            _gain("limits", "", "1: limit fields", 1, 1, SWITCH),
            _gain("gamma", "", "1: time base; 0: goes on until it is there", 0, 1, SWITCH),
        ),
        "ulna": (
            _gain("K", "N/m", "stiffness of the goal", 16, 4, (0.1, 100)),
            _gain("D", "Ns/m", "damping; K/D is the speed per metre", 8, 8, (0.1, 100)),
            # The arm trails the virtual one by 0.56 T, and so it gives way later.
            _gain("T", "s", T_MEANS, 0.2, 0.6, (0, 10)),
            _gain("speed", "m/s", "fastest of the hand", 0.3, NONE, (0.01, 1)),
            _gain("turn", "rad/s", "fastest turn of the hand", 1.5, NONE, (0.05, 6)),
            _gain("margin", "m", "kept from obstacles where it can be", 0.02, NONE, (0, 0.2)),
            _gain("least_margin", "m", "kept in any case", 0.004, NONE, (0, 0.1)),
            _gain("self_margin", "m", "kept between links", 0.005, NONE, (0, 0.05)),
        ),
    }
)


def initial_gains(mode: str) -> dict[str, float]:
    """Gains of a mode before anybody has changed them."""
    return {gain.name: gain.default for gain in TABLES[mode]}


def changed_gains(
    mode: str, before: Mapping[str, float], changes: Iterable[tuple[str, float]], preset: str = ""
) -> dict[str, float]:
    """All gains of a mode after a change.

    Raises:
        ConfigError: an unknown name, or a value out of bounds; nothing has changed then.
    """
    table = {gain.name: gain for gain in table_of(mode)}
    if preset not in ("", *PRESETS):
        raise ConfigError(f"unknown preset {preset!r}; known: {', '.join(PRESETS)}")
    gains = dict(before)
    if preset:
        gains = {name: _preset(gain, preset) for name, gain in table.items()}
    for name, value in changes:
        if name not in table:
            raise ConfigError(f"mode {mode} has no gain {name!r}; it has {', '.join(table)}")
        gains[name] = _checked(mode, table[name], value)
    return gains


def table_of(mode: str) -> tuple[GainInfo, ...]:
    """Gains of a mode, with their defaults as values.

    Raises:
        ConfigError: there is no such mode.
    """
    if mode not in TABLES:
        raise ConfigError(f"unknown mode {mode!r}; known: {', '.join(MODES)}")
    return TABLES[mode]


def as_infos(mode: str, gains: Mapping[str, float]) -> tuple[GainInfo, ...]:
    """The table with the values in use."""
    return tuple(msgspec.structs.replace(gain, value=gains[gain.name]) for gain in TABLES[mode])


def as_pairs(gains: Mapping[str, float]) -> NamedFloats:
    """As messages carry them."""
    return tuple(gains.items())


def _preset(gain: GainInfo, preset: str) -> float:
    return gain.default if preset == DEFAULT or math.isnan(gain.paper) else gain.paper


def _checked(mode: str, gain: GainInfo, value: float) -> float:
    unit = f" {gain.unit}" if gain.unit else ""
    if not gain.lowest <= value <= gain.highest:  # nor is NaN
        span = f"{gain.lowest:g} to {gain.highest:g}{unit}"
        raise ConfigError(f"{gain.name} of mode {mode} is {span}, not {value:g}")
    if gain.name == TIME.name and 0.0 < value < SHORTEST_T_S:
        raise ConfigError(f"T is 0 or at least {SHORTEST_T_S:g} s, not {value:g}")
    if gain.name in SWITCHES and value not in SWITCH:
        raise ConfigError(f"{gain.name} of mode {mode} is 0 or 1, not {value:g}")
    return abs(float(value))  # of -0.0 it makes 0.0
