"""When a batch is complete: messages that are sent in one step arrive one by one, live."""

from services.core.clock import NS_PER_MS
from services.core.service import Inputs
from services.core.stream import AnyStream

LONGEST_GATHER_NS = NS_PER_MS  # what one lost message may hold up the others, once


class Gathering:
    """Follows the streams that start one service's steps.

    The fastest of them come in every batch. Waited for are those that came in the last one: a
    stream that falls silent holds up the others in one step and never again.
    """

    def __init__(self, streams: tuple[AnyStream, ...]) -> None:
        fastest = max((stream.rate_hz for stream in streams), default=0.0)
        self._streams = streams
        self._fastest = tuple(stream for stream in streams if stream.rate_hz == fastest)
        self._awaited: tuple[AnyStream, ...] = ()

    def is_complete(self, inputs: Inputs) -> bool:
        """Whether there is nothing to wait for."""
        if all(inputs.new(stream) is not None for stream in self._awaited):
            return True
        return all(inputs.new(stream) is None for stream in self._streams)  # woken by a request

    def end(self, inputs: Inputs) -> None:
        """The batch is as it is; what it holds is waited for in the next one."""
        came = tuple(stream for stream in self._fastest if inputs.new(stream) is not None)
        if came or any(inputs.new(stream) is not None for stream in self._streams):
            self._awaited = came
