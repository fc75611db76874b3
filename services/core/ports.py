"""How an arrival from Zenoh becomes an input: a port per stream read, call served, call made."""

import logging
from typing import Any, Protocol

import msgspec
import zenoh

from services.core.clock import NS_PER_S
from services.core.log import OncePerSecond
from services.core.service import CallFailed, Inputs
from services.core.stream import AnyCall, AnyStream

logger = logging.getLogger(__name__)


def encoding_of(message: type[msgspec.Struct]) -> str:
    """What the bus says a payload is."""
    return f"application/msgpack;schema={message.__name__}"


class Refusals:
    """Counts what is not taken in, and logs each cause at most once a second."""

    def __init__(self) -> None:
        self.count = 0
        self._throttle = OncePerSecond()

    def note(self, name: str, reason: str, now_ns: int) -> None:
        """One arrival was refused."""
        self.count += 1
        if self._throttle.allows(name, now_ns):
            logger.warning("%s refused: %s", name, reason)


class Reader:
    """Decodes payloads of one type, and only those that say they are of it."""

    def __init__(self, message: type[msgspec.Struct]) -> None:
        self._encoding = zenoh.Encoding(encoding_of(message))
        self._decoder = msgspec.msgpack.Decoder(message)

    def read(self, payload: zenoh.ZBytes | None, encoding: zenoh.Encoding | None) -> msgspec.Struct:
        """The message; msgspec.DecodeError with the reason where there is none."""
        if payload is None or encoding != self._encoding:
            raise msgspec.DecodeError(f"expected {self._encoding}, not {encoding}")
        return self._decoder.decode(payload.to_bytes())


class Port(Protocol):
    """Takes what Zenoh's thread has put into the inbox; true where that starts a step."""

    def take(self, inputs: Inputs, item: Any, stamp_ns: int) -> bool:
        """Runs in the thread that steps the service."""


class StreamPort:
    """A stream that the service reads."""

    def __init__(self, stream: AnyStream, refusals: Refusals, wakes: bool) -> None:
        self._stream = stream
        self._reader = Reader(stream.message)
        self._refusals = refusals
        self.wakes = wakes

    def take(self, inputs: Inputs, item: zenoh.Sample, stamp_ns: int) -> bool:
        """A sample."""
        try:
            message = self._reader.read(item.payload, item.encoding)
        except msgspec.DecodeError as error:
            self._refusals.note(self._stream.name, str(error), stamp_ns)
            return False
        inputs.deliver(self._stream, message, stamp_ns)
        return self.wakes


class ServePort:
    """A call that the service answers."""

    def __init__(self, call: AnyCall, refusals: Refusals) -> None:
        self._call = call
        self._reader = Reader(call.request)
        self._refusals = refusals
        self._waiting: dict[int, tuple[zenoh.Query, int]] = {}  # token -> (query, answer by)
        self._token = 0

    def take(self, inputs: Inputs, item: zenoh.Query, stamp_ns: int) -> bool:
        """A query."""
        try:
            request = self._reader.read(item.payload, item.encoding)
        except msgspec.DecodeError as error:
            self._refusals.note(self._call.name, str(error), stamp_ns)
            with item:
                item.reply_err(str(error))
            return False
        self._token += 1
        answer_by_ns = stamp_ns + round(self._call.timeout_s * NS_PER_S)
        self._waiting[self._token] = (item, answer_by_ns)
        inputs.deliver_request(self._call, self._token, request)
        return True

    def answer(self, key: str, token: int, payload: bytes) -> None:
        """Send a reply; nobody is told when the asker has given up by now."""
        waiting = self._waiting.pop(token, None)
        if waiting is not None:
            with waiting[0] as query:
                query.reply(key, payload, encoding=encoding_of(self._call.reply))

    def forget(self, now_ns: int) -> None:
        """Let go of the queries whose time is up: their askers have been told so already."""
        late = [token for token, (_, by_ns) in self._waiting.items() if by_ns < now_ns]
        for token in late:
            with self._waiting.pop(token)[0]:
                self._refusals.note(self._call.name, "not answered in time", now_ns)


class CallPort:
    """A call that the service makes."""

    def __init__(self, call: AnyCall) -> None:
        self._call = call
        self._reader = Reader(call.reply)
        self._unanswered: set[int] = set()

    def expect(self, token: int) -> None:
        """A request has gone out."""
        self._unanswered.add(token)

    def take(self, inputs: Inputs, item: tuple[int, zenoh.Reply | None], stamp_ns: int) -> bool:  # noqa: ARG002
        """A reply, or None behind the last one."""
        token, reply = item
        if token not in self._unanswered:
            return False
        self._unanswered.remove(token)
        inputs.deliver_reply(self._call, token, self._outcome(reply))
        return True

    def _outcome(self, reply: zenoh.Reply | None) -> msgspec.Struct | CallFailed:
        name = self._call.name
        if reply is None:
            return CallFailed(f"nobody answers {name}")
        if reply.err is not None:
            return CallFailed(f"{name}: {reply.err.payload.to_bytes().decode(errors='replace')}")
        if reply.ok is None:
            return CallFailed(f"{name}: neither an answer nor an error")
        try:
            return self._reader.read(reply.ok.payload, reply.ok.encoding)
        except msgspec.DecodeError as error:
            return CallFailed(f"{name}: {error}")
