"""A process of the stack as its supervisor sees it."""

import contextlib
import os
import select
import signal
import subprocess
import sys
from collections.abc import Sequence
from pathlib import Path

from services.core.clock import NS_PER_S, Clock
from services.core.errors import NotReadyError, ProcessDiedError

LOOK_EVERY_NS = 10_000_000
TAIL_LINES = 12
# Linear algebra on one thread: results must not depend on the number of cores, and loops not wait.
ONE_THREAD = dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"), "1")


class Child:
    """One `python -m module`, in a session of its own: Ctrl-C on the terminal does not reach it.

    The kernel sends it SIGTERM when the thread that started it ends: start it in the main thread.
    """

    def __init__(
        self, name: str, module: str, arguments: Sequence[str], log: Path, *, speaks: bool = False
    ) -> None:
        """Start it. What it writes goes to the log, but for the standard output if it `speaks`."""
        self.name = name
        self._log = log
        with log.open("wb") as sink:
            self._process = subprocess.Popen(
                [sys.executable, "-m", module, *arguments, "--parent", str(os.getpid())],
                stdin=subprocess.DEVNULL,
                stdout=subprocess.PIPE if speaks else sink,
                stderr=sink,
                env=os.environ | ONE_THREAD,
                start_new_session=True,
            )

    @property
    def pid(self) -> int:
        """Process number."""
        return self._process.pid

    @property
    def failed(self) -> bool:
        """Whether it has ended with a status that is not 0."""
        return self._process.poll() not in (None, 0)

    def ended(self) -> bool:
        """Whether it has ended."""
        return self._process.poll() is not None

    def status(self) -> str:
        """How it ended, in words."""
        status = self._process.poll()
        if status is None:
            return "still running"
        if status < 0:
            return f"signal {signal.Signals(-status).name}"
        return f"exit status {status}"

    def death(self) -> ProcessDiedError:
        """The error that says how it ended, with the end of its log."""
        return ProcessDiedError(self.name, self.status(), self.log_tail())

    def log_tail(self) -> str:
        """The last lines that it wrote."""
        lines = self._log.read_text(encoding="utf-8", errors="replace").splitlines()
        return "\n".join(lines[-TAIL_LINES:])

    def first_line(self, timeout_s: float) -> str:
        """The first line on the standard output of a child that speaks.

        Raises:
            ProcessDiedError: it ended before.
            NotReadyError: it said nothing in time.
        """
        pipe = self._process.stdout
        if pipe is None or not select.select([pipe], [], [], timeout_s)[0]:
            raise NotReadyError(f"{self.name} has said nothing for {timeout_s:g} s")
        line = pipe.readline().decode().strip()
        if not line:
            self._process.wait()
            raise self.death()
        return line

    def terminate(self) -> None:
        """Ask it to end."""
        if not self.ended():
            self._process.terminate()

    def finish(self, clock: Clock, timeout_s: float) -> None:
        """Wait for its end; past the time-out end it by force, with whatever it has started."""
        give_up_ns = clock.now_ns() + round(timeout_s * NS_PER_S)
        while not self.ended() and clock.now_ns() < give_up_ns:
            clock.sleep_until(clock.now_ns() + LOOK_EVERY_NS)
        with contextlib.suppress(ProcessLookupError):
            os.killpg(self.pid, signal.SIGKILL)
        self._process.wait()
        if self._process.stdout is not None:
            self._process.stdout.close()
