"""What can go wrong in the numerics, by what the caller can do about it."""


class DforcError(Exception):
    """Base of every error that dforc raises."""


class NotFiniteError(DforcError, ValueError):
    """An input holds NaN or infinity: nothing was computed, no state was changed."""


class ShapeError(DforcError, ValueError):
    """An input does not have the shape that the model asks for."""


class LimitsError(DforcError, ValueError):
    """Limits that no posture can keep, or that do not belong to the chain."""
