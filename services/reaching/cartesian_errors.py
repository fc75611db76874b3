"""Why the Cartesian controller refuses a request."""

from services.core.errors import ServiceError


class RefusedError(ServiceError):
    """A request that is not carried out; the text says why, and what would help."""
