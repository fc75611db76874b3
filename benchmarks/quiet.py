"""Keeps the HAL's fault reports, thousands in these runs, off the screen."""

import logging
from collections.abc import Iterator
from contextlib import contextmanager


@contextmanager
def quiet() -> Iterator[None]:
    """Only errors of the HAL are logged inside."""
    logger = logging.getLogger("hal")
    level = logger.level
    logger.setLevel(logging.ERROR)
    try:
        yield
    finally:
        logger.setLevel(level)
