"""Answers to what the field is asked that need no path: gains, information, sources."""

from services.core.errors import ConfigError
from services.fields.driver import PointDriver
from services.fields.gains import as_infos, as_pairs
from services.fields.messages import (
    ACTIONS,
    MODES,
    FieldInfo,
    FieldReply,
    ModeInfo,
)
from services.fields.mode import PERIOD_S
from services.fields.modes import PROMISES
from services.fields.sources import Sources

VERSION = "1"


def check_action(action: str) -> None:
    """Refuse what is no action.

    Raises:
        ConfigError: with those there are.
    """
    if action not in ACTIONS:
        raise ConfigError(f"unknown action {action!r}; known: {', '.join(ACTIONS)}")


def gains_reply(driver: PointDriver) -> FieldReply:
    """Mode and gains in use."""
    return FieldReply(ok=True, mode=driver.mode, gains=as_pairs(driver.gains[driver.mode]))


def info_reply(
    now_ns: int, driver: PointDriver, sources: Sources, limbs: tuple[str, ...], main: str
) -> FieldReply:
    """Everything there is to know."""
    info = FieldInfo(
        version=VERSION,
        mode=driver.mode,
        modes=tuple(
            ModeInfo(name=mode, promises=PROMISES[mode], gains=as_infos(mode, driver.gains[mode]))
            for mode in MODES
        ),
        limbs=limbs,
        limb=main,
        sources=sources.info(now_ns),
        period_s=PERIOD_S,
    )
    return FieldReply(
        ok=True, mode=driver.mode, gains=as_pairs(driver.gains[driver.mode]), info=info
    )
