"""What can go wrong in the services, by what the caller can do about it."""


class ServiceError(Exception):
    """Base of every error that the services package raises."""


class UndeclaredUseError(ServiceError):
    """A service touched a stream or request that it does not declare: a programming error."""


class HubUnreachableError(ServiceError):
    """No hub answers at the endpoint: start the stack or correct the endpoint."""


class AlreadyRunningError(ServiceError):
    """A stack of that name is up: use it, stop it, or choose another name."""

    def __init__(self, name: str, pid: int) -> None:
        super().__init__(f"a stack named {name!r} is already running (pid {pid})")
        self.name = name
        self.pid = pid


class NotRunningError(ServiceError):
    """No stack of that name is up."""


class ProcessDiedError(ServiceError):
    """A process of the stack ended by itself; the stack must come down."""

    def __init__(self, process: str, status: str, log_tail: str = "") -> None:
        super().__init__(f"process {process!r} ended with {status}")
        self.process = process
        self.status = status
        self.log_tail = log_tail


class NotReadyError(ServiceError):
    """A process did not report for work in time."""


class CallFailedError(ServiceError):
    """A request got no answer; the text says why."""


class ConfigError(ServiceError):
    """A robot file or an argument is wrong: the text names file, key and what is allowed."""
