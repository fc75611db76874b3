"""Puts the two frames of each triangle of a skin board together, and the triangles to samples."""

from collections.abc import Callable
from functools import partial

from hal.boards.board import Parts, Pulse, board_name
from hal.boards.sensor import MS
from hal.faults import REPEAT_NS
from hal.line import Handler
from hal.readings import SkinSample
from hal.wire import skin
from hal.wire.can import frame_id
from hal.wire.skin import HEAD_TAXELS, TAXELS, TRIANGLES, TriangleError

NO_LOAD = 240  # what the robots set (can-protocol 7.3)
EVERY_TRIANGLE = (1 << TRIANGLES) - 1
HEAD, TAIL = skin.HEAD.code, skin.TAIL.code
DLC = skin.TAIL.layout.dlc
_NOBODY = b""
_ERROR_TEXTS: dict[int, str] = {
    TriangleError.NO_ANSWER: "no answer",
    TriangleError.NOT_CONNECTED: "not connected",
}


class SkinReader:
    """Of one board. A sample is ready when every triangle was heard, or one comes again.

    Errors stand by triangle, whatever the order in which the frames come.
    """

    def __init__(
        self, parts: Parts, period_ms: int, pulse: Pulse, ready: Callable[[SkinSample], None]
    ) -> None:
        self._name = board_name(parts.board)
        self._faults = parts.faults
        self._pulse = pulse
        self._period_ns = period_ms * MS
        self._ready = ready
        self._taxels = bytearray([NO_LOAD] * skin.BOARD_TAXELS)
        self._errors = bytearray(TRIANGLES)
        self._out_of_range = [0] * TRIANGLES
        self._told = bytes(TRIANGLES)
        self._told_ns = -REPEAT_NS
        self.forget()

    def forget(self) -> None:
        """Drop half triangles and an incomplete sample."""
        self._heads = [_NOBODY] * TRIANGLES
        self._head_ns = [0] * TRIANGLES
        self._heard = 0

    def handlers(self, address: int) -> list[tuple[int, Handler]]:
        """Identifiers of the triangles in both classes that skin frames may have."""
        return [
            (frame_id(can_class, address, triangle), partial(self.on_triangle, triangle))
            for can_class in skin.CLASSES
            for triangle in range(TRIANGLES)
        ]

    def on_triangle(self, triangle: int, data: bytes, stamp_ns: int) -> None:
        """Head or tail of a triangle."""
        if len(data) != DLC:
            self._faults.drop("skin frame of wrong length")
        elif data[0] == HEAD:
            if self._heads[triangle]:
                self._faults.drop("head of a triangle without its tail")
            self._heads[triangle] = data
            self._head_ns[triangle] = stamp_ns
        elif data[0] == TAIL:
            head = self._heads[triangle]
            self._heads[triangle] = _NOBODY
            if head and stamp_ns - self._head_ns[triangle] <= self._period_ns:
                self._take(triangle, head, data, stamp_ns)
            else:
                self._faults.drop("tail of a triangle without its head")
        else:
            self._faults.drop("skin frame that is neither head nor tail")

    def _take(self, triangle: int, head: bytes, tail: bytes, stamp_ns: int) -> None:
        bit = 1 << triangle
        if self._heard & bit:  # a new period, and the last one was not complete
            self._publish()
        self._pulse.heard_ns = stamp_ns
        low = tail[7]
        error = low & 0xF
        self._errors[triangle] = error
        if not error:
            first = triangle * TAXELS
            middle = first + HEAD_TAXELS
            self._taxels[first:middle] = head[1:]
            self._taxels[middle : first + TAXELS] = tail[1:6]
            self._out_of_range[triangle] = tail[6] << 4 | low >> 4
        self._heard |= bit
        if self._heard == EVERY_TRIANGLE:
            self._publish()

    def _publish(self) -> None:
        errors = bytes(self._errors)
        if errors != self._told:
            self._tell(errors)
        sample = SkinSample(
            bytes(self._taxels),
            errors,
            tuple(self._out_of_range),
            self._heard,
            self._pulse.heard_ns,
            NO_LOAD,
        )
        self._heard = 0
        self._ready(sample)

    def _tell(self, errors: bytes) -> None:
        """One report names every triangle; a loose contact is reported once a second."""
        now_ns = self._pulse.heard_ns
        if now_ns - self._told_ns < REPEAT_NS:
            return
        self._told, self._told_ns = errors, now_ns
        texts = []
        for error in sorted(set(errors) - {TriangleError.OK}):
            triangles = ", ".join(str(i) for i, found in enumerate(errors) if found == error)
            texts.append(f"{_ERROR_TEXTS.get(error, f'error {error}')}: triangle {triangles}")
        text = "; ".join(texts) or "every triangle answers again"
        self._faults.report(now_ns, f"{self._name}: {text}")
