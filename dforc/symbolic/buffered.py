"""CasADi functions called on fixed numpy buffers: an ordinary call costs 0.1 ms more."""

import casadi as ca
import numpy as np

from dforc.arrays import Matrix, Vector


class BufferedFunction:
    """One CasADi function with its arguments and results in numpy arrays.

    Fill `inputs[name]` in place, call `run`, read `outputs[name]` (overwritten by the next call).
    Matrices stand as CasADi stores them: column by column.
    """

    def __init__(self, function: ca.Function) -> None:
        self.function = function
        self._buffer, self._run = function.buffer()
        self.inputs: dict[str, Vector] = {}
        self.outputs: dict[str, Vector] = {}
        for i in range(function.n_in()):
            values = self.inputs[function.name_in(i)] = np.zeros(function.nnz_in(i))
            self._buffer.set_arg(i, values.data)  # type: ignore[call-arg]  # the stub asks for the size that SWIG takes from the buffer
        for i in range(function.n_out()):
            values = self.outputs[function.name_out(i)] = np.zeros(function.nnz_out(i))
            self._buffer.set_res(i, values.data)  # type: ignore[call-arg]  # as above

    def run(self) -> None:
        """Evaluate."""
        self._run()

    def matrix(self, name: str) -> Matrix:
        """A view of one output in its shape; only for outputs without structural zeros."""
        rows, columns = self.function.size_out(name)
        shaped: Matrix = self.outputs[name].reshape((columns, rows)).T
        return shaped

    def statistics(self) -> dict[str, object]:
        """What a solver function recorded of its last run."""
        found: dict[str, object] = self._buffer.stats()
        return found
