"""What can go wrong in the HAL, split by what the caller can do about it.

Bad bytes and boards that fail while running never raise: they are counted, reported and, where it
matters, end in the phase "failed" with the reason.
"""


class HalError(Exception):
    """Anything the HAL raises."""


class DescriptionError(HalError, ValueError):
    """The robot description, or a name given by the caller, does not fit."""


class BusError(HalError):
    """A CAN bus cannot be opened or used: the text says what to do."""
