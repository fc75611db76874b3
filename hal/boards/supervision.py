"""What a force/torque sensor's samples say of the sensor itself: saturated, frozen, incomplete.

Late and restarted are told apart from these: by the board's liveness and its reset frame.
"""

from hal.faults import FaultLog
from hal.wire import analog

CHANNEL_NAMES = ("Fx", "Fy", "Fz", "Tx", "Ty", "Tz")
FROZEN_NS = 100_000_000
FROZEN_SAMPLES = 20  # a slow sensor may repeat a few


class Supervision:
    """Of one sensor; reports each cause once a second at most, and counts every sample."""

    __slots__ = (
        "_faults",
        "_force",
        "_name",
        "_repeats",
        "_since_ns",
        "_torque",
        "frozen",
        "frozen_samples",
        "saturated_channels",
        "saturated_samples",
    )

    def __init__(self, name: str, faults: FaultLog) -> None:
        self._name = name
        self._faults = faults
        self.saturated_samples = 0
        self.saturated_channels = [0] * analog.CHANNELS  # samples in which each was out of range
        self.frozen_samples = 0
        self.forget()

    def forget(self) -> None:
        """The sensor starts anew."""
        self.frozen = False
        self._force = b""
        self._torque = b""
        self._repeats = 0
        self._since_ns = 0

    def is_frozen(self, force: bytes, torque: bytes, stamp_ns: int) -> bool:
        """Whether all six words have stood still for too long where the gauges' noise moves them.

        Saturated samples are repetitions by design and do not count.
        """
        if torque != self._torque or force != self._force:
            self._force, self._torque = force, torque
            self._since_ns = stamp_ns
            self._repeats = 0
            if self.frozen:
                self.frozen = False
                self._faults.report(stamp_ns, f"{self._name} is no longer frozen")
            return False
        self._repeats += 1
        still_ns = stamp_ns - self._since_ns
        if not self.frozen and still_ns >= FROZEN_NS and self._repeats >= FROZEN_SAMPLES:
            self.frozen = True
            text = (
                f"{self._name} is frozen: one constant sample for {still_ns / 1e9:.3f} s, "
                "internal error of the sensor, switch it off and on"
            )
            self._faults.report(stamp_ns, text)
        self.frozen_samples += self.frozen
        return self.frozen

    def saturation(self, force: int, torque: int, stamp_ns: int) -> tuple[int, ...]:
        """State per channel from the two saturation bytes, reported and counted."""
        channels = analog.saturation_states(force) + analog.saturation_states(torque)
        self.saturated_samples += 1
        which = []
        for index, state in enumerate(channels):
            if state:
                self.saturated_channels[index] += 1
                which.append(f"{CHANNEL_NAMES[index]} {'low' if state == 1 else 'high'}")
        text = f"{self._name} saturated: {', '.join(which) or 'channel not told'}"
        self._faults.report(stamp_ns, text, f"{self._name} saturated")
        return channels

    def lost(self, cause: str, stamp_ns: int, *, running: bool) -> None:
        """A half sample: dropped and counted, and reported once the sensor runs."""
        self._faults.drop(cause)
        if running:
            text = f"{self._name}: {cause}, frames are lost on its bus"
            self._faults.report(stamp_ns, text, f"{self._name} lost a half sample")
