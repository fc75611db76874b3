"""Figures of how a process keeps its time. Statistics only: no decision may rest on them."""

SUB_BITS = 5  # 32 buckets per octave: a value is known to within 1.6 %
SUB_BUCKETS = 1 << SUB_BITS


class Durations:
    """A histogram of durations [ns]: small, and equally quick however many there are."""

    __slots__ = ("_counts", "count")

    def __init__(self) -> None:
        self._counts: dict[int, int] = {}
        self.count = 0

    def add(self, duration_ns: int) -> None:
        """Count one duration; a negative one counts as zero."""
        if duration_ns < 0:
            duration_ns = 0
        shift = duration_ns.bit_length() - SUB_BITS - 1
        bucket = (shift << SUB_BITS) + (duration_ns >> shift) if shift > 0 else duration_ns
        counts = self._counts
        counts[bucket] = counts.get(bucket, 0) + 1
        self.count += 1

    def percentiles_ns(self, *percents: float) -> tuple[float, ...]:
        """For each percentage the duration that so many do not exceed; zeros when there is none."""
        return tuple(self._percentile_ns(percent) for percent in percents)

    def _percentile_ns(self, percent: float) -> float:
        wanted = self.count * percent / 100
        seen = 0
        for bucket in sorted(self._counts):
            seen += self._counts[bucket]
            if seen >= wanted:
                return _middle_ns(bucket)
        return 0.0

    def clear(self) -> None:
        """Start over."""
        self._counts.clear()
        self.count = 0


def _middle_ns(bucket: int) -> float:
    if bucket < 2 * SUB_BUCKETS:
        return float(bucket)
    shift = (bucket >> SUB_BITS) - 1
    low = (bucket - (shift << SUB_BITS)) << shift
    return low + ((1 << shift) - 1) / 2
