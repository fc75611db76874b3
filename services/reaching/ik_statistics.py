"""Counts of searches, as ik/status shows them."""

from collections import Counter, deque

import numpy as np

from dforc.ik.inverse_kinematics import IkResult, IkStatus
from services.reaching.messages import IkStatistics

REMEMBERED = 1000  # searches that the percentiles are taken over


class SearchCount:
    """Of one source of searches."""

    def __init__(self) -> None:
        self.refused = 0
        self.missed = 0
        self._by_status: Counter[IkStatus] = Counter()
        self._iterations: deque[int] = deque(maxlen=REMEMBERED)

    def note(self, result: IkResult, budget: int) -> None:
        """One search has ended."""
        self._by_status[result.status] += 1
        self._iterations.append(result.iterations)
        self.missed += result.iterations >= budget

    def report(self) -> IkStatistics:
        """Everything so far."""
        p50, p99 = np.percentile(self._iterations or (0,), (50, 99)).tolist()
        return IkStatistics(
            solves=self._by_status.total(),
            converged=self._by_status[IkStatus.CONVERGED],
            infeasible=self._by_status[IkStatus.INFEASIBLE],
            out_of_time=self._by_status[IkStatus.OUT_OF_TIME],
            refused=self.refused,
            missed=self.missed,
            iterations_p50=p50,
            iterations_p99=p99,
        )
