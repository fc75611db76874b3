"""Why the Cartesian controller refuses a request."""

from services.core.errors import ServiceError

CALIBRATE = "`ulna joints calibrate` calibrates joints and switches them on"
SWITCH_OVER = "`ulna joints direct` has them take set-points"


class RefusedError(ServiceError):
    """A request that is not carried out; the text says why, and what would help."""
