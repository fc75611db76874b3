"""Opens the Zenoh sessions: the hub, which routes, and its clients."""

import json
import logging
from types import TracebackType

import zenoh

from hal.buses.zenoh import base_settings, close_session, open_client, open_session
from hal.errors import BusError
from services.core.errors import HubUnreachableError, ServiceError

logger = logging.getLogger(__name__)

ADMIN_TIMEOUT_S = 2.0
ANY_FREE_PORT = "tcp/127.0.0.1:0"  # loopback only, unless somebody says otherwise


class Hub:
    """The router that all other processes are clients of."""

    def __init__(self, session: zenoh.Session, endpoint: str) -> None:
        self._session = session
        self.endpoint = endpoint

    def __enter__(self) -> "Hub":
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        traceback: TracebackType | None,
    ) -> None:
        self.close()

    def announce(self, key: str) -> None:
        """Hold a liveliness token for as long as the hub routes."""
        self._token = self._session.liveliness().declare_token(key)

    def close(self) -> None:
        """Stop routing."""
        close_session(self._session)


def open_hub(listen: str = ANY_FREE_PORT) -> Hub:
    """Open a router that listens at an endpoint; port 0 takes a free one, which `endpoint` tells.

    Raises:
        ServiceError: nothing can listen there.
    """
    settings = base_settings("router") | {"listen/endpoints": [listen], "adminspace/enabled": True}
    try:
        session = open_session(settings)
    except zenoh.ZError as error:
        raise ServiceError(f"cannot listen at {listen}: {error}") from error
    return Hub(session, _actual_endpoint(session, listen))


def connect(endpoint: str, timeout_s: float = 5.0) -> zenoh.Session:
    """Open a client session; close it with `close_session`.

    Raises:
        HubUnreachableError: no hub there.
    """
    try:
        return open_client(endpoint, timeout_s)
    except BusError as error:
        raise HubUnreachableError(str(error)) from error


def disconnect(session: zenoh.Session) -> None:
    """Close a client session."""
    close_session(session)


def _actual_endpoint(session: zenoh.Session, listen: str) -> str:
    """Where the router really listens: only its administration space knows a port that was 0."""
    if not listen.endswith(":0"):
        return listen
    for reply in session.get(f"@/{session.zid()}/router", timeout=ADMIN_TIMEOUT_S):
        if reply.ok is not None:
            locators = json.loads(reply.ok.payload.to_bytes())["locators"]
            return str(locators[0])
    raise ServiceError(f"the hub does not tell the port that it chose for {listen}")
